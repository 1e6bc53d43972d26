"""Stimuli of the editor: the grid, the stimuli listed one by one, and the names on pages."""

from __future__ import annotations

from collections.abc import Callable
from functools import partial
from typing import Any

from nicegui import ui

from tactogram.studio.layout import attribute, heading, hint, report_errors
from tactogram.studio.pages.studies.editor.draft import Place
from tactogram.studio.pages.studies.editor.fields import fields_of
from tactogram.studio.pages.studies.editor.stimuli import listed, named_keys, summary
from tactogram.studio.pages.studies.editor.stimulus_dialog import StimulusForm
from tactogram.studio.pages.studies.editor.widgets import (
    Editor,
    draw_fields,
    draw_texts,
    icon_button,
    part,
    row_of_list,
)
from tactogram.study.stimuli import StimulusGrid


def stimuli(editor: Editor, redraw: Callable[[], None]) -> None:
    """Draw the card of all stimuli."""
    with ui.element("section").classes("card w-full stack"):
        heading("Stimuli")
        if editor.draft.get(("grid",)):
            _grid(editor, redraw)
        part(partial(listed_stimuli, editor, ("stimuli",)))
        with ui.expansion("Names on pages and in reports").classes("w-full"):
            hint("Answers keep the keys; participants and reports see the names.")
            for key in named_keys(editor.draft):
                draw_texts(editor, ("names", key), key)


def _grid(editor: Editor, redraw: Callable[[], None]) -> None:
    draft = editor.draft
    grid = draft.get(("grid",))
    conditions = [one for one in grid.get("conditions", [""]) if one]
    versions = ", ".join(f"as {condition}" for condition in conditions)
    ui.label(f"A stimulus for each item{f': {versions}' if versions else ''}")
    hint(f"Source: {summary(grid.get('source', {}))}")
    for condition, changes in grid.get("by_condition", {}).items():
        hint(f"As {condition}: {summary({**grid.get('source', {}), **changes})}")
    if grid.get("numbered"):
        draw_fields(editor, fields_of(StimulusGrid, ("grid",), only=("count",)))
    else:
        _items(editor, redraw)

    def list_them() -> None:
        listed(draft)
        editor.changed()
        redraw()

    ui.button("List them one by one", on_click=report_errors(list_them)).props("outline dense")
    hint("Then each can have a source of its own: a kept result, a file, a recording.")


def _items(editor: Editor, redraw: Callable[[], None]) -> None:
    draft, place = editor.draft, ("grid", "items")
    items = list(draft.get(place, []))

    def resize(changed: list[str]) -> None:
        draft.set(place, changed)
        editor.changed()
        redraw()

    def add() -> None:
        if (name := (new.value or "").strip()) and name not in items:
            resize([*items, name])

    with ui.row().classes("gap-1"):
        for number, item in enumerate(items):
            with ui.row().classes("chip items-center no-wrap gap-0"):
                ui.label(item)
                rest = [*items[:number], *items[number + 1 :]]
                icon_button("close", f"Remove the item {item}", partial(resize, rest))
    with ui.row().classes("items-end"):
        new = ui.input("Another item").props("dense")
        editor.faults.register(("grid",), new)
        ui.button("Add the item", on_click=report_errors(add)).props("outline dense")


def listed_stimuli(editor: Editor, place: Place, redraw: Callable[[], None]) -> None:
    """Draw the stimuli of a list, each with a button that opens its form."""
    entries = editor.draft.get(place, [])
    for number, stimulus in enumerate(entries):
        name = str(stimulus.get("name", number + 1))
        with row_of_list(editor, (*place, number), name, redraw):
            _stimulus(editor, (*place, number), name, stimulus, redraw)

    def add() -> None:
        names = {one.get("name") for one in entries}
        name = next(f"stimulus{n}" for n in range(1, 1000) if f"stimulus{n}" not in names)
        editor.draft.append(place, {"name": name})
        editor.changed()
        redraw()
        StimulusForm(editor, (*place, len(entries)), redraw)

    ui.button("Add a stimulus", on_click=report_errors(add)).props("outline dense")


def _stimulus(
    editor: Editor, place: Place, name: str, stimulus: dict[str, Any], redraw: Callable[[], None]
) -> None:
    with ui.row().classes("w-full items-center gap-2"):
        # An input, so that it can show the fault of its stimulus.
        shown = ui.input(name, value=summary(stimulus)).props("dense readonly borderless").classes("grow")
        editor.faults.register(place, shown)
        button = ui.button("Change", on_click=lambda: StimulusForm(editor, place, redraw))
        button.props(f'outline dense aria-label="Change {attribute(name)}"')
