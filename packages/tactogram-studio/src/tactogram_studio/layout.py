"""Page layout: the frame, headings, number fields, error messages, and progress notices."""

from __future__ import annotations

import asyncio
import functools
import html
import inspect
import logging
import math
from collections.abc import Awaitable, Callable, Iterator
from contextlib import contextmanager
from functools import partial
from typing import Any, ParamSpec, TypeVar

from nicegui import app, ui

from tactogram.errors import ParameterError, TactogramError

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
CHOOSER = """<div class="chooser">
<span>{text}</span>
<q-btn no-caps outline label="Choose a file" aria-label="Choose a file: {text}" @click="props.pickFiles" />
<span hidden><q-uploader-add-trigger /></span>
</div>"""
"""Replaces the button of Quasar's uploader, which is a link around an input, without an accessible name."""
RESPONSE_TIMEOUT_S = 120.0
APPEARANCES: dict[str, tuple[str, bool | None]] = {
    "system": ("As the system", None),
    "light": ("Light", False),
    "dark": ("Dark", True),
}
"""Titles of the appearances, and whether they are dark; stored for each browser."""
HEAD = '<link rel="stylesheet" href="/static/studio.css"><script type="module" src="/static/sliders.js"></script>'


def route(address: str) -> ui.page:
    """Return the decorator of a function that draws the page at ``address``.

    NiceGUI answers with an error after 3 s, too early for a first visit on a busy machine: it imports what the page
    needs.
    """
    return ui.page(address, response_timeout=RESPONSE_TIMEOUT_S)


@contextmanager
def page(title: str, *, wide: bool = False, navigation: bool = True) -> Iterator[ui.dark_mode]:
    """Draw the frame of a page, and give its appearance; what is drawn inside goes into its content column.

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
    width = "content wide" if wide else "content"
    # Quasar draws the main landmark around it.
    with ui.element("div").classes(width).props('id="content" tabindex="-1"'):
        ui.element("h1").classes("title").props(f'data-title="{title}"')._text = title
        with ui.column().classes("w-full gap-4 items-stretch"):
            yield dark


def _appearance() -> ui.dark_mode:
    """Draw the choice between light and dark, remembered for this browser."""
    kept = str(app.storage.user.get("appearance"))
    dark = ui.dark_mode()
    items: dict[str, ui.menu_item] = {}

    def choose(name: str) -> None:
        dark.value = APPEARANCES[name][1]
        for other, item in items.items():
            item.props(f'aria-checked="{str(other == name).lower()}"')

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


def heading(text: str) -> ui.label:
    """Draw the heading of a section."""
    return ui.label(text).classes("h2").props('role="heading" aria-level="2"')


def hint(text: str) -> ui.label:
    """Draw a small explanation."""
    return ui.label(text).classes("small quiet")


def attribute(text: str) -> str:
    """Return a text that is safe between double quotes in an element's properties."""
    return text.replace("\\", "/").replace('"', "'").replace("\n", " ")


def upload(text: str, **options: Any) -> ui.upload:
    """Draw a field with a prompt where a file is dropped or chosen; ``options`` as for `nicegui.ui.upload`."""
    field = ui.upload(auto_upload=True, **options).props("flat bordered")
    field.add_slot("header", CHOOSER.format(text=html.escape(text)))
    return field


class NumberField(ui.number):
    """A number field that leaves bad input as typed; `checked` refuses it.

    NiceGUI's own field silently moves a number into its range when it loses focus.
    """

    def sanitize(self) -> None:
        """Leave the value unchanged."""

    def checked(
        self, *, least: float = -math.inf, most: float = math.inf, whole: bool = False
    ) -> float | None:
        """Return the number, or None if the field is empty; raise `ParameterError` naming the field as `in_range`."""
        return in_range(self.label or "number", self.value, least=least, most=most, whole=whole)


def in_range(
    name: str, value: float | None, *, least: float = -math.inf, most: float = math.inf, whole: bool = False
) -> float | None:
    """Return ``value`` unchanged, None included.

    Raises `ParameterError` if it is outside ``least`` to ``most``, or a fraction although ``whole``.
    """
    if value is None:
        return None
    if whole and not float(value).is_integer():
        raise ParameterError(f"{name} must be a whole number, got {value:g}")
    if not least <= value <= most:
        bounds = f"at least {least:g}" if most == math.inf else f"{least:g} to {most:g}"
        raise ParameterError(f"{name} must be {bounds}, got {value:g}")
    return value


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


def report_errors(handler: Callable[P, Any]) -> Callable[P, Any]:
    """Return an event handler that shows its errors on the page; it may be asynchronous or return an awaitable."""

    async def awaited(result: Awaitable[Any]) -> Any:
        try:
            return await result
        except Exception as error:
            show_error(error)

    @functools.wraps(handler)
    def called(*args: P.args, **kwargs: P.kwargs) -> Any:
        try:
            result = handler(*args, **kwargs)
        except Exception as error:
            return show_error(error)
        return awaited(result) if inspect.iscoroutine(result) else result

    return called


async def in_background(function: Callable[P, T], /, *args: P.args, **kwargs: P.kwargs) -> T:
    """Return the result of a slow function, called in a thread."""
    return await asyncio.to_thread(function, *args, **kwargs)


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


async def confirm(question: str, action: str) -> bool:
    """Ask before something irreversible; return whether the user chose the button ``action``."""
    with ui.dialog().props('aria-label="Are you sure?"') as dialog, ui.card().classes("max-w-lg"):
        ui.label(question)
        with ui.row().classes("justify-end w-full"):
            ui.button("Cancel", on_click=lambda: dialog.submit(False)).props("no-caps outline autofocus")
            ui.button(action, color="negative", on_click=lambda: dialog.submit(True)).props("no-caps")
    confirmed = bool(await dialog)
    if dialog.is_deleted:  # the page was closed
        return False
    dialog.delete()
    return confirmed
