"""Neighbours and class of a signal, by a trained classifier of the workspace or by its spectrum alone."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

from nicegui import app, ui

from tactogram.errors import TactogramError
from tactogram.models import available
from tactogram.signal import Signal
from tactogram.studio.layout import busy, in_background, report_errors
from tactogram.studio.pages.materials.media import MaterialsContext, draw_recording
from tactogram.studio.pages.train.run_facts import run_facts
from tactogram.workflows.recognition.spectral_search import find_similar

SPECTRAL = ""
COUNT = 8
SHOWN_NAMES = 8


def classifiers(desk: MaterialsContext) -> list[str]:
    """Return the finished runs of classifiers, newest first."""
    models = available()
    workspace = desk.studio.workspace
    found = []
    for run in workspace.finished_runs():
        facts = models.get(run_facts(run).model)
        if facts is not None and facts.task == "classification":
            found.append(workspace.name_of(run))
    return found


def draw_near(
    desk: MaterialsContext, signal: Signal, *, set_name: str, stream: str = "", without: Sequence[str] = ()
) -> None:
    """Draw the choice of a measure, and below it what is near and how it is called.

    Parameters
    ----------
    desk : MaterialsDesk
    signal : Signal
        As recorded.
    set_name : str
        The data set that is searched, relative to the workspace.
    stream : str
    without : sequence of str
        Ids that are left out.
    """
    runs = classifiers(desk)
    kept = app.storage.user.get("near", runs[0] if runs else SPECTRAL)
    with ui.element("section").classes("card w-full").props('aria-label="What is near"'):
        ui.label("What is near").classes("h2").props('role="heading" aria-level="2"')
        options = {
            SPECTRAL: "spectral distance (no classifier)",
            **{run: f"classifier {run}" for run in runs},
        }
        measure = ui.select(options, label="Measured by", value=kept if kept in options else SPECTRAL)
        measure.classes("w-full max-w-lg")
        if not runs:
            ui.link("Train a classifier to be told names", "/train?model=stroke_cnn").classes("small")
        place = ui.column().classes("w-full gap-1 items-stretch").props('aria-live="polite"')

        async def look() -> None:
            app.storage.user["near"] = measure.value
            place.clear()
            asked = (desk, measure.value, signal, set_name, stream, tuple(without))
            try:
                if measure.value != SPECTRAL:
                    with busy("asking the classifier"):
                        named = await in_background(_named, desk, measure.value, signal)
                    with place:
                        _draw_names(named)
                with busy("looking for what is near: the first time, every recording is gone through"):
                    found = await in_background(_found, *asked)
                with place:
                    _draw_nearest(desk, found, set_name)
            except TactogramError as error:
                with place:
                    ui.label(str(error)).props('role="alert"')

        measure.on_value_change(report_errors(look))
        ui.timer(0.05, report_errors(look), once=True)


def _found(
    desk: MaterialsContext, run: str, signal: Signal, set_name: str, stream: str, without: tuple[str, ...]
) -> dict[str, Any]:
    workspace = desk.studio.workspace
    store = desk.stores.get(set_name)
    if run == SPECTRAL:
        cache = workspace.own / "spectra"
        return find_similar(
            store, signal, stream=stream or None, count=COUNT, without=without, cache=cache
        ) | {"unit": "dB"}
    # Brings torch.
    from tactogram.workflows.recognition.search import search
    from tactogram.workflows.training.surface_index import calibration_text

    near = search(workspace.inside(run), signal, data=store.path, count=COUNT + len(without))
    nearest = [each for each in near["nearest"] if each["id"] not in without][:COUNT]
    measure = (
        f"cosine distance of the classifier's last hidden layer, 0 to 2; beyond {near['threshold']:.3g} it is none of "
        f"the materials it knows. {calibration_text(near['calibrated_on'])}"
    )
    return {"nearest": nearest, "measure": measure, "unit": ""}


def _named(desk: MaterialsContext, run: str, signal: Signal) -> dict[str, Any]:
    from tactogram.workflows.recognition.classify import classify  # brings torch

    return classify(desk.studio.workspace.inside(run), signal)


def _draw_names(found: dict[str, Any]) -> None:
    with ui.row().classes("items-center gap-2"):
        verdict = "None of these" if found["none_of_these"] else f"It is called {found['material']}"
        ui.label(verdict).classes("text-weight-bold").props("data-verdict")
        if found["simulated"]:
            ui.label("the classifier learned from simulated data").classes("simulated")
    if found["none_of_these"]:
        ui.label(
            "It is unlike all that the classifier knows; the probabilities below only share it out among those."
        ).classes("small")
    with ui.element("div").classes("likely w-full"):
        for name, share in list(found["probabilities"].items())[:SHOWN_NAMES]:
            ui.label(name).style("overflow-wrap: anywhere")
            ui.element("div").classes("bar-of").style(f"width: {100 * share:.1f}%").props(
                'aria-hidden="true"'
            )
            ui.label(f"{100 * share:.1f} %")


def _draw_nearest(desk: MaterialsContext, found: dict[str, Any], set_name: str) -> None:
    ui.label(found["measure"]).classes("small quiet")
    store = desk.stores.get(set_name)
    with ui.element("div").classes("w-full"):
        for each in found["nearest"]:
            beside = f"{each['distance']:.2f} dB" if found["unit"] == "dB" else f"{each['distance']:.4f}"
            draw_recording(set_name, store, store.info(each["id"]), beside=beside)
