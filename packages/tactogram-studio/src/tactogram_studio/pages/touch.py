"""The page Touch: a texture under the hand, played in the browser's audio thread."""

from __future__ import annotations

import json
import shutil
import threading
from collections.abc import Callable, Mapping, Sequence
from dataclasses import asdict
from pathlib import Path
from typing import Any
from urllib.parse import quote

from fastapi import Request
from fastapi.responses import JSONResponse, Response
from nicegui import app, events, ui

from tactogram import models
from tactogram.errors import TactogramError
from tactogram.rendering import WIDTH_MM
from tactogram.signal.io import READABLE
from tactogram.text_files import read_json
from tactogram.validation import validated
from tactogram_studio import kit
from tactogram_studio.context import Studio
from tactogram_studio.layout import without_folder
from tactogram_studio.touch.bundling import element_script
from tactogram_studio.touch.document import texture_document
from tactogram_studio.touch.photographs import keep_drawn
from tactogram_studio.touch.pictures import picture_of
from tactogram_studio.touch.shared_page import shared_page
from tactogram_studio.touch.sources import (
    TextureRequest,
    TouchSources,
    texture_choices,
)
from tactogram_studio.workspace.uploads import SUFFIXES, safe_name, save_upload

MARKUP = Path(__file__).parents[1] / "static" / "touch.html"
UPLOADED = "uploads"
"""Folder of the workspace for dropped files."""
MOST_MIB = 95
_CLONING = threading.Lock()
"""Pages may choose one material at the same time."""


def add(studio: Studio) -> None:
    """Register ``/touch`` and the routes of its script: offers, tables and pictures."""
    sources = TouchSources(studio.workspace, studio.shelf)
    _add_routes(studio, sources)

    @kit.route("/touch")
    def show() -> None:
        ui.add_head_html('<link rel="stylesheet" href="/static/touch.css">')
        with kit.page("Touch"):
            ui.html(MARKUP.read_text(encoding="utf-8"), sanitize=False).classes("w-full")
            with ui.teleport("#touch-sources"):
                _naming(studio)
                _dropping(studio)
                _drawing(studio)
        ui.add_body_html('<script type="module" src="/static/touch.js"></script>')


def parse_request(query: Mapping[str, Any]) -> TextureRequest:
    """Return the request of an address; `ParameterError` if a value is invalid."""
    values = {"speed_mm_s" if name == "speed" else name: value for name, value in query.items()}
    return validated(TextureRequest, values, where="")


def _add_routes(studio: Studio, sources: TouchSources) -> None:
    def respond(made: Callable[[], Response]) -> Response:
        try:
            return made()
        except (TactogramError, OSError) as error:
            return JSONResponse({"error": without_folder(error, studio.workspace.folder)}, status_code=400)

    @app.get("/touch/offers")
    async def offers() -> Response:
        choices = [
            asdict(choice)
            for choice in await kit.in_background(texture_choices, studio.workspace, studio.shelf)
        ]
        return JSONResponse({"offers": choices, "waiting": "" if choices else _waiting(studio)})

    @app.get("/touch/table")
    async def table(request: Request) -> Response:
        def made() -> Response:
            packed = sources.table(parse_request(request.query_params)).packed()
            return Response(packed, media_type="application/octet-stream")

        return await kit.in_background(respond, made)

    @app.get("/touch/shared")
    async def shared(rows: str) -> Response:
        def made() -> Response:
            page = shared_page(rows, sources)
            return _attachment(page.html, page.file_name, "text/html")

        return await kit.in_background(respond, made)

    @app.get("/touch/texture")
    async def texture(request: Request) -> Response:
        def made() -> Response:
            wanted = parse_request(request.query_params)
            table = sources.table(wanted)
            name = f"{safe_name(table.head['name'])}.json"
            return _attachment(texture_document(table, picture_of(sources, wanted)), name, "application/json")

        return await kit.in_background(respond, made)

    @app.get("/touch/tactogram.js")
    def script() -> Response:
        return _attachment(element_script(), "tactogram.js", "text/javascript")

    @app.get("/touch/picture")
    async def picture(request: Request) -> Response:
        def made() -> Response:
            shown = picture_of(sources, parse_request(request.query_params))
            return Response(shown.webp, media_type="image/webp", headers=shown.headers())

        return await kit.in_background(respond, made)


def _attachment(content: str, name: str, media_type: str) -> Response:
    headers = {"Content-Disposition": f"attachment; filename*=UTF-8''{quote(name)}"}
    return Response(content, media_type=media_type, headers=headers)


