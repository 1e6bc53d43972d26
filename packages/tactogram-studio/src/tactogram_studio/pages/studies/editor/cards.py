"""Cards of the editor: title and languages, trials, words, display, questions, practice, analysis."""

from __future__ import annotations

from functools import partial
from typing import Any, Literal

from nicegui import ui

from tactogram.rendering import shipped
from tactogram_studio import kit
from tactogram_studio.pages.studies.editor.stimuli_view import listed_stimuli
from tactogram_studio.pages.studies.editor.widgets import (
    TYPED,
    Editor,
    Redraw,
    draw_choice,
    draw_entry,
    draw_field,
    draw_fields,
    draw_texts,
    new_name,
    part,
    row_of_list,
    without,
)
from tactogram_studio.study_draft.fields import Place, fields_of, help_of
from tactogram_studio.study_draft.stimuli import stimulus_names
from tactogram_studio.workspace.sent import LEVEL_VALUES, LEVELS, level_text
from tactogram_study.designs import Design, designs
from tactogram_study.planned import PlannedAnalysis
from tactogram_study.practice import Practice
from tactogram_study.questions import Question
from tactogram_study.study_file import Study
from tactogram_study.wording import language_texts, own_name

SPECIAL = ("kind", "words", "word_texts", "pairs", "standard")
"""Settings of designs that have forms of their own."""
STACK = "w-full stack"
ENDS = ("low", "high", "low_text", "high_text")
"""Settings of scales."""


def design_of(editor: Editor) -> type[Design]:
    """Return the design's class."""
    return designs()[editor.draft.get(("design", "kind"))]


def about(editor: Editor) -> None:
    """Draw title, languages and consent."""
    names = {language: own_name(language) for language in (*editor.draft.languages, *language_texts())}

    def choose(languages: list[str]) -> None:
        editor.put(("languages",), list(languages))
        editor.redraw()

    with kit.card("Title and consent", classes=STACK):
        draw_choice(
            editor,
            ("languages",),
            "Languages",
            names,
            choose,
            multiple=True,
            with_input=True,
            new_value_mode="add-unique",
            key_generator=str,
            value=editor.draft.languages,
        ).props("use-chips")
        kit.hint(
            "Each text is needed in each language. For a language that is not listed, type its tag, such as nl. The "
            "texts of a removed language stay in the file."
        )
        draw_fields(editor, fields_of(Study, only=("title", "consent", "source")))


def trials(editor: Editor) -> None:
    """Draw the settings of the design, and the order of its trials."""
    design = design_of(editor)
    with kit.card(f"Trials: {design.title}", classes=STACK):
        ui.label(design.question_text)
        draw_fields(editor, fields_of(design, ("design",), skip=SPECIAL))
        if "standard" in design.model_fields:
            _standard(editor, design)
        if "pairs" in design.model_fields:
            part(partial(_pairs, editor, design))
        draw_fields(editor, fields_of(Study, only=("order", "rest_every", "seed")))


def _standard(editor: Editor, design: type[Design]) -> None:
    [field] = fields_of(design, ("design",), only=("standard",))
    value = editor.draft.get(field.place, "")
    options = {name: name or "none" for name in (value, "", *stimulus_names(editor.draft))}
    change = partial(editor.put, field.place)
    draw_choice(editor, field.place, field.label, options, lambda name: change(name or None), value=value)
    kit.hint(field.help)


def _pairs(editor: Editor, design: type[Design], redraw: Redraw) -> None:
    place = ("design", "pairs")
    names = stimulus_names(editor.draft)
    pairs = editor.draft.get(place, [])

    def resize(changed: list[list[str]]) -> None:
        editor.put(place, changed or None)
        redraw()

    ui.label("Pairs").classes("font-bold")
    kit.hint(help_of(design, "pairs"))
    for number, pair in enumerate(pairs):
        with ui.row().classes("w-full items-center"):
            for which, label in enumerate(("First", "Second")):
                keys = (*place, number, which)
                title = f"{label} of pair {number + 1}"
                select = draw_choice(
                    editor, keys, title, (*pair, *names), partial(editor.put, keys), value=pair[which]
                )
                select.classes("w-64", remove="w-full")
            kit.icon_button("delete", f"Remove pair {number + 1}", partial(resize, without(pairs, number)))
    if len(names) > 1:
        ui.button("Add a pair", on_click=lambda: resize([*pairs, names[:2]])).props("outline dense")


def has_words(editor: Editor) -> bool:
    """Return whether the design asks about words."""
    return "words" in design_of(editor).model_fields


def words(editor: Editor, redraw: Redraw) -> None:
    """Draw the words in question."""
    design = design_of(editor)
    draft, place = editor.draft, ("design", "words")
    known = list(draft.get(place, design.model_fields["words"].get_default(call_default_factory=True)))
    defaults: Any = design.model_construct(word_texts={})

    def resize(changed: list[str]) -> None:
        texts = draft.get(("design", "word_texts"), {})
        for word in [word for word in texts if word not in changed]:
            del texts[word]
        editor.put(place, changed)
        redraw()

    with kit.card("Words", classes=STACK):
        for number, word in enumerate(known):
            with ui.element("div").classes("entry w-full"):
                default = defaults.word_text(word).model_dump(mode="json")
                draw_texts(editor, ("design", "word_texts", word), word, default=default)
                kit.icon_button("delete", f"Remove the word {word}", partial(resize, without(known, number)))
        new_name(
            editor,
            place,
            "Another word, as in the tables of answers",
            "Add the word",
            lambda word: resize(known if word in known else [*known, word]),
        )


