"""Questions before and after the trials."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, Literal

from nicegui import ui

from tactogram_studio.layout import hint, report_errors
from tactogram_studio.pages.studies.editor.draft import Place
from tactogram_studio.pages.studies.editor.fields import fields_of, help_of
from tactogram_studio.pages.studies.editor.widgets import (
    Editor,
    draw_entry,
    draw_field,
    draw_fields,
    draw_texts,
    row_of_list,
)
from tactogram_study.questions import Question
from tactogram_study.study_file import Study

ENDS = ("low", "high", "low_text", "high_text")
"""Settings of scales."""


def questions(editor: Editor, when: Literal["before", "after"], redraw: Callable[[], None]) -> None:
    """Draw the questions before or after the trials."""
    hint(help_of(Study, when))
    listed = editor.draft.get((when,), [])
    for number, question in enumerate(listed):
        place = (when, number)
        with row_of_list(editor, place, f"question {question.get('id', number + 1)}", redraw):
            _question(editor, place, question, redraw)

    def add() -> None:
        ids = {one.get("id") for one in listed}
        name = next(f"question{n}" for n in range(1, 1000) if f"question{n}" not in ids)
        texts = dict.fromkeys(editor.draft.languages, "?")
        editor.draft.append((when,), {"id": name, "kind": "steps", "low": 1, "high": 7, "text": texts})
        editor.changed()
        redraw()

    ui.button("Add a question", on_click=report_errors(add)).props("outline dense")


def _question(editor: Editor, place: Place, question: dict[str, Any], redraw: Callable[[], None]) -> None:
    kind, text, name, required = fields_of(Question, place, only=("kind", "text", "id", "required"))
    draw_field(editor, text)

    def change(chosen: str) -> None:
        kept = {key: one for key, one in question.items() if key not in (*ENDS, "options")}
        if chosen == "choice":
            kept["options"] = [{"value": "yes"}, {"value": "no"}]
        elif chosen in ("steps", "vas"):
            kept |= {"low": question.get("low", 1), "high": question.get("high", 7)}
        editor.draft.set(place, {**kept, "kind": chosen})
        editor.changed()
        redraw()

    draw_entry(editor, kind, question.get("kind"), report_errors(change))
    if question.get("kind") == "choice":
        _options(editor, (*place, "options"), redraw)
    elif question.get("kind") in ("steps", "vas"):
        draw_fields(editor, fields_of(Question, place, only=ENDS))
    elif question.get("kind") == "number":
        draw_fields(editor, fields_of(Question, place, only=("low", "high")))
    draw_field(editor, name)
    draw_field(editor, required)


def _options(editor: Editor, place: Place, redraw: Callable[[], None]) -> None:
    for number, option in enumerate(editor.draft.get(place, [])):
        with row_of_list(editor, (*place, number), f"option {number + 1}", redraw):
            value = str(option.get("value", ""))
            change = _option_change(editor, (*place, number))
            entry = ui.input(f"Option {number + 1} in the tables", value=value, on_change=change)
            editor.faults.register((*place, number), entry.props("dense debounce=300"))
            default = dict.fromkeys(editor.draft.languages, value)
            draw_texts(editor, (*place, number, "text"), f"Option {number + 1}", default=default)

    def add() -> None:
        options = editor.draft.get(place, [])
        editor.draft.append(place, {"value": f"option{len(options) + 1}"})
        editor.changed()
        redraw()

    ui.button("Add an option", on_click=report_errors(add)).props("flat dense")


def _option_change(editor: Editor, place: Place) -> Callable[[Any], None]:
    def change(event: Any) -> None:
        editor.draft.set((*place, "value"), event.value or "")
        editor.changed()

    return change