def _waiting(studio: Studio) -> str:
    """Return why there is nothing to feel yet."""
    match studio.starter.state:
        case "making":
            return "Example surfaces are being simulated; this takes some seconds."
        case "failed":
            return f"{studio.starter.line}. Drop a recording below, or train a run on the page Train."
    return "Nothing to feel yet: drop a recording below, or train a run on the page Train."


def _dropping(studio: Studio) -> None:
    """Draw the field for recordings, which are stored in the workspace, cloned if that is wanted, and selected."""

    async def received(name: str, data: bytes) -> None:
        folder = studio.workspace.inside(UPLOADED)
        path = await kit.in_background(save_upload, folder, name, data, kind="signal")
        if not cloned.value:
            _choose("file", studio.workspace.name_of(path))
            ui.notify(f"{path.name} is stored in the workspace and selected.")
            return
        with kit.busy(f"Cloning {path.stem} …"):
            out = studio.workspace.inside(f"clones/{path.name}")
            run = await kit.in_background(_clone, out, [path], speed=speed.value)
        _choose("run", studio.workspace.name_of(run), path.stem)
        ui.notify(f"{path.stem} is cloned and selected: it follows speed and force.")

    with ui.expansion("Feel a recording of your own"):
        cloned = ui.switch("Clone it, for any speed and force", value=True)
        speed = ui.number("Recorded at, mm/s", min=1, max=2000).props("clearable")
        speed.classes("w-48").bind_visibility_from(cloned, "value")
        ui.label(
            "A clone is generated by texture_flow from the one stroke, in about ten seconds. Otherwise a signal over "
            "time is laid out along the finger's path at its recording's speed, and one over displacement as it is."
        ).classes("quiet")
        kit.file_field("Drop a recording", received, accept=READABLE, most_mib=MOST_MIB)


def _naming(studio: Studio) -> None:
    """Draw the choice of a material that texture_flow comes with, which is cloned at its first use and selected."""

    async def chosen(event: events.ValueChangeEventArguments[Any]) -> None:
        name = str(event.value)
        folder = studio.workspace.inside(f"clones/{name}")
        with kit.busy(f"Making {name} …"):
            await kit.in_background(_clone_material, folder, name)
        _choose("run", studio.workspace.name_of(folder), name)
        ui.notify(f"{name} is selected: it follows speed and force.")

    run = models.shipped_run("texture_flow")
    names = read_json(run / "model.json")["kind"]["materials"] if run else []
    with ui.expansion("Feel an everyday material"):
        select = ui.select(names, label=f"One of {len(names)} materials", with_input=True)
        select.classes("w-full").props('data-everyday="1"')
        select.on_value_change(chosen)
        ui.label(
            "Generated by texture_flow at several speeds and forces, in about ten seconds; a simulation."
        ).classes("quiet")


def _drawing(studio: Studio) -> None:
    """Draw the field for photographs, which are drawn as a relief, kept, and selected."""

    async def received(name: str, data: bytes) -> None:
        width_mm = width.checked(least=1, most=10_000) or WIDTH_MM
        with kit.busy(f"Drawing {name} …"):
            kept = await kit.in_background(keep_drawn, studio.shelf, name, data, width_mm=width_mm)
        _choose("kept", kept.id)
        ui.notify(f"{kept.title}: kept and selected.")

    with ui.expansion("Feel a photograph"):
        width = kit.NumberField("Width that it shows, mm", value=WIDTH_MM)
        width.classes("w-48")
        ui.label(
            "Its brightness becomes a relief, felt along its middle row: crop it to the part to be felt. A design, no "
            "prediction of how the material feels."
        ).classes("quiet")
        refused = "This file is not a picture."
        kit.file_field("Drop a photograph", received, accept=SUFFIXES["image"], refused=refused)


def _choose(*names: str) -> None:
    ui.run_javascript(f"window.tactogramTouch.rows.choose({', '.join(map(json.dumps, names))})")


def _clone(out: Path, recordings: Sequence[Path] = (), **options: Any) -> Path:
    from tactogram.workflows import clone

    return clone(recordings, out=out, **options).folder


def _clone_material(out: Path, name: str) -> None:
    """Clone a material, unless it is there; what an interrupted attempt left is removed."""
    with _CLONING:
        if not (out / "model.json").is_file():
            for folder in (out, out.with_name(f"{out.name}-strokes")):
                shutil.rmtree(folder, ignore_errors=True)
            _clone(out, materials=[name])
