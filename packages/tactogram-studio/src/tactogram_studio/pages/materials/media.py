"""Pictures, sounds and rows of recordings on the materials pages."""

from __future__ import annotations

from collections.abc import Callable
from typing import Annotated, Any
from urllib.parse import urlencode

from fastapi import Header, Response
from nicegui import app, ui

from tactogram.datasets import RecordingInfo, Store
from tactogram.errors import TactogramError
from tactogram_studio import kit
from tactogram_studio.pages.materials.recordings import (
    UNITS,
    open_named,
    picture_of,
    recording_start,
    shown_value,
    stream_of,
    thumbnail,
    trace_svg,
)
from tactogram_studio.signals.pictures import spectrogram_png
from tactogram_studio.signals.sound import range_response, sound_of
from tactogram_studio.signals.traits import traits_of
from tactogram_studio.workspace.folder import Workspace

HEAD = '<link rel="stylesheet" href="/static/materials.css">'
KEPT = {"cache-control": "private, max-age=86400"}
"""A recording never changes under its id."""


def address(page: str, **query: Any) -> str:
    """Return the address of a page or picture below ``/materials``."""
    query = {name: value for name, value in query.items() if value not in ("", None)}
    return f"/materials/{page}?{urlencode(query)}"


def add_routes(workspace: Workspace) -> None:
    """Register the routes of recordings' small pictures and sounds."""

    def respond(make: Callable[[], bytes], kind: str, byte_range: str | None = None) -> Response:
        try:
            return range_response(make(), byte_range, media_type=kind, headers=KEPT)
        except (TactogramError, OSError) as error:
            return Response(str(error), status_code=404, media_type="text/plain")

    @app.get("/materials/picture")
    def picture(set: str, key: str, size: int = 160) -> Response:
        return respond(lambda: thumbnail(open_named(workspace, set), key, size=size), "image/jpeg")

    @app.get("/materials/trace")
    def trace(set: str, id: str, stream: str = "") -> Response:
        return respond(
            lambda: trace_svg(recording_start(open_named(workspace, set), id, stream)), "image/svg+xml"
        )

    @app.get("/materials/spectrogram")
    def spectrogram(set: str, id: str, stream: str = "") -> Response:
        def make() -> bytes:
            traits = traits_of(recording_start(open_named(workspace, set), id, stream))
            return spectrogram_png(traits, width=240, height=56)

        return respond(make, "image/png")

    @app.get("/materials/sound")
    def sound(set: str, id: str, stream: str = "", range: Annotated[str | None, Header()] = None) -> Response:
        def make() -> bytes:
            store = open_named(workspace, set)
            name = stream_of(store, id, stream)
            return sound_of(store.signal(id, name)).wav

        return respond(make, "audio/wav", range)


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
