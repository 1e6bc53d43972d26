"""Page layout: the frame, error messages, and progress notices."""

from __future__ import annotations

import asyncio
import json
import logging
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from functools import partial
from pathlib import Path
from typing import Any, ParamSpec, TypeVar
from urllib.parse import urlencode

from fastapi.exception_handlers import http_exception_handler
from fastapi.exceptions import RequestValidationError
from nicegui import App, Client, app, ui
from starlette.exceptions import HTTPException
from starlette.requests import Request
from starlette.responses import Response

from tactogram import workflows
from tactogram.errors import TactogramError
from tactogram_study.participants.refusals import sentence_of

P = ParamSpec("P")
T = TypeVar("T")
LOG = logging.getLogger(__name__)

PAGES = {
    "Make": "/make",
    "Touch": "/touch",
    "Edit": "/edit",
    "Materials": "/materials",
    "Train": "/train",
    "Send": "/send",
    "Live": "/live",
    "Studies": "/studies",
    "Reports": "/reports",
}
"""Addresses of the pages, in the order of the navigation."""
RESPONSE_TIMEOUT_S = 120.0
APPEARANCES: dict[str, tuple[str, bool | None]] = {
    "system": ("As the system", None),
    "light": ("Light", False),
    "dark": ("Dark", True),
}
"""Titles of the appearances, and whether they are dark; stored for each browser."""
for field in (ui.input, ui.number, ui.textarea):
    field.default_props("outlined dense")
ui.select.default_props("outlined dense options-dense")
ui.button.default_props("unelevated")
ui.toggle.default_props("unelevated")
ui.expansion.default_props("dense")
ui.tabs.default_props("align=left dense")
HEAD = (
    '<link rel="stylesheet" href="/static/studio.css"><script type="module" src="/static/sliders.js"></script>'
    '<script type="module" src="/static/drop.js"></script>'
)


def route(address: str) -> ui.page:
    """Return the decorator of a function that draws the page at ``address``.

    NiceGUI answers with an error after 3 s, too early for a first visit on a busy machine: it imports what the page
    needs.
    """
    return ui.page(address, response_timeout=RESPONSE_TIMEOUT_S)


def address(path: str, **query: object) -> str:
    """Return the address of a page; empty values of the query are omitted."""
    stated = {name: value for name, value in query.items() if value not in ("", None)}
    return f"{path}?{urlencode(stated, safe=':/')}" if stated else path


def attribute(value: object) -> str:
    """Return what stands for a value between double quotes in an element's properties."""
    return json.dumps(str(value), ensure_ascii=False)[1:-1]


def keep_address(path: str, **query: object) -> None:
    """Name what a page shows in its address, where a reload, the way back and other tabs find it."""
    ui.navigate.history.replace(address(path, **query))


@contextmanager
def page(title: str, *, navigation: bool = True) -> Iterator[ui.dark_mode]:
    """Draw the frame of a page, and give its appearance; what is drawn inside goes into its content column.

    A `TactogramError` inside is shown where it happened, and ends the page there.
    The navigation, omitted if a single study is served, marks the entry of `PAGES` with this title as current.
    """
    ui.page_title(f"{title} · tactogram")
    ui.add_head_html(HEAD)
    ui.html('<a class="skip" href="#content">Skip to the content</a>', sanitize=False)
    ui.colors(primary="#0b5d66", negative="#a4262c", positive="#1e6b34", warning="#8a5a00")
    with ui.element("header").classes("bar"):
        if navigation:
            ui.link("tactogram", "/").classes("brand")
            with ui.element("nav").props('aria-label="Pages"'):
                for name, address in PAGES.items():
                    link = ui.link(name, address)
                    if name == title:
                        link.props('aria-current="page"')
        else:
            ui.label("tactogram").classes("brand")
        dark = _appearance()
    # Quasar draws the main landmark around it.
    with ui.element("div").classes("content").props('id="content" tabindex="-1"'):
        ui.element("h1").classes("title").props(f'data-title="{attribute(title)}"')._text = title
        with ui.column().classes("w-full gap-4 items-stretch"):
            try:
                yield dark
            except (TactogramError, OSError) as error:
                ui.label(str(error)).classes("card refused").props('role="alert"')


