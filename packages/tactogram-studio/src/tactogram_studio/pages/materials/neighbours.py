"""Similar recordings and predicted material of a signal, by a classifier of the workspace or by spectrum."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

from nicegui import app, ui

from tactogram.errors import TactogramError
from tactogram.models import available
from tactogram.signal import Signal
from tactogram.workflows import find_similar
from tactogram_studio.layout import busy, heading, hint, in_background, report_errors
from tactogram_studio.pages.materials.media import MaterialsContext, draw_recording
from tactogram_studio.pages.train.run_summary import run_summary

SPECTRAL = ""
COUNT = 8
SHOWN_NAMES = 8


def classifiers(context: MaterialsContext) -> list[str]:
    """Return the finished runs of classifiers, newest first."""
    models = available()
    workspace = context.studio.workspace
    names = []
    for run in workspace.finished_runs():
        model = models.get(run_summary(run).model)
        if model is not None and model.task == "classification":
            names.append(workspace.name_of(run))
    return names


def draw_similar(
    context: MaterialsContext, signal: Signal, *, set_name: str, stream: str = "", without: Sequence[str] = ()
) -> None:
    """Draw a choice of similarity measures, with the predicted material and the most similar recordings below.

    The store ``set_name`` is relative to the workspace; recordings with an id in ``without`` are left out.
    """
    runs = classifiers(context)
    stored = app.storage.user.get("near", runs[0] if runs else SPECTRAL)
    options = {SPECTRAL: "spectral distance (no classifier)", **{run: f"classifier {run}" for run in runs}}
    with ui.element("section").classes("card w-full").props('aria-label="Similar recordings"'):
        heading("Similar recordings")
        measure = ui.select(options, label="Compare by", value=stored if stored in options else SPECTRAL)
        measure.classes("w-full max-w-lg")
        if not runs:
            ui.link("Train a classifier to predict the material", "/train?model=stroke_cnn").classes("small")
        place = ui.column().classes("w-full gap-1 items-stretch").props('aria-live="polite"')

        async def show() -> None:
            run = app.storage.user["near"] = measure.value
            place.clear()
            try:
                if run != SPECTRAL:
                    with busy("Classifying the recording"):
                        prediction = await in_background(_classify, context, run, signal)
                    with place:
                        _draw_prediction(prediction)
                with busy("Searching for similar recordings; the first search reads the whole store"):
                    similar = await in_background(
                        _search, context, run, signal, set_name, stream, tuple(without)
                    )
                with place:
                    _draw_recordings(context, similar, set_name)
            except TactogramError as error:
                with place:
                    ui.label(str(error)).props('role="alert"')

        measure.on_value_change(report_errors(show))
        ui.timer(0.05, report_errors(show), once=True)


def _search(
    context: MaterialsContext, run: str, signal: Signal, set_name: str, stream: str, without: tuple[str, ...]
) -> dict[str, Any]:
    workspace = context.studio.workspace
    store = context.store(set_name)
    if run == SPECTRAL:
        cache = workspace.studio_folder / "spectra"
        return find_similar(
            store, signal, stream=stream or None, count=COUNT, without=without, cache=cache
        ) | {"unit": "dB"}
    # Brings torch.
    from tactogram.workflows import calibration_text, search

    result = search(workspace.inside(run), signal, data=store.path, count=COUNT + len(without))
    nearest = [each for each in result["nearest"] if each["id"] not in without][:COUNT]
    measure = (
        "Distance in the classifier's last hidden layer; 1: two recordings of one material. A signal farther than "
        f"{result['threshold']:.3g} from the nearest recording, the limit of {result['nearest'][0]['material']}, is "
        "none of these. "
        f"{calibration_text(result['calibrated_on'])}"
    )
    return {"nearest": nearest, "measure": measure, "unit": ""}


def _classify(context: MaterialsContext, run: str, signal: Signal) -> dict[str, Any]:
    from tactogram.workflows import classify  # brings torch

    return classify(context.studio.workspace.inside(run), signal)


def _draw_prediction(prediction: dict[str, Any]) -> None:
    unknown = prediction["none_of_these"]
    with ui.row().classes("items-center gap-2"):
        verdict = "None of these" if unknown else f"Classified as {prediction['material']}"
        ui.label(verdict).classes("text-weight-bold").props("data-verdict")
        if prediction["simulated"]:
            ui.label("classifier trained on simulated data").classes("simulated")
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


def _draw_recordings(context: MaterialsContext, similar: dict[str, Any], set_name: str) -> None:
    hint(similar["measure"])
    store = context.store(set_name)
    with ui.element("div").classes("w-full"):
        for each in similar["nearest"]:
            distance = f"{each['distance']:.2f} dB" if similar["unit"] == "dB" else f"{each['distance']:.4f}"
            draw_recording(set_name, store, store.info(each["id"]), note=distance)
