"""Cards of the editor: title and languages, trials, words, display, practice, analysis."""

from __future__ import annotations

from collections.abc import Callable
from functools import partial
from typing import Any

from nicegui import ui

from tactogram.rendering import shipped
from tactogram_studio.layout import NumberField, attribute, heading, hint, report_errors
from tactogram_studio.pages.send.wording import LEVEL_VALUES, LEVELS, level_text
from tactogram_studio.pages.studies.editor.fields import fields_of, help_of
from tactogram_studio.pages.studies.editor.stimuli import stimulus_names
from tactogram_studio.pages.studies.editor.stimuli_view import listed_stimuli
from tactogram_studio.pages.studies.editor.widgets import (
    Editor,
    draw_field,
    draw_fields,
    draw_texts,
    icon_button,
    part,
)
from tactogram_study.designs import Design, designs
from tactogram_study.planned import PlannedAnalysis
from tactogram_study.practice import Practice
from tactogram_study.study_file import Study
from tactogram_study.wording import language_texts, own_name

Redraw = Callable[[], None]
SPECIAL = ("kind", "words", "word_texts", "pairs", "standard")
"""Settings of designs that have forms of their own."""


def design_of(editor: Editor) -> type[Design]:
    """Return the design's class."""
    return designs()[editor.draft.get(("design", "kind"))]


def about(editor: Editor) -> None:
    """Draw title, languages and consent."""
    with ui.element("section").classes("card w-full stack"):
        heading("Title and consent")
        names = {one: own_name(one) for one in (*editor.draft.languages, *language_texts())}

        def choose(event: Any) -> None:
            editor.draft.set(("languages",), list(event.value))
            editor.changed()
            editor.redraw()

        languages = ui.select(
            names,
            label="Languages",
            multiple=True,
            with_input=True,
            new_value_mode="add-unique",
            key_generator=str,
            value=editor.draft.languages,
            on_change=report_errors(choose),
        )
        editor.faults.register(("languages",), languages.props("dense use-chips").classes("w-full"))
        hint(
            "Each text is needed in each language. For a language that is not listed, type its tag, such as nl. The "
            "texts of a removed language stay in the file."
        )
        draw_fields(editor, fields_of(Study, only=("title", "consent", "source")))


def trials(editor: Editor) -> None:
    """Draw the settings of the design, and the order of its trials."""
    design = design_of(editor)
    with ui.element("section").classes("card w-full stack"):
        heading(f"Trials: {design.title}")
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
    names = dict.fromkeys([value, "", *stimulus_names(editor.draft)])

    def change(event: Any) -> None:
        editor.draft.set(field.place, event.value or None)
        editor.changed()

    options = {name: name or "none" for name in names}
    select = (
        ui.select(options, label=field.label, value=value, on_change=change).props("dense").classes("w-full")
    )
    editor.faults.register(field.place, select)
    hint(field.help)


def _pairs(editor: Editor, design: type[Design], redraw: Redraw) -> None:
    place = ("design", "pairs")
    names = stimulus_names(editor.draft)
    pairs = editor.draft.get(place, [])

    def change(number: int, which: int, name: str) -> None:
        editor.draft.set((*place, number, which), name)
        editor.changed()

    def resize(changed: list[list[str]]) -> None:
        editor.draft.set(place, changed or None)
        editor.changed()
        redraw()

    ui.label("Pairs").classes("font-bold")
    hint(help_of(design, "pairs"))
    for number, pair in enumerate(pairs):
        with ui.row().classes("w-full items-center"):
            for which, label in enumerate(("First", "Second")):
                ui.select(
                    list(dict.fromkeys((*pair, *names))),
                    label=f"{label} of pair {number + 1}",
                    value=pair[which],
                    on_change=lambda e, number=number, which=which: change(number, which, e.value),
                ).props("dense").classes("w-64")
            rest = [*pairs[:number], *pairs[number + 1 :]]
            icon_button("delete", f"Remove pair {number + 1}", partial(resize, rest))
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
        draft.set(place, changed)
        texts = draft.get(("design", "word_texts"), {})
        for word in [word for word in texts if word not in changed]:
            del texts[word]
        editor.changed()
        redraw()

    def add() -> None:
        word = (new.value or "").strip()
        if word and word not in known:
            resize([*known, word])

    with ui.element("section").classes("card w-full stack"):
        heading("Words")
        for number, word in enumerate(known):
            with ui.element("div").classes("entry w-full"):
                default = defaults.word_text(word).model_dump(mode="json")
                draw_texts(editor, ("design", "word_texts", word), word, default=default)
                rest = [*known[:number], *known[number + 1 :]]
                icon_button("delete", f"Remove the word {word}", partial(resize, rest))
        with ui.row().classes("items-end"):
            new = ui.input("Another word, as in the tables of answers").props("dense").classes("w-72")
            editor.faults.register(place, new)
            ui.button("Add the word", on_click=report_errors(add)).props("outline dense")


