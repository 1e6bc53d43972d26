"""Widgets of the editor's fields: each changes the draft at its place, and shows its fault."""

from __future__ import annotations

import json
import tomllib
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from typing import Any, Protocol

import tomli_w
from nicegui import ui
from nicegui.elements.mixins.validation_element import ValidationElement

from tactogram.validation import Fault
from tactogram_studio.context import Studio
from tactogram_studio.layout import NumberField, attribute, hint, report_errors
from tactogram_studio.pages.studies.editor.draft import Place, StudyDraft
from tactogram_studio.pages.studies.editor.fields import StudyField
from tactogram_study.wording import own_name

DEBOUNCE_MS = 300
LONG = ("consent", "instructions", "reference")
"""Texts of several lines."""


class Editor(Protocol):
    """Page that fields and cards are drawn on."""

    studio: Studio
    draft: StudyDraft
    faults: FaultMarks
    dialogs: ui.element
    """Where dialogs are drawn: it stays when a part of the form is drawn anew."""

    def changed(self) -> None:
        """Keep the draft and check it."""

    def redraw(self) -> None:
        """Draw the whole form anew."""


class FaultMarks:
    """Widgets by place, each of which can show a fault."""

    def __init__(self) -> None:
        self._widgets: dict[Place, ValidationElement[Any]] = {}

    def register(self, place: Place, widget: ValidationElement[Any]) -> None:
        """Let a widget show the faults at a place."""
        self._widgets[place] = widget

    def show(self, faults: Sequence[Fault]) -> None:
        """Show each fault at the widget of its place or of the nearest table around it, and clear all others."""
        self._widgets = {place: one for place, one in self._widgets.items() if not one.is_deleted}
        sentences: dict[Place, str] = {}
        for fault in faults:
            place = fault.place
            while place and place not in self._widgets:
                place = place[:-1]
            sentences.setdefault(place, fault.sentence)
        for place, widget in self._widgets.items():
            if widget.error != (sentence := sentences.get(place)):
                widget.error = sentence


def part(draw: Callable[[Callable[[], None]], None]) -> None:
    """Draw a part of the page that can be drawn anew; ``draw`` gets the function that does it."""
    box = ui.column().classes("w-full gap-2 items-stretch")

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
    value = editor.draft.get(field.place, field.default)

    def change(entry: Any) -> None:
        # A default is not written: the file holds what differs.
        editor.draft.set(field.place, None if entry == field.default else entry)
        editor.changed()

    with ui.column().classes("w-full gap-0 items-stretch"):
        draw_entry(editor, field, value, change)
        if field.help:
            hint(field.help)


def draw_entry(editor: Editor, field: StudyField, value: Any, change: Callable[[Any], None]) -> None:
    """Draw the widget of a field, which calls ``change`` with its entry."""
    if field.widget == "switch":
        ui.switch(field.label, value=bool(value), on_change=lambda e: change(e.value))
        return
    if field.widget == "choice":
        options = ({} if value in field.choices else {value: "none" if value is None else str(value)}) | dict(
            field.choices
        )
        widget: Any = ui.select(options, label=field.label, value=value, on_change=lambda e: change(e.value))
    elif field.widget in ("integer", "number"):
        whole = field.widget == "integer"
        widget = NumberField(
            field.label,
            value=value,
            on_change=lambda e: change(_number(e.value, whole=whole)),
            format="%.10g",
        )
    elif field.widget == "numbers":
        text = ", ".join(f"{number:g}" for number in value or ())
        widget = ui.input(field.label, value=text, on_change=lambda e: change(_numbers(e.value)))
    else:
        widget = ui.input(field.label, value=value or "", on_change=lambda e: change(e.value or None))
    widget.props(f"dense debounce={DEBOUNCE_MS}" if field.widget != "choice" else "dense options-dense")
    editor.faults.register(field.place, widget)


def draw_texts(
    editor: Editor, place: Place, label: str, *, default: Any = None, help: str = "", long: bool | None = None
) -> None:
    """Draw a text in each of the study's languages, side by side."""
    languages = editor.draft.languages
    long = place[-1] in LONG if long is None else long
    with ui.column().classes("w-full gap-0 items-stretch"):
        with ui.element("div").classes("texts w-full"):
            for language in languages:
                _text(editor, place, label, language, default, long)
        if help:
            hint(help)


def _text(editor: Editor, place: Place, label: str, language: str, default: Any, long: bool) -> None:
    title = f"{label} ({own_name(language)})" if len(editor.draft.languages) > 1 else label

    def change(event: Any) -> None:
        editor.draft.set_text(place, language, event.value or "", default)
        editor.changed()

    value = editor.draft.text(place, language, default)
    kind = ui.textarea if long else ui.input
    widget = kind(title, value=value, on_change=change)
    widget.props(f"dense debounce={DEBOUNCE_MS} lang={language}{' autogrow' if long else ''}")
    editor.faults.register((*place, language), widget)


def draw_table(editor: Editor, place: Place, label: str) -> ui.textarea:
    """Draw a table as lines of the study's file, and return the widget."""

    def change(event: Any) -> None:
        editor.draft.set(place, table_of(event.value or "") or None)
        editor.changed()

    value = editor.draft.get(place, {})
    text = value if isinstance(value, str) else "\n".join(lines_of(value))
    area = ui.textarea(label, value=text, on_change=change).props(f"dense autogrow debounce={DEBOUNCE_MS}")
    editor.faults.register(place, area.classes("w-full"))
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
def row_of_list(editor: Editor, place: Place, name: str, redraw: Callable[[], Any]) -> Iterator[None]:
    """Draw an entry of a list with buttons that move or remove it; ``name`` says which it is."""
    *_, number = place
    entries = editor.draft.get(place[:-1])

    def move(by: int) -> None:
        one = entries.pop(int(number))
        entries.insert(int(number) + by, one)
        editor.changed()
        redraw()

    def remove() -> None:
        editor.draft.set(place, None)
        editor.changed()
        redraw()

    with ui.element("div").classes("entry w-full"):
        with ui.column().classes("grow gap-1 items-stretch"):
            yield
        with ui.row().classes("gap-0 no-wrap"):
            if int(number) > 0:
                icon_button("arrow_upward", f"Move {name} up", lambda: move(-1))
            if int(number) < len(entries) - 1:
                icon_button("arrow_downward", f"Move {name} down", lambda: move(1))
            icon_button("delete", f"Remove {name}", remove)


def icon_button(icon: str, name: str, press: Callable[[], Any]) -> ui.button:
    """Draw a button with an icon alone and its name for screen readers."""
    button = ui.button(icon=icon, on_click=report_errors(press)).props("flat round dense")
    return button.props(f'aria-label="{attribute(name)}" title="{attribute(name)}"')


def _number(entry: float | None, *, whole: bool) -> float | int | None:
    """Return a number as the file holds it: a fraction stays one, and the check refuses it."""
    return int(entry) if entry is not None and whole and float(entry).is_integer() else entry


def _numbers(text: str | None) -> list[float] | str:
    """Return the numbers of a field between commas; the text itself if it has others, and the check refuses it."""
    try:
        return [float(part) for part in (text or "").split(",") if part.strip()]
    except ValueError:
        return text or ""
