"""Cards and the texts in them, tables, and dialogs."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from types import MappingProxyType
from typing import Any

from nicegui import ui

from tactogram.errors import Message, Remedy, TactogramError
from tactogram_studio.layout import attribute

INKS = ("#0b5d66", "#b3541e", "#5b4a9e", "#1e6b34", "#a4262c", "#5a6470", "#8a5a00", "#1f5fa8", "#a1267f")
"""Colours of curves; each has a contrast of at least 4.5:1 on white."""
Cell = str | Callable[[], Any]
"""A text, or what draws the content."""


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
            section.props["aria-label"] = name
        if live:
            section.props('aria-live="polite"')
        if title:
            heading(title)
        yield section


def column(*, gap: int = 4, live: bool = False) -> ui.column:
    """Draw a column as wide as its place, such as that of a result, whose changes are read out if it is ``live``."""
    drawn = ui.column().classes(f"w-full gap-{gap} items-stretch")
    return drawn.props('aria-live="polite"') if live else drawn


def title_row(title: str, simulated: object = False, text: str = "simulated") -> ui.row:
    """Draw the heading of a card with the mark of simulated data, and return its row, where more can go."""
    with ui.row().classes("w-full items-center gap-2") as row:
        heading(title).style("overflow-wrap: anywhere")
        mark_simulated(simulated, text)
    return row


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


def in_fields(
    error: Exception | str, labels: Mapping[str, str], titles: Mapping[str, str] = MappingProxyType({})
) -> str:
    """Return a message with a page's fields instead of arguments: their ``labels``, and the ``titles`` of values."""
    message = error if isinstance(error, str) else getattr(error, "message", str(error))

    def field(remedy: Remedy) -> str:
        if remedy.parameter not in labels:
            return str(remedy)
        value = "" if remedy.value is None else f": {titles.get(str(remedy.value), remedy.value)}"
        return f"{remedy.advice} “{labels[remedy.parameter]}”{value}"

    return message.in_words(field, labels) if isinstance(message, Message) else message


def code(text: str = "") -> ui.label:
    """Draw a command."""
    return ui.label(text).classes("code")


def command_lines(commands: Sequence[str]) -> None:
    """Draw the commands that do the same, to be unfolded."""
    with ui.expansion("Equivalent command").classes("w-full"):
        for command in commands:
            code(command)


def icon_button(icon: str, name: str, press: Any) -> ui.button:
    """Draw a button with an icon alone, and its name for screen readers."""
    button = ui.button(icon=icon, on_click=press).props("flat round dense")
    return button.props(f'aria-label="{attribute(name)}" title="{attribute(name)}"')


async def confirm(question: str, action: str) -> bool:
    """Ask before something irreversible; return whether the user chose the button ``action``."""
    with ui.dialog().props('aria-label="Are you sure?"') as dialog, ui.card().classes("max-w-lg"):
        ui.label(question)
        with ui.row().classes("justify-end w-full"):
            ui.button("Cancel", on_click=lambda: dialog.submit(False)).props("outline autofocus")
            ui.button(action, color="negative", on_click=lambda: dialog.submit(True))
    confirmed = bool(await dialog)
    if dialog.is_deleted:  # the page was closed
        return False
    dialog.delete()
    return confirmed


@contextmanager
def form_dialog(title: str, action: str, done: Callable[[], Any], *, label: str = "") -> Iterator[ui.dialog]:
    """Open a dialog whose form is drawn inside; the button ``action`` calls ``done``, which closes it at its end.

    The dialog stays when the part of the page that it was opened from is drawn anew.
    """
    with (
        ui.context.client.content,
        ui.dialog(value=True).props(f'aria-label="{attribute(label or title)}"') as dialog,
        ui.card().classes("w-96 max-w-full"),
    ):
        heading(title)
        yield dialog
        with ui.row().classes("justify-end w-full"):
            ui.button("Cancel", on_click=dialog.close).props("flat")
            ui.button(action, on_click=done)
    dialog.on("hide", dialog.delete)


def ask_title(title: str, most: int, rename: Callable[[str], Any]) -> None:
    """Ask for another title of at most so many characters, and call ``rename`` with it, unless it stays."""

    async def done() -> None:
        if field.value != title:
            result = rename(str(field.value))
            if result is not None:
                await result
        dialog.close()

    with form_dialog("Rename", "Rename", done) as dialog:
        field = ui.input("Title", value=title).classes("w-full").props("autofocus")
        field.props["maxlength"] = most
        field.on("keydown.enter", done)


def table(
    headings: Sequence[str],
    rows: Iterable[Sequence[Cell]],
    *,
    caption: str = "",
    hidden: bool = False,
    classes: str = "people",
) -> None:
    """Draw a table whose rows are named by their first cells; a ``hidden`` caption is for screen readers alone."""
    with ui.element("div").classes("w-full overflow-x-auto"), ui.element("table").classes(classes):
        if caption:
            how = "sr-only" if hidden else "quiet small text-left"
            ui.element("caption").classes(how)._text = caption
        table_head(headings)
        with ui.element("tbody"):
            for row in rows:
                with ui.element("tr"):
                    for number, cell in enumerate(row):
                        element = ui.element("td") if number else ui.element("th").props('scope="row"')
                        if isinstance(cell, str):
                            element._text = cell
                        else:
                            with element:
                                cell()


def line_chart(
    curves: Mapping[str, Sequence[Sequence[float]]], *, x: str, log_scale: bool = False, bold: str = ""
) -> dict[str, Any]:
    """Return the options of an ECharts chart of curves by name, points each; ``x`` names the horizontal axis.

    ``log_scale`` applies only if all values are positive.
    """
    positive = all(value > 0 for points in curves.values() for _, value in points)
    return {
        "animation": False,
        "color": list(INKS),
        "aria": {"enabled": True},
        "grid": {"left": 60, "right": 20, "top": 48, "bottom": 45},
        "legend": {"show": True, "top": 0, "type": "scroll"},
        "tooltip": {"trigger": "axis"},
        "xAxis": {
            "type": "value",
            "name": x,
            "nameLocation": "middle",
            "nameGap": 28,
            "min": 0,
            "max": "dataMax",
        },
        "yAxis": {"type": "log" if log_scale and positive else "value", "scale": True},
        "series": [
            {
                "type": "line",
                "name": name,
                "showSymbol": len(points) < 3,
                "lineStyle": {"width": 3 if name == bold else 1.5},
                "data": [list(point) for point in points],
            }
            for name, points in curves.items()
        ],
    }


def table_head(headings: Sequence[str]) -> None:
    """Draw the headings of a table."""
    with ui.element("thead"), ui.element("tr"):
        for name in headings:
            ui.element("th").props('scope="col"')._text = name