def playing(editor: Editor) -> None:
    """Draw the display and the level."""
    display, played_by = fields_of(Study, only=("display", "played_by"))
    value = editor.draft.get(("display",), display.default)
    with kit.card("Display and level", classes=STACK):
        draw_field(editor, played_by)
        put = partial(editor.put, ("display",))
        draw_choice(editor, ("display",), display.label, (*shipped(), value), put, value=value)
        part(partial(_level, editor))


def _level(editor: Editor, redraw: Redraw) -> None:
    place = ("level",)
    kind, _, number = str(editor.draft.get(place, "physical")).partition("=")

    def choose(kind: str) -> None:
        editor.put(place, level_text(kind, LEVEL_VALUES.get(kind, ("", None))[1]))
        redraw()

    draw_choice(editor, place, "Level", (*LEVELS, kind), choose, value=kind)
    kit.hint(LEVELS.get(kind, ""))
    if kind in LEVEL_VALUES:
        value = float(number) if number else None
        field = kit.NumberField(LEVEL_VALUES[kind][0], value=value, format="%.10g").props(TYPED)
        field.on_value_change(lambda event: editor.put(place, level_text(kind, event.value)))


def practice(editor: Editor, redraw: Redraw) -> None:
    """Draw the practice, if the study has one."""
    draft, place = editor.draft, ("practice",)
    right = design_of(editor).has_right_answers

    def switch(event: Any) -> None:
        editor.put(place, {"trials": 2, **({"feedback": True} if right else {})} if event.value else None)
        redraw()

    ui.switch("Practice before the trials", value=bool(draft.get(place)), on_change=switch)
    if not draft.get(place):
        return
    fields = ("trials", *(("feedback",) if right else ()))
    draw_fields(editor, fields_of(Practice, place, only=fields))
    chosen = draft.get(("practice", "stimuli"), [])
    draw_choice(
        editor,
        ("practice", "stimuli"),
        "Stimuli of the study in the practice",
        (*stimulus_names(draft), *chosen),
        lambda names: editor.put(("practice", "stimuli"), list(names) or None),
        multiple=True,
        value=list(chosen),
    ).props("use-chips")
    kit.hint(help_of(Practice, "stimuli"))
    ui.label("Stimuli of the practice only").classes("font-bold")
    part(partial(listed_stimuli, editor, ("practice", "own")))
    texts = ("text", *(("right", "wrong") if right else ()), "ended")
    draw_fields(editor, fields_of(Practice, place, only=texts))


def analysis(editor: Editor, redraw: Redraw) -> None:
    """Draw the margins of equivalence."""
    kit.hint("Decided before anybody answers. Without a margin nothing can be shown to be equivalent.")
    for name, scale in design_of(editor).margins.items():
        _margin(editor, name, scale.unit)
    draw_fields(editor, fields_of(PlannedAnalysis, ("analysis",), only=("alpha",)))


def _margin(editor: Editor, name: str, unit: str) -> None:
    place = ("analysis", "margins", name)
    margin = editor.draft.get(place, {})
    values = dict(margin) if isinstance(margin, dict) else {"value": margin}

    def change(key: str, event: Any) -> None:
        values[key] = event.value
        kept = {key: value for key, value in values.items() if value not in (None, "")}
        editor.draft.set(place, kept if "value" in kept else None)
        for table in (place[:2], place[:1]):
            if not editor.draft.get(table):
                editor.draft.set(table, None)
        editor.changed()

    with ui.row().classes("w-full items-start no-wrap"):
        number = kit.NumberField(f"Margin of {name}, {unit}", value=values.get("value"), format="%.10g")
        number.on_value_change(partial(change, "value")).props(TYPED).classes("w-64")
        editor.faults.register(place, number)
        why = ui.input("Because", value=values.get("because", "")).on_value_change(partial(change, "because"))
        why.props(f'{TYPED} aria-label="{kit.attribute(f"Reason for the margin of {name}")}"').classes("grow")


def questions(editor: Editor, when: Literal["before", "after"], redraw: Redraw) -> None:
    """Draw the questions before or after the trials."""
    kit.hint(help_of(Study, when))
    listed = editor.draft.get((when,), [])
    for number, question in enumerate(listed):
        place = (when, number)
        with row_of_list(editor, place, f"question {question.get('id', number + 1)}", redraw):
            _question(editor, place, question, redraw)

    def add() -> None:
        ids = {entry.get("id") for entry in listed}
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
        kept = {key: value for key, value in question.items() if key not in (*ENDS, "options")}
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
        keys = (*place, number)
        with row_of_list(editor, keys, f"option {number + 1}", redraw):
            value = str(option.get("value", ""))
            entry = ui.input(f"Option {number + 1} in the tables", value=value).props(TYPED)
            entry.on_value_change(lambda event, keys=keys: editor.put((*keys, "value"), event.value or ""))
            editor.faults.register(keys, entry)
            default = dict.fromkeys(editor.draft.languages, value)
            draw_texts(editor, (*keys, "text"), f"Option {number + 1}", default=default)

    def add() -> None:
        editor.put(place, [*options, {"value": f"option{len(options) + 1}"}])
        redraw()

    ui.button("Add an option", on_click=add).props("flat dense")