def playing(editor: Editor) -> None:
    """Draw the display and the level."""
    display, played_by = fields_of(Study, only=("display", "played_by"))
    value = editor.draft.get(("display",), display.default)
    with ui.element("section").classes("card w-full stack"):
        heading("Display and level")
        draw_field(editor, played_by)

        def change(event: Any) -> None:
            editor.draft.set(("display",), event.value)
            editor.changed()

        options = list(dict.fromkeys((*shipped(), value)))
        select = ui.select(options, label=display.label, value=value, on_change=change).props("dense")
        editor.faults.register(("display",), select.classes("w-full"))
        part(partial(_level, editor))


def _level(editor: Editor, redraw: Redraw) -> None:
    text = str(editor.draft.get(("level",), "physical"))
    kind, _, number = text.partition("=")

    def change(kind: str, number: float | None) -> None:
        editor.draft.set(("level",), level_text(kind, number))
        editor.changed()

    def choose(event: Any) -> None:
        change(event.value, LEVEL_VALUES.get(event.value, ("", None))[1])
        redraw()

    options = list(dict.fromkeys((*LEVELS, kind)))
    select = ui.select(options, label="Level", value=kind, on_change=choose).props("dense").classes("w-full")
    editor.faults.register(("level",), select)
    hint(LEVELS.get(kind, ""))
    if kind in LEVEL_VALUES:
        value = float(number) if number else None
        field = NumberField(
            LEVEL_VALUES[kind][0], value=value, format="%.10g", on_change=lambda e: change(kind, e.value)
        )
        field.props("dense debounce=300")


def practice(editor: Editor, redraw: Redraw) -> None:
    """Draw the practice, if the study has one."""
    draft, place = editor.draft, ("practice",)
    right = design_of(editor).has_right_answers

    def switch(event: Any) -> None:
        draft.set(place, {"trials": 2, **({"feedback": True} if right else {})} if event.value else None)
        editor.changed()
        redraw()

    ui.switch("Practice before the trials", value=bool(draft.get(place)), on_change=report_errors(switch))
    if not draft.get(place):
        return
    fields = ("trials", *(("feedback",) if right else ()))
    draw_fields(editor, fields_of(Practice, place, only=fields))

    def choose(event: Any) -> None:
        draft.set(("practice", "stimuli"), list(event.value) or None)
        editor.changed()

    chosen = draft.get(("practice", "stimuli"), [])
    names = list(dict.fromkeys((*stimulus_names(draft), *chosen)))
    select = ui.select(
        names,
        label="Stimuli of the study in the practice",
        multiple=True,
        value=list(chosen),
        on_change=choose,
    )
    editor.faults.register(("practice", "stimuli"), select.props("dense use-chips").classes("w-full"))
    hint(help_of(Practice, "stimuli"))
    ui.label("Stimuli of the practice only").classes("font-bold")
    part(partial(listed_stimuli, editor, ("practice", "own")))
    texts = ("text", *(("right", "wrong") if right else ()), "ended")
    draw_fields(editor, fields_of(Practice, place, only=texts))


def analysis(editor: Editor, redraw: Redraw) -> None:
    """Draw the margins of equivalence."""
    hint("Decided before anybody answers. Without a margin nothing can be shown to be equivalent.")
    for name, scale in design_of(editor).margins.items():
        _margin(editor, name, scale.unit)
    draw_fields(editor, fields_of(PlannedAnalysis, ("analysis",), only=("alpha",)))


def _margin(editor: Editor, name: str, unit: str) -> None:
    place = ("analysis", "margins", name)
    given = editor.draft.get(place, {})
    values = dict(given) if isinstance(given, dict) else {"value": given}

    def change(key: str, entry: Any) -> None:
        values[key] = entry
        kept = {key: one for key, one in values.items() if one not in (None, "")}
        editor.draft.set(place, kept if "value" in kept else None)
        for table in (place[:2], place[:1]):
            if not editor.draft.get(table):
                editor.draft.set(table, None)
        editor.changed()

    with ui.row().classes("w-full items-start no-wrap"):
        number = NumberField(
            f"Margin of {name}, {unit}", value=values.get("value"), format="%.10g",
            on_change=lambda e: change("value", e.value),
        ).props("dense debounce=300").classes("w-64")  # fmt: skip
        editor.faults.register(place, number)
        why = ui.input(
            "Because", value=values.get("because", ""), on_change=lambda e: change("because", e.value)
        )
        why.props(f'dense debounce=300 aria-label="{attribute(f"Reason for the margin of {name}")}"').classes(
            "grow"
        )
