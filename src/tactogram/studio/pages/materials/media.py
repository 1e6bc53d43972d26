"""Pictures and sounds of the materials pages, and rows of recordings."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Annotated, Any
from urllib.parse import urlencode

from fastapi import Header, Response
from nicegui import app, ui

from tactogram.datasets import RecordingInfo, Store
from tactogram.errors import TactogramError
from tactogram.studio.context import Studio
from tactogram.studio.pages.materials.recordings import (
    StoreCache,
    picture_of,
    recording_excerpt,
    shown_value,
    stream_of,
    thumbnail,
    trace_svg,
)
from tactogram.studio.pages.train.trainings import TaskQueue
from tactogram.studio.signals.byte_ranges import answer_of
from tactogram.studio.signals.pictures import spectrogram_png
from tactogram.studio.signals.sound import sound_bytes
from tactogram.studio.signals.traits import traits_of

HEAD = '<link rel="stylesheet" href="/static/materials.css">'
KEPT = {"cache-control": "private, max-age=86400"}
"""Of what follows from a recording's id: the same for good."""


@dataclass
class MaterialsContext:
    """Context of the materials pages."""

    studio: Studio
    trainings: TaskQueue
    stores: StoreCache


def address(page: str, **query: Any) -> str:
    """Return the address of a page or picture below ``/materials``."""
    kept = {name: value for name, value in query.items() if value not in ("", None)}
    return f"/materials/{page}?{urlencode(kept)}"


def add_routes(desk: MaterialsContext) -> None:
    """Register small pictures and sounds of recordings."""

    def answered(make: Callable[[], bytes], kind: str, asked: str | None = None) -> Response:
        try:
            return answer_of(make(), asked, kind=kind, headers=KEPT)
        except (TactogramError, OSError) as error:
            return Response(str(error), status_code=404, media_type="text/plain")

    @app.get("/materials/picture")
    def picture(set: str, key: str, size: int = 160) -> Response:
        return answered(lambda: thumbnail(desk.stores.get(set), key, size=size), "image/jpeg")

    @app.get("/materials/trace")
    def trace(set: str, id: str, stream: str = "") -> Response:
        return answered(
            lambda: trace_svg(recording_excerpt(desk.stores.get(set), id, stream)), "image/svg+xml"
        )

    @app.get("/materials/spectrogram")
    def spectrogram(set: str, id: str, stream: str = "") -> Response:
        def make() -> bytes:
            traits = traits_of(recording_excerpt(desk.stores.get(set), id, stream))
            return spectrogram_png(traits, width=240, height=56)

        return answered(make, "image/png")

    @app.get("/materials/sound")
    def sound(set: str, id: str, stream: str = "", range: Annotated[str | None, Header()] = None) -> Response:
        def make() -> bytes:
            store = desk.stores.get(set)
            name = stream_of(store, id, stream)
            return sound_bytes(store.signal(id, name))

        return answered(make, "audio/wav", range)


def draw_recording(
    set_name: str, store: Store, info: RecordingInfo, *, stream: str = "", beside: str = ""
) -> None:
    """Draw a recording as a row: photograph, waveform, spectrogram, sound, what is known, a link to all of it.

    Parameters
    ----------
    set_name : str
        The data set's path relative to the workspace.
    store : Store
    info : RecordingInfo
    stream : str
    beside : str
        Said beside its material, such as a distance.
    """
    called = info.material or "no material"
    photographs = bool(store.photograph_keys())
    with ui.element("div").classes("recording" if photographs else "recording bare"):
        key = picture_of(store, info)
        if key is not None:
            picture(address("picture", set=set_name, key=key, size=112), f"Photograph of {called}")
        elif photographs:
            ui.element("div").classes("none").tooltip("no photograph")
        with ui.element("div").classes("known"):
            with ui.row().classes("items-center gap-2"):
                ui.link(called, address("recording", set=set_name, id=info.id, stream=stream)).style(
                    "overflow-wrap: anywhere"
                )
                if beside:
                    ui.label(beside).classes("small")
                if info.simulated:
                    ui.label("simulated").classes("simulated")
            ui.label(summary(info)).classes("small quiet").style("overflow-wrap: anywhere")
        name = stream_of(store, info.id, stream)
        picture(address("trace", set=set_name, id=info.id, stream=name), f"Waveform of {name}, {called}")
        picture(
            address("spectrogram", set=set_name, id=info.id, stream=name), f"Spectrogram of {name}, {called}"
        )
        source = address("sound", set=set_name, id=info.id, stream=name)
        ui.element("audio").props(
            f'controls preload="none" src="{source}" aria-label="Play {_plain(called)}"'
        )


def picture(source: str, text: str) -> None:
    """Draw a picture that is fetched when it comes into view."""
    ui.element("img").props(f'src="{source}" alt="{_plain(text)}" loading="lazy"')


def summary(info: RecordingInfo) -> str:
    """Return what is known of a recording in a line."""
    parts = [
        f"{shown_value(info, name)} {unit}"
        for name, unit in (("speed_mm_s", "mm/s"), ("force_n", "N"))
        if shown_value(info, name)
    ]
    parts += [value for name in ("contactor", "session", "subject") if (value := shown_value(info, name))]
    return " · ".join([*parts, info.source or info.id])


def facts_list(facts: Mapping[str, str]) -> None:
    """Draw names and texts as a list of definitions."""
    with ui.element("dl").classes("facts"):
        for name, text in facts.items():
            ui.element("dt")._text = name
            ui.element("dd")._text = text


def _plain(text: str) -> str:
    """Return a text for an attribute between double quotes."""
    return text.replace("\\", "").replace('"', "'")
