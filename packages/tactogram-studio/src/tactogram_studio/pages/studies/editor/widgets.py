"""Widgets of the editor's fields: each changes the draft at its place, and shows its fault."""

from __future__ import annotations

import json
import tomllib
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import tomli_w
from nicegui import app, ui
from nicegui.elements.mixins.validation_element import ValidationElement

from tactogram.validation import Fault
from tactogram_studio import kit
from tactogram_studio.context import Studio
from tactogram_studio.study_draft.draft import StudyDraft
from tactogram_studio.study_draft.fields import Place, StudyField
from tactogram_study.wording import own_name

TYPED = "debounce=300"
"""Of fields that are typed into: a change is checked after a pause, in ms."""
LONG = ("consent", "instructions", "reference")
"""Texts of several lines."""
Redraw = Callable[[], None]
STATE = "studies_edited"
"""Key of the drafts in the browser's storage, by file."""


class FaultMarks:
    """Widgets by place, each of which can show a fault."""

    def __init__(self) -> None:
        self._widgets: dict[Place, ValidationElement[Any]] = {}

    def register(self, place: Place, widget: ValidationElement[Any]) -> None:
        """Let a widget show the faults at a place."""
        self._widgets[place] = widget

    def show(self, faults: Sequence[Fault]) -> None:
        """Show each fault at the widget of its place or of the nearest table around it, and clear all others."""
        self._widgets = {place: field for place, field in self._widgets.items() if not field.is_deleted}
        sentences: dict[Place, str] = {}
        for fault in faults:
            place = fault.place
            while place and place not in self._widgets:
                place = place[:-1]
            sentences.setdefault(place, fault.sentence)
        for place, widget in self._widgets.items():
            if widget.error != (sentence := sentences.get(place)):
                widget.error = sentence


class Editor:
    """Draft of a study's file, which survives a reload, with the widgets that show its faults."""

    def __init__(self, studio: Studio, path: Path) -> None:
        self.studio, self.name = studio, studio.workspace.name_of(path)
        self.drafts: dict[str, Any] = app.storage.user.setdefault(STATE, {})
        self.draft = StudyDraft.open(path, self.drafts.get(self.name))
        self.faults = FaultMarks()

    def put(self, place: Place, value: Any) -> None:
        """Change the draft at a place, where None removes, and check it."""
        self.draft.set(place, value)
        self.changed()

    def changed(self) -> None:
        """Keep the draft and check it."""
        self.drafts[self.name] = self.draft.to_store()
        self.check()

    def check(self) -> None:
        """Check the draft, and show the result."""
        raise NotImplementedError

    def redraw(self) -> None:
        """Draw the whole form anew."""
        raise NotImplementedError


def part(draw: Callable[[Redraw], None]) -> None:
    """Draw a part of the page that can be drawn anew; ``draw`` gets the function that does it."""
    box = kit.column(gap=2)

    def redraw() -> None:
        box.clear()
        with box:
            draw(redraw)

    redraw()


def draw_fields(editor: Editor, fields: Sequence[StudyField]) -> None:
    """Draw fields: texts one below the other, then the others, side by side where there is room."""
    for field in fields:
        if field.widget == "texts":
            draw_field(editor, field)
    with ui.element("div").classes("texts w-full"):
        for field in fields:
            if field.widget != "texts":
                draw_field(editor, field)


def draw_field(editor: Editor, field: StudyField) -> None:
    """Draw one field with its help."""
    if field.widget == "texts":
        draw_texts(editor, field.place, field.label, default=field.default, help=field.help)
        return

    def change(entry: Any) -> None:
        # A default is not written: the file holds what differs.
        editor.put(field.place, None if entry == field.default else entry)

    with kit.column(gap=0):
        draw_entry(editor, field, editor.draft.get(field.place, field.default), change)
        if field.help:
            kit.hint(field.help)


def draw_entry(editor: Editor, field: StudyField, value: Any, change: Callable[[Any], None]) -> None:
    """Draw the widget of a field, which calls ``change`` with its entry."""
    if field.widget == "numbers":
        value = ", ".join(f"{number:g}" for number in value or ())
    widget = kit.declared_field(field, field.label, value, lambda entry: change(_entry(field, entry)))
    if field.widget != "switch":
        editor.faults.register(field.place, widget)


