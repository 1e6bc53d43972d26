"""Drop zone for a folder or a zip of recordings, which leads to the page that imports it."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from functools import cache
from urllib.parse import unquote, urlencode

from fastapi import HTTPException, Request
from fastapi.responses import JSONResponse
from nicegui import app, ui
from starlette.datastructures import UploadFile

from tactogram.errors import TactogramError
from tactogram_studio import kit
from tactogram_studio.server.guard_rules import RECEIVED
from tactogram_studio.workspace.folder import Workspace
from tactogram_studio.workspace.received import MOST_FILES, MOST_SENT, ReceivedFolders

HEAD = '<link rel="stylesheet" href="/static/receive.css"><script type="module" src="/static/receive.js"></script>'
INPUT = '<input type="file" hidden data-receive-input="{0}" {1}>'


@cache
def add_routes(workspace: Workspace) -> None:
    """Register the route that takes the files, once."""

    @app.post(RECEIVED)
    async def receive(request: Request) -> JSONResponse:
        try:
            async with request.form(max_files=MOST_FILES, max_fields=0) as form:
                sent = [each for each in form.getlist("file") if isinstance(each, UploadFile)]
                files = [(unquote(each.filename or ""), each.file) for each in sent]
                folder = await kit.in_background(ReceivedFolders(workspace).keep, files)
        except (TactogramError, OSError) as error:
            return JSONResponse({"problem": str(error)}, 422)
        except HTTPException as error:  # Starlette's, of a form that is none
            return JSONResponse({"problem": str(error.detail)}, 422)
        return JSONResponse({"page": import_address(workspace.name_of(folder))})


def import_address(folder: str) -> str:
    """Return the address of the page that imports a folder of the workspace."""
    return f"/materials/import?{urlencode({'folder': folder})}"


@contextmanager
def drop_zone(*, whole_page: bool = False) -> Iterator[None]:
    """Draw a place that takes folders and zips, on a page with `HEAD`; what is drawn in the context belongs to it.

    Of a ``whole_page`` it is seen only when something is dragged over it.
    """
    with ui.element("div").classes("receive bare" if whole_page else "receive") as zone:
        zone.props(f'data-receive="{RECEIVED}" data-most-files="{MOST_FILES}" data-most-bytes="{MOST_SENT}"')
        yield


def draw_chooser() -> None:
    """Draw the buttons that open a folder or a zip, and the progress, within a drop zone."""
    with ui.row().classes("items-center gap-3"):
        for kind, text in (("folder", "Choose a folder"), ("zip", "Choose a zip file")):
            ui.button(text).props(f'outline data-receive-choose="{kind}"')
        for kind, more in (("folder", "webkitdirectory multiple"), ("zip", 'accept=".zip"')):
            ui.html(INPUT.format(kind, more), sanitize=False)
    draw_status()


def draw_status(text: str = "") -> None:
    """Draw the place of progress and refusals within a drop zone, with a text until then."""
    kit.hint(text).props('data-receive-status role="status"')
