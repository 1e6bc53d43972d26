"""Recordings on the materials pages: pictures, sounds and rows, and those most similar to a signal."""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping, Sequence
from contextlib import suppress
from dataclasses import replace
from typing import Annotated, Any

from fastapi import Header, Response
from nicegui import app, ui

from tactogram.datasets import RecordingInfo, Store
from tactogram.errors import TactogramError
from tactogram.signal import Signal
from tactogram.workflows import find_similar
from tactogram_studio import kit
from tactogram_studio.signals.pictures import spectrogram_png
from tactogram_studio.signals.registry import ValueCache
from tactogram_studio.signals.sound import range_response, sound_of
from tactogram_studio.signals.traits import SignalTraits, scales_of, traits_of, unit_text
from tactogram_studio.signals.view import draw_scale
from tactogram_studio.workspace.folder import Workspace
from tactogram_studio.workspace.recordings import (
    PICTURE_S,
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

HEAD = (
    '<link rel="stylesheet" href="/static/materials.css"><link rel="stylesheet" href="/static/signals.css">'
)
KEPT = {"cache-control": "private, max-age=86400"}
"""A recording never changes under its id."""
SPECTRAL = ""
COMPARED_BY = "near"
"""Key of the chosen classifier, or `SPECTRAL`, in the browser's storage."""
COUNT = 8
SHOWN_NAMES = 8
STARTS: ValueCache[SignalTraits] = ValueCache(32 * 2**20, lambda traits: traits.level.nbytes)
"""Traits of what small pictures show."""


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
    def spectrogram(set: str, id: str, stream: str = "", top_db: float | None = None) -> Response:
        traits = start_traits(open_named(workspace, set), id, stream)
        scales = scales_of([traits])
        if top_db is not None and math.isfinite(top_db):
            scales = replace(scales, top_db=top_db)
        return content(spectrogram_png(traits, width=240, height=56, scales=scales), "image/png")

    @app.get("/materials/sound")
    def sound(set: str, id: str, stream: str = "", range: Annotated[str | None, Header()] = None) -> Response:
        store = open_named(workspace, set)
        signal = store.signal(id, stream_of(store, id, stream))
        return content(sound_of(signal).wav, "audio/wav", range)


def start_traits(store: Store, id: str, stream: str = "") -> SignalTraits:
    """Return the traits of a recording's start, as of `recording_start`."""
    name = stream_of(store, id, stream)
    key = (store.path, store.sha256, id, name)
    return STARTS.get(key, lambda: traits_of(recording_start(store, id, name)))


def starts_of(store: Store, infos: Iterable[RecordingInfo], stream: str = "") -> dict[str, SignalTraits]:
    """Return the traits of the starts of recordings by id, those that can be read; slow."""
    starts = {}
    for info in infos:
        with suppress(TactogramError, OSError):
            starts[info.id] = start_traits(store, info.id, stream)
    return starts


def draw_recordings(
    set_name: str,
    store: Store,
    infos: Sequence[RecordingInfo],
    starts: Mapping[str, SignalTraits],
    *,
    stream: str = "",
    notes: Mapping[str, str] | None = None,
) -> None:
    """Draw recordings as rows, their spectrograms on a common scale for each unit, with a bar above.

    ``set_name`` is relative to the workspace; ``starts`` are those of `starts_of`, and ``notes``, such as distances, go
    next to the materials.
    """
    by_unit: dict[str, list[SignalTraits]] = {}
    for traits in starts.values():
        by_unit.setdefault(unit_text(traits.unit), []).append(traits)
    tops = {unit: scales_of(each).top_db for unit, each in by_unit.items()}
    for unit, top in tops.items():
        draw_scale(top, unit, title="Spectrograms:")
    for info in infos:
        start, note = starts.get(info.id), (notes or {}).get(info.id, "")
        top_db = None if start is None else tops[unit_text(start.unit)]
        _draw_recording(set_name, store, info, start, stream=stream, top_db=top_db, note=note)


def _draw_recording(
    set_name: str,
    store: Store,
    info: RecordingInfo,
    start: SignalTraits | None,
    *,
    stream: str,
    top_db: float | None,
    note: str,
) -> None:
    """Draw a recording as a row: photograph, link and metadata, waveform, spectrogram, sound."""
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
            if start is not None and not start.felt:
                whole = store.length(info.id, name) <= PICTURE_S * store.rate(info.id, name)
                kit.alert("Cannot be felt." if whole else "Its beginning cannot be felt.").classes("small")
        query = {"set": set_name, "id": info.id, "stream": name}
        picture(address("trace", **query), f"Waveform of {name}, {title}")
        picture(address("spectrogram", **query, top_db=top_db), f"Spectrogram of {name}, {title}")
        sound = ui.element("audio").props('controls preload="none"')
        sound.props.update({"src": address("sound", **query), "aria-label": f"Play {title}"})


def picture(source: str, text: str) -> None:
    """Draw a picture that loads when it scrolls into view."""
    ui.element("img").props(f'src="{kit.attribute(source)}" alt="{kit.attribute(text)}" loading="lazy"')


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
    stored = app.storage.user.get(COMPARED_BY, runs[0] if runs else SPECTRAL)
    options = {SPECTRAL: "spectral distance (no classifier)", **{run: f"classifier {run}" for run in runs}}
    with kit.card("Similar recordings"):
        measure = ui.select(options, label="Compare by", value=stored if stored in options else SPECTRAL)
        measure.classes("w-full max-w-lg")
        if not runs:
            ui.link("Train a classifier to predict the material", "/train?purpose=recognition")
        results = kit.column(gap=1).props('aria-live="polite"')

        async def show() -> None:
            run = app.storage.user[COMPARED_BY] = measure.value
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
                    store = open_named(workspace, set_name)
                    nearest = [store.info(each["id"]) for each in similar["nearest"]]
                    shown = stream if run == SPECTRAL else ""  # a classifier has a stream of its own
                    starts = await kit.in_background(starts_of, store, nearest, shown)
                if run == measure.value:
                    with results:
                        kit.hint(similar["measure"])
                        form = "{:.2f} dB" if similar["unit"] == "dB" else "{:.4f}"
                        notes = {each["id"]: form.format(each["distance"]) for each in similar["nearest"]}
                        with ui.element("div").classes("w-full"):
                            draw_recordings(set_name, store, nearest, starts, stream=shown, notes=notes)
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