def draw_choice(
    editor: Editor,
    place: Place,
    label: str,
    options: Sequence[str] | Mapping[str, str],
    change: Callable[[Any], Any],
    **more: Any,
) -> ui.select:
    """Draw a choice that shows the faults at its place and calls ``change`` with its entry."""
    shown = dict(options) if isinstance(options, Mapping) else list(dict.fromkeys(options))
    select = ui.select(shown, label=label, on_change=lambda event: change(event.value), **more)
    editor.faults.register(place, select.classes("w-full"))
    return select


def draw_texts(editor: Editor, place: Place, label: str, *, default: Any = None, help: str = "") -> None:
    """Draw a text in each of the study's languages, side by side."""
    with kit.column(gap=0):
        with ui.element("div").classes("texts w-full"):
            for language in editor.draft.languages:
                _text(editor, place, label, language, default)
        if help:
            kit.hint(help)


def _text(editor: Editor, place: Place, label: str, language: str, default: Any) -> None:
    title = f"{label} ({own_name(language)})" if len(editor.draft.languages) > 1 else label
    long = place[-1] in LONG

    def change(event: Any) -> None:
        editor.draft.set_text(place, language, event.value or "", default)
        editor.changed()

    value = editor.draft.text(place, language, default)
    widget = (ui.textarea if long else ui.input)(title, value=value, on_change=change)
    widget.props(f'{TYPED} lang="{kit.attribute(language)}"').props("autogrow" if long else "")
    editor.faults.register((*place, language), widget)


def draw_table(editor: Editor, place: Place, label: str) -> ui.textarea:
    """Draw a table as lines of the study's file, and return the widget."""
    value = editor.draft.get(place, {})
    text = value if isinstance(value, str) else "\n".join(lines_of(value))
    area = ui.textarea(label, value=text)
    area.on_value_change(lambda event: editor.put(place, table_of(event.value or "") or None))
    editor.faults.register(place, area.props(f"{TYPED} autogrow").classes("w-full"))
    return area


def lines_of(table: Mapping[str, Any]) -> list[str]:
    """Return a table as lines of TOML; those of a table within begin with its key, so that their order is free."""
    lines: list[str] = []
    for key, value in table.items():
        if isinstance(value, dict):
            lines += [f"{key}.{line}" for line in lines_of(value)]
        else:
            lines.append(tomli_w.dumps({key: value}).strip())
    return lines


def table_of(text: str) -> dict[str, Any] | str:
    """Return the table of lines of TOML; the text itself if it is none, and the check refuses it."""
    try:
        table = tomllib.loads(text)
        json.dumps(table)  # a date is no value of a study
    except (ValueError, TypeError):
        return text
    return table


@contextmanager
def row_of_list(editor: Editor, place: Place, name: str, redraw: Redraw) -> Iterator[None]:
    """Draw an entry of a list with buttons that move or remove it; ``name`` says which it is."""
    *_, number = place
    entries = editor.draft.get(place[:-1])

    def move(by: int) -> None:
        entry = entries.pop(int(number))
        entries.insert(int(number) + by, entry)
        editor.changed()
        redraw()

    def remove() -> None:
        editor.put(place, None)
        redraw()

    with ui.element("div").classes("entry w-full"):
        with ui.column().classes("grow gap-1 items-stretch"):
            yield
        with ui.row().classes("gap-0 no-wrap"):
            if int(number) > 0:
                kit.icon_button("arrow_upward", f"Move {name} up", lambda: move(-1))
            if int(number) < len(entries) - 1:
                kit.icon_button("arrow_downward", f"Move {name} down", lambda: move(1))
            kit.icon_button("delete", f"Remove {name}", remove)


def new_name(editor: Editor, place: Place, label: str, button: str, add: Callable[[str], None]) -> None:
    """Draw a field for a name that is not in a list yet, and the button that adds it."""

    def press() -> None:
        if (name := (field.value or "").strip()) and name not in editor.draft.get(place, ()):
            add(name)

    with ui.row().classes("items-end"):
        field = ui.input(label).classes("w-72")
        editor.faults.register(place, field)
        ui.button(button, on_click=press).props("outline dense")


def without(entries: Sequence[Any], number: int) -> list[Any]:
    """Return a list without one of its entries."""
    return [*entries[:number], *entries[number + 1 :]]


def _entry(field: StudyField, entry: Any) -> Any:
    """Return a widget's entry as the file holds it: what is no number stays as it is, and the check refuses it."""
    if field.widget == "integer":
        return int(entry) if entry is not None and float(entry).is_integer() else entry
    if field.widget == "numbers":
        try:
            return [float(part) for part in (entry or "").split(",") if part.strip()]
        except ValueError:
            return entry
    return entry or None if field.widget == "line" else entry