def _appearance() -> ui.dark_mode:
    """Draw the choice between light and dark, remembered for this browser."""
    kept = str(app.storage.user.get("appearance"))
    dark = ui.dark_mode()
    items: dict[str, ui.menu_item] = {}

    def choose(name: str) -> None:
        dark.value = APPEARANCES[name][1]
        for other, item in items.items():
            item.props["aria-checked"] = str(other == name).lower()

    def press(name: str) -> None:
        app.storage.user["appearance"] = name
        choose(name)

    with (
        ui.button(icon="contrast").props('flat round dense aria-label="Light or dark"').classes("appearance"),
        ui.menu(),
    ):
        for name, (title, _) in APPEARANCES.items():
            items[name] = ui.menu_item(title, partial(press, name)).props('role="menuitemradio"')
    choose(kept if kept in APPEARANCES else "system")
    if dark.value:
        # NiceGUI's own comes with the first drawing; until then the page would be white.
        ui.add_head_html("<style>body:not(.body--light) { --ground: #12181c; }</style>")
    return dark


def show_error(error: BaseException) -> None:
    """Show an error as a sentence; log unexpected errors, and errors whose page is closed."""
    if isinstance(error, TactogramError | OSError):
        text = str(error)
    else:
        LOG.error("unexpected", exc_info=error)
        text = f"Unexpected error: {type(error).__name__}: {error}. Saved data is unchanged."
    try:
        ui.notify(text, type="negative", multi_line=True, timeout=12_000, close_button="Close")
    except RuntimeError:  # NiceGUI's, if the page was closed in the meantime
        LOG.warning("page closed before this error could be shown: %s", text)


def show_errors(app: App, folder: Path) -> None:
    """Let an application's pages show the errors of their events and timers, and its other routes refuse with one line.

    Paths in what the routes answer are relative to ``folder``.
    """

    def refuse(request: Request, error: Exception) -> Response:
        if isinstance(error, RequestValidationError):
            return Response(sentence_of(error), status_code=422, media_type="text/plain")
        return Response(without_folder(error, folder), status_code=404, media_type="text/plain")

    app.on_exception(show_error)
    app.add_exception_handler(TactogramError, refuse)
    app.add_exception_handler(RequestValidationError, refuse)
    logging.getLogger("nicegui").addFilter(lambda record: not isinstance(record.msg, Exception))


def without_folder(error: Exception, folder: Path) -> str:
    """Return the text of an error with paths relative to a folder; an error of the system without its path."""
    text = (error.strerror or "") if isinstance(error, OSError) else str(error)
    return text.replace(f"{folder}/", "").replace(str(folder), ".")


async def in_background(function: Callable[P, T], /, *args: P.args, **kwargs: P.kwargs) -> T:
    """Return the result of a slow function, called in a thread."""
    return await asyncio.to_thread(function, *args, **kwargs)


async def call_workflow(name: str, /, *args: Any, **kwargs: Any) -> Any:
    """Return the result of a function of `tactogram.workflows`, which is imported, maybe with torch, in the thread."""
    return await in_background(lambda: getattr(workflows, name)(*args, **kwargs))


@contextmanager
def busy(activity: str, *, button: ui.button | None = None) -> Iterator[None]:
    """Show that ``activity`` is in progress, with ``button`` disabled meanwhile."""
    notice = ui.notification(activity, spinner=True, timeout=None, type="ongoing")
    if button is not None:
        button.disable()
    try:
        yield
    finally:
        notice.dismiss()
        if button is not None:
            button.enable()


def add_not_found(*, navigation: bool = True) -> None:
    """Replace NiceGUI's page for unknown addresses; without ``navigation`` there is no start page to return to."""

    @app.exception_handler(404)
    async def not_found(request: Request, error: HTTPException) -> Response:
        if request.scope.get("endpoint") not in (None, app):  # a route's own answer
            return await http_exception_handler(request, error)
        with (
            Client(ui.page(""), request=request) as client,
            page("Page not found", navigation=navigation),
        ):
            ui.label(f"There is no page at {request.url.path[:200]}. Check the address, or go back.")
            with ui.row():
                ui.button("Go back", on_click=ui.navigate.back)
                if navigation:
                    ui.button("Start page", on_click=lambda: ui.navigate.to("/")).props("outline")
        return client.build_response(request, 404)
