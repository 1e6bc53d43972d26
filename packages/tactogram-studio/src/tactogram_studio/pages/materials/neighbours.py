"""Similar recordings and predicted material of a signal, by a classifier of the workspace or by spectrum."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

from nicegui import app, ui

from tactogram.errors import TactogramError
from tactogram.signal import Signal
from tactogram.workflows import find_similar
from tactogram_studio import kit
from tactogram_studio.pages.materials.media import draw_recording
from tactogram_studio.pages.materials.recordings import open_named
from tactogram_studio.workspace.folder import Workspace
from tactogram_studio.workspace.runs import RunCatalogue

SPECTRAL = ""
COUNT = 8
SHOWN_NAMES = 8


def draw_similar(
    workspace: Workspace, signal: Signal, *, set_name: str, stream: str = "", without: Sequence[str] = ()
) -> None:
    """Draw a choice of similarity measures, with the predicted material and the most similar recordings below.

    The store ``set_name`` is relative to the workspace; recordings with an id in ``without`` are left out.
    """
    runs = [run.name for run in RunCatalogue(workspace).own("classification")]
    stored = app.storage.user.get("near", runs[0] if runs else SPECTRAL)
    options = {SPECTRAL: "spectral distance (no classifier)", **{run: f"classifier {run}" for run in runs}}
    with kit.card("Similar recordings"):
        measure = ui.select(options, label="Compare by", value=stored if stored in options else SPECTRAL)
        measure.classes("w-full max-w-lg")
        if not runs:
            ui.link("Train a classifier to predict the material", "/train?model=stroke_cnn").classes("small")
        place = kit.column(gap=1).props('aria-live="polite"')

        async def show() -> None:
            run = app.storage.user["near"] = measure.value
            place.clear()
            try:
                if run != SPECTRAL:
                    with kit.busy("Classifying the recording"):
                        prediction = await kit.in_background(_classify, workspace, run, signal)
                    with place:
                        _draw_prediction(prediction)
                with kit.busy("Searching for similar recordings; the first search reads the whole store"):
                    similar = await kit.in_background(
                        _search, workspace, run, signal, set_name, stream, tuple(without)
                    )
                with place:
                    _draw_recordings(workspace, similar, set_name)
            except TactogramError as error:
                with place:
                    kit.alert(str(error))

        measure.on_value_change(show)
        ui.timer(0.05, show, once=True)


def _search(
    workspace: Workspace, run: str, signal: Signal, set_name: str, stream: str, without: tuple[str, ...]
) -> dict[str, Any]:
    store = open_named(workspace, set_name)
    if run == SPECTRAL:
        cache = workspace.studio_folder / "spectra"
        return find_similar(
            store, signal, stream=stream or None, count=COUNT, without=without, cache=cache
        ) | {"unit": "dB"}
    from tactogram.workflows import (
        calibration_text,
        search,  # brings torch
    )

    result = search(workspace.inside(run), signal, data=store.path, count=COUNT + len(without))
    nearest = [each for each in result["nearest"] if each["id"] not in without][:COUNT]
    measure = (
        "Distance in the classifier's last hidden layer; 1: two recordings of one material. A signal farther than "
        f"{result['threshold']:.3g} from the nearest recording, the limit of {result['nearest'][0]['material']}, is "
        "none of these. "
        f"{calibration_text(result['calibrated_on'])}"
    )
    return {"nearest": nearest, "measure": measure, "unit": ""}


def _classify(workspace: Workspace, run: str, signal: Signal) -> dict[str, Any]:
    from tactogram.workflows import classify  # brings torch

    return classify(workspace.inside(run), signal)


def _draw_prediction(prediction: dict[str, Any]) -> None:
    unknown = prediction["none_of_these"]
    with ui.row().classes("items-center gap-2"):
        verdict = "None of these" if unknown else f"Classified as {prediction['material']}"
        ui.label(verdict).classes("text-weight-bold").props("data-verdict")
        kit.mark_simulated(prediction["simulated"], "classifier trained on simulated data")
    if unknown:
        ui.label(
            "The signal resembles no material that the classifier knows; the probabilities below only compare those."
        ).classes("small")
    with ui.element("div").classes("likely w-full"):
        for name, share in list(prediction["probabilities"].items())[:SHOWN_NAMES]:
            ui.label(name).style("overflow-wrap: anywhere")
            bar = ui.element("div").classes("bar-of").props('aria-hidden="true"')
            bar.style(f"width: {100 * share:.1f}%")
            ui.label(f"{100 * share:.1f} %")


def _draw_recordings(workspace: Workspace, similar: dict[str, Any], set_name: str) -> None:
    kit.hint(similar["measure"])
    store = open_named(workspace, set_name)
    with ui.element("div").classes("w-full"):
        for each in similar["nearest"]:
            distance = f"{each['distance']:.2f} dB" if similar["unit"] == "dB" else f"{each['distance']:.4f}"
            draw_recording(set_name, store, store.info(each["id"]), note=distance)
