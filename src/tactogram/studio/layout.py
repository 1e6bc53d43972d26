"""Page layout: the frame, error messages, and progress of long work."""

from __future__ import annotations

import asyncio
import functools
import html
import inspect
import logging
import math
from collections.abc import Callable, Coroutine, Iterator
from contextlib import contextmanager
from typing import Any, ParamSpec, TypeVar

from nicegui import ui
from nicegui.elements.column import Column

from tactogram.errors import ParameterError, TactogramError

P = ParamSpec("P")
T = TypeVar("T")
LOG = logging.getLogger(__name__)

PAGES = {
    "Make": "/make",
    "Touch": "/touch",
    "Materials": "/materials",
    "Train": "/train",
    "Send": "/send",
    "Live": "/live",
    "Studies": "/studies",
    "Reports": "/reports",
}
"""What the navigation names, and where it leads."""
CHOOSER = """<div class="chooser">
<span>{text}</span>
<q-btn no-caps outline label="Choose a file" aria-label="Choose a file: {text}" @click="props.pickFiles" />
<span hidden><q-uploader-add-trigger /></span>
</div>"""
"""Quasar's own button of an upload is a link around an input, without a name."""
HEAD = '<link rel="stylesheet" href="/static/studio.css"><script type="module" src="/static/sliders.js"></script>'


@contextmanager
def page(title: str, *, wide: bool = False, navigation: bool = True) -> Iterator[Column]:
    """Draw the frame of a page, and give the column that its content goes into.

    Parameters
    ----------
    title : str
        Its heading; one of `PAGES` is marked as the present page.
    wide : bool
        Whether the content takes the whole width.
    navigation : bool
        Whether the other pages are named: not where one study is served alone.
    """
    ui.page_title(f"{title} · tactogram")
    ui.add_head_html(HEAD)
    ui.html('<a class="skip" href="#content">Skip to the content</a>', sanitize=False)
    ui.colors(primary="#0b5d66", negative="#a4262c", positive="#1e6b34", warning="#8a5a00")
    with ui.element("header").classes("bar"):
        if navigation:
            ui.link("tactogram", "/").classes("brand")
            _navigation(title)
        else:
            ui.label("tactogram").classes("brand")
    width = "content wide" if wide else "content"
    # Quasar draws the main landmark around it.
    with ui.element("div").classes(width).props('id="content" tabindex="-1"'):
        ui.element("h1").classes("title").props(f'data-title="{title}"')._text = title
        with ui.column().classes("w-full gap-4 items-stretch") as column:
            yield column


def _navigation(title: str) -> None:
    with ui.element("nav").props('aria-label="Pages"'):
        for name, address in PAGES.items():
            link = ui.link(name, address)
            if name == title:
                link.props('aria-current="page"')


def upload(text: str, **options: Any) -> ui.upload:
    """Draw where a file is dropped or chosen; it is sent at once.

    Parameters
    ----------
    text : str
        What is to be given; plain, without markup.
    **options : Any
        As `nicegui.ui.upload` takes them.
    """
    drawn = ui.upload(auto_upload=True, **options).props("flat bordered")
    drawn.add_slot("header", CHOOSER.format(text=html.escape(text)))
    return drawn


class NumberField(ui.number):
    """A field for a number that leaves it as it was typed; `given` refuses what cannot be used.

    NiceGUI's own pulls a number to the nearer of its ends when the field is left, without a word.
    """

    def sanitize(self) -> None:
        """Leave it."""

    def given(self, *, least: float = -math.inf, most: float = math.inf, whole: bool = False) -> float | None:
        """Return the number, None where the field is empty.

        Raises
        ------
        ParameterError
            Naming the field, if it is not what is asked for.
        """
        return in_range(self.label or "number", self.value, least=least, most=most, whole=whole)


def in_range(
    name: str, value: float | None, *, least: float = -math.inf, most: float = math.inf, whole: bool = False
) -> float | None:
    """Return ``value`` if it lies in ``least`` to ``most`` and is whole where it must be; None stays None.

    Raises
    ------
    ParameterError
        Otherwise.
    """
    if value is None:
        return None
    if whole and not float(value).is_integer():
        raise ParameterError(f"{name} must be a whole number, got {value:g}")
    if not least <= value <= most:
        asked = f"at least {least:g}" if most == math.inf else f"{least:g} to {most:g}"
        raise ParameterError(f"{name} must be {asked}, got {value:g}")
    return value


def show_error(error: BaseException) -> None:
    """Show an error as a sentence; what nobody expected, or who left the page cannot read, is logged."""
    if isinstance(error, TactogramError | OSError):
        text = str(error)
    else:
        LOG.error("unexpected", exc_info=error)
        text = f"Something unexpected went wrong: {type(error).__name__}: {error}. Nothing kept was touched."
    try:
        ui.notify(text, type="negative", multi_line=True, timeout=12_000, close_button="Close")
    except RuntimeError:  # NiceGUI's, where the page was left meanwhile
        LOG.warning("nobody was left to be told: %s", text)


def report_errors(handler: Callable[P, Any]) -> Callable[P, Any]:
    """Return a handler of events, plain or asynchronous, whose errors are told; a lambda may call either."""
    if asyncio.iscoroutinefunction(handler):

        @functools.wraps(handler)
        async def waited(*args: P.args, **kwargs: P.kwargs) -> Any:
            try:
                return await handler(*args, **kwargs)
            except Exception as error:
                show_error(error)

        return waited

    @functools.wraps(handler)
    def called(*args: P.args, **kwargs: P.kwargs) -> Any:
        try:
            answer = handler(*args, **kwargs)
        except Exception as error:
            return show_error(error)
        return report_errors(_answered)(answer) if inspect.iscoroutine(answer) else answer

    return called


async def _answered(answer: Coroutine[Any, Any, T]) -> T:
    return await answer


async def in_background(function: Callable[P, T], /, *args: P.args, **kwargs: P.kwargs) -> T:
    """Return what a function returns that takes long, calling it in a thread."""
    return await asyncio.to_thread(function, *args, **kwargs)


@contextmanager
def busy(what: str, *, button: ui.button | None = None) -> Iterator[Callable[[str], None]]:
    """Show that something is being done, and give a function that says how far it is.

    Parameters
    ----------
    what : str
        Such as ``generating``.
    button : ui.button, optional
        That is disabled meanwhile.
    """
    notice = ui.notification(what, spinner=True, timeout=None, type="ongoing")
    if button is not None:
        button.disable()

    def say(text: str) -> None:
        notice.message = text

    try:
        yield say
    finally:
        notice.dismiss()
        if button is not None:
            button.enable()
