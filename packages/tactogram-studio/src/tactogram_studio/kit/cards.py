"""Cards and the texts in them: headings, hints, marks of simulated data, refusals, commands."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from typing import Any

from nicegui import ui

from tactogram.errors import TactogramError


def attribute(text: str) -> str:
    """Return a text that is safe between double quotes in an element's properties."""
    return text.replace("\\", "/").replace('"', "'").replace("\n", " ")


def heading(text: str) -> ui.label:
    """Draw the heading of a section."""
    return ui.label(text).classes("h2").props('role="heading" aria-level="2"')


def hint(text: str) -> ui.label:
    """Draw a small explanation."""
    return ui.label(text).classes("small quiet")


@contextmanager
def card(
    title: str = "", *, label: str | None = None, classes: str = "w-full", live: bool = False
) -> Iterator[ui.element]:
    """Draw a card with a heading; what is drawn inside goes into it.

    ``label`` names it for screen readers, by default as the heading. Changes in a ``live`` card are read out.
    """
    with ui.element("section").classes(f"card {classes}") as section:
        if name := title if label is None else label:
            section.props(f'aria-label="{attribute(name)}"')
        if live:
            section.props('aria-live="polite"')
        if title:
            heading(title)
        yield section


def column(*, gap: int = 4, live: bool = False) -> ui.column:
    """Draw a column as wide as its place, such as that of a result, whose changes are read out if it is ``live``."""
    drawn = ui.column().classes(f"w-full gap-{gap} items-stretch")
    return drawn.props('aria-live="polite"') if live else drawn


def mark_simulated(simulated: object, text: str = "simulated") -> None:
    """Draw the mark of simulated data, if it is."""
    if simulated:
        ui.label(text).classes("simulated")


def alert(text: str = "") -> ui.label:
    """Draw the place of a refusal, which is read out."""
    return ui.label(text).classes("text-negative").props('role="alert"')


@contextmanager
def refusals(place: ui.label, wording: Callable[[Exception], str] = str) -> Iterator[None]:
    """Show the errors of what is done inside, in a ``wording``, at a place drawn by `alert`, and end that."""
    place.text = ""
    try:
        yield
    except (TactogramError, OSError, ValueError) as error:
        place.text = wording(error)


def code(text: str = "") -> ui.element:
    """Draw a command; `set_text` changes it."""
    element = ui.element("code").classes("small")
    element.style("overflow-wrap: anywhere; display: block; min-height: 1.2em")
    element._text = text
    return element


def set_text(element: ui.element, text: str) -> None:
    """Change the text of an element that is no label."""
    element._text = text
    element.update()


def command_lines(commands: Sequence[str]) -> None:
    """Draw the commands that do the same, to be unfolded."""
    with ui.expansion("Equivalent command").classes("w-full"):
        for command in commands:
            ui.label(command).classes("code")


def icon_button(icon: str, name: str, press: Any) -> ui.button:
    """Draw a button with an icon alone, and its name for screen readers."""
    button = ui.button(icon=icon, on_click=press).props("flat round dense")
    return button.props(f'aria-label="{attribute(name)}" title="{attribute(name)}"')
