"""Tables of a page."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence
from typing import Any

from nicegui import ui

Cell = str | Callable[[], Any]
"""A text, or what draws the content."""


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


def table_head(headings: Sequence[str]) -> None:
    """Draw the headings of a table."""
    with ui.element("thead"), ui.element("tr"):
        for name in headings:
            ui.element("th").props('scope="col"')._text = name
