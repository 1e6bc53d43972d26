"""Stimuli of the editor: the grid, the stimuli listed one by one, and the names on pages."""

from __future__ import annotations

from collections.abc import Callable
from functools import partial
from typing import Any

from nicegui import ui

from tactogram_studio.layout import attribute, heading, hint, report_errors
from tactogram_studio.pages.studies.editor.draft import Place
from tactogram_studio.pages.studies.editor.fields import fields_of
from tactogram_studio.pages.studies.editor.stimuli import grid_conditions, listed, named_keys, summary
from tactogram_studio.pages.studies.editor.stimulus_dialog import StimulusForm
from tactogram_studio.pages.studies.editor.widgets import (
    Editor,
    draw_fields,
    draw_table,
    draw_texts,
    icon_button,
    part,
    row_of_list,
)
from tactogram_study.stimuli import StimulusGrid


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
    ui.label("A stimulus for each item in each condition")
    if draft.get(("grid", "numbered")):
        draw_fields(editor, fields_of(StimulusGrid, ("grid",), only=("count",)))
    else:
        _names(editor, "item", ("grid", "items"), redraw)
    _names(editor, "condition", ("grid", "conditions"), redraw)
    source = draw_table(editor, ("grid", "source"), "Source")
    editor.faults.register(("grid",), source)
    for condition in grid_conditions(draft):
        draw_table(editor, ("grid", "by_condition", condition), f"Changes to the source for {condition}")
    hint(
        'A line per setting, as in the study\'s file: file = "{item}.wav". {item} and {condition} are replaced.'
    )

    def list_them() -> None:
        listed(draft)
        editor.changed()
        redraw()

    ui.button("List them one by one", on_click=report_errors(list_them)).props("outline dense")
    hint("Then each can have a source of its own: a kept result, a file, a recording.")


def _names(editor: Editor, kind: str, place: Place, redraw: Callable[[], None]) -> None:
    """Draw the names in a list of the grid, its items or conditions, with buttons to add and remove one."""
    draft = editor.draft
    names = [name for name in draft.get(place, []) if name]

    def resize(changed: list[str]) -> None:
        draft.set(place, changed or None)
        for gone in set(names) - set(changed):
            if draft.get(("grid", "by_condition", gone)) and kind == "condition":
                draft.set(("grid", "by_condition", gone), None)
        editor.changed()
        redraw()

    def add() -> None:
        if (name := (new.value or "").strip()) and name not in names:
            resize([*names, name])

    with ui.row().classes("gap-1"):
        for number, name in enumerate(names):
            with ui.row().classes("chip items-center no-wrap gap-0"):
                ui.label(name)
                rest = [*names[:number], *names[number + 1 :]]
                icon_button("close", f"Remove the {kind} {name}", partial(resize, rest))
    with ui.row().classes("items-end"):
        new = ui.input(f"Another {kind}").props("dense")
        editor.faults.register(place, new)
        ui.button(f"Add the {kind}", on_click=report_errors(add)).props("outline dense")


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
