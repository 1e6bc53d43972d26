"""Questions before and after the trials."""

from __future__ import annotations

from typing import Any, Literal

from nicegui import ui

from tactogram_studio import kit
from tactogram_studio.pages.studies.editor.draft import Place
from tactogram_studio.pages.studies.editor.fields import fields_of, help_of
from tactogram_studio.pages.studies.editor.widgets import (
    TYPED,
    Editor,
    Redraw,
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


def questions(editor: Editor, when: Literal["before", "after"], redraw: Redraw) -> None:
    """Draw the questions before or after the trials."""
    kit.hint(help_of(Study, when))
    listed = editor.draft.get((when,), [])
    for number, question in enumerate(listed):
        place = (when, number)
        with row_of_list(editor, place, f"question {question.get('id', number + 1)}", redraw):
            _question(editor, place, question, redraw)

    def add() -> None:
        ids = {one.get("id") for one in listed}
        name = next(f"question{n}" for n in range(1, 1000) if f"question{n}" not in ids)
        texts = dict.fromkeys(editor.draft.languages, "?")
        question = {"id": name, "kind": "steps", "low": 1, "high": 7, "text": texts}
        editor.put((when,), [*listed, question])
        redraw()

    ui.button("Add a question", on_click=add).props("outline dense")


def _question(editor: Editor, place: Place, question: dict[str, Any], redraw: Redraw) -> None:
    kind, text, name, required = fields_of(Question, place, only=("kind", "text", "id", "required"))
    draw_field(editor, text)

    def change(chosen: str) -> None:
        kept = {key: one for key, one in question.items() if key not in (*ENDS, "options")}
        if chosen == "choice":
            kept["options"] = [{"value": "yes"}, {"value": "no"}]
        elif chosen in ("steps", "vas"):
            kept |= {"low": question.get("low", 1), "high": question.get("high", 7)}
        editor.put(place, {**kept, "kind": chosen})
        redraw()

    draw_entry(editor, kind, question.get("kind"), change)
    if question.get("kind") == "choice":
        _options(editor, (*place, "options"), redraw)
    elif question.get("kind") in ("steps", "vas"):
        draw_fields(editor, fields_of(Question, place, only=ENDS))
    elif question.get("kind") == "number":
        draw_fields(editor, fields_of(Question, place, only=("low", "high")))
    draw_field(editor, name)
    draw_field(editor, required)


def _options(editor: Editor, place: Place, redraw: Redraw) -> None:
    options = editor.draft.get(place, [])
    for number, option in enumerate(options):
        at = (*place, number)
        with row_of_list(editor, at, f"option {number + 1}", redraw):
            value = str(option.get("value", ""))
            entry = ui.input(f"Option {number + 1} in the tables", value=value).props(TYPED)
            entry.on_value_change(lambda event, at=at: editor.put((*at, "value"), event.value or ""))
            editor.faults.register(at, entry)
            default = dict.fromkeys(editor.draft.languages, value)
            draw_texts(editor, (*at, "text"), f"Option {number + 1}", default=default)

    def add() -> None:
        editor.put(place, [*options, {"value": f"option{len(options) + 1}"}])
        redraw()

    ui.button("Add an option", on_click=add).props("flat dense")
