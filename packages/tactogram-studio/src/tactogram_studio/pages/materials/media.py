"""Recordings on the materials pages: pictures, sounds and rows, and those most similar to a signal."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Annotated, Any

from fastapi import Header, Response
from nicegui import app, ui

from tactogram.datasets import RecordingInfo, Store
from tactogram.errors import TactogramError
from tactogram.signal import Signal
from tactogram.workflows import find_similar
from tactogram_studio import kit
from tactogram_studio.signals.pictures import spectrogram_png
from tactogram_studio.signals.sound import range_response, sound_of
from tactogram_studio.signals.traits import traits_of
from tactogram_studio.workspace.folder import Workspace
from tactogram_studio.workspace.recordings import (
    UNITS,
    open_named,
    picture_of,
    recording_start,
    shown_value,
    stream_of,
    thumbnail,
    trace_svg,
)
from tactogram_studio.workspace.runs import RunCatalogue

HEAD = '<link rel="stylesheet" href="/static/materials.css">'
KEPT = {"cache-control": "private, max-age=86400"}
"""A recording never changes under its id."""
SPECTRAL = ""
COUNT = 8
SHOWN_NAMES = 8


def address(page: str, **query: Any) -> str:
    """Return the address of a page or picture below ``/materials``."""
    return kit.address(f"/materials/{page}", **query)


def add_routes(workspace: Workspace) -> None:
    """Register the routes of recordings' small pictures and sounds."""

    def content(data: bytes, kind: str, byte_range: str | None = None) -> Response:
        return range_response(data, byte_range, media_type=kind, headers=KEPT)

    @app.get("/materials/picture")
    def picture(set: str, key: str, size: int = 160) -> Response:
        return content(thumbnail(open_named(workspace, set), key, size=size), "image/jpeg")

    @app.get("/materials/trace")
    def trace(set: str, id: str, stream: str = "") -> Response:
        return content(trace_svg(recording_start(open_named(workspace, set), id, stream)), "image/svg+xml")

    @app.get("/materials/spectrogram")
    def spectrogram(set: str, id: str, stream: str = "") -> Response:
        traits = traits_of(recording_start(open_named(workspace, set), id, stream))
        return content(spectrogram_png(traits, width=240, height=56), "image/png")

    @app.get("/materials/sound")
    def sound(set: str, id: str, stream: str = "", range: Annotated[str | None, Header()] = None) -> Response:
        store = open_named(workspace, set)
        signal = store.signal(id, stream_of(store, id, stream))
        return content(sound_of(signal).wav, "audio/wav", range)


def draw_recording(
    set_name: str, store: Store, info: RecordingInfo, *, stream: str = "", note: str = ""
) -> None:
    """Draw a recording as a row: photograph, link and metadata, waveform, spectrogram, sound.

    ``set_name`` is relative to the workspace; ``note``, such as a distance, goes next to the material.
    """
    title = info.material or "no material"
    name = stream_of(store, info.id, stream)
    photographs = bool(store.photograph_keys())
    with ui.element("div").classes("recording" if photographs else "recording bare"):
        key = picture_of(store, info)
        if key is not None:
            picture(address("picture", set=set_name, key=key, size=112), f"Photograph of {title}")
        elif photographs:
            ui.element("div").classes("none").tooltip("no photograph")
        with ui.element("div").classes("metadata"):
            with ui.row().classes("items-center gap-2"):
                link = ui.link(title, address("recording", set=set_name, id=info.id, stream=stream))
                link.style("overflow-wrap: anywhere")
                if note:
                    ui.label(note).classes("small")
                kit.mark_simulated(info.simulated)
            kit.hint(summary(info)).style("overflow-wrap: anywhere")
        query = {"set": set_name, "id": info.id, "stream": name}
        picture(address("trace", **query), f"Waveform of {name}, {title}")
        picture(address("spectrogram", **query), f"Spectrogram of {name}, {title}")
        source = address("sound", **query)
        ui.element("audio").props(
            f'controls preload="none" src="{source}" aria-label="Play {kit.attribute(title)}"'
        )


def picture(source: str, text: str) -> None:
    """Draw a picture that loads when it scrolls into view."""
    ui.element("img").props(f'src="{source}" alt="{kit.attribute(text)}" loading="lazy"')


def summary(info: RecordingInfo) -> str:
    """Return the conditions and source of a recording in a line."""
    names = ("speed_mm_s", "force_n", "contactor", "session", "subject")
    values = {name: value for name in names if (value := shown_value(info, name))}
    parts = [f"{value} {UNITS.get(name, '')}".strip() for name, value in values.items()]
    return " · ".join([*parts, info.source or info.id])


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
            ui.link("Train a classifier to predict the material", "/train?model=stroke_statistics").classes(
                "small"
            )
        results = kit.column(gap=1).props('aria-live="polite"')

        async def show() -> None:
            run = app.storage.user["near"] = measure.value
            results.clear()
            try:
                if run != SPECTRAL:
                    with kit.busy("Classifying the recording"):
                        prediction = await kit.call_workflow("classify", workspace.inside(run), signal)
                    if run != measure.value:  # another comparison has begun
                        return
                    with results:
                        _draw_prediction(prediction)
                with kit.busy("Searching for similar recordings; the first search reads the whole store"):
                    similar = await kit.in_background(
                        _search, workspace, run, signal, set_name, stream, tuple(without)
                    )
                if run == measure.value:
                    with results:
                        _draw_recordings(workspace, similar, set_name)
            except TactogramError as error:
                if run == measure.value:
                    with results:
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
        "Distance in the classifier's embedding; 1: two recordings of one material. A signal farther than "
        f"{result['threshold']:.3g} from the nearest recording, the limit of {result['nearest'][0]['material']}, is "
        "none of these. "
        f"{calibration_text(result['calibrated_on'])}"
    )
    return {"nearest": nearest, "measure": measure, "unit": ""}


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
