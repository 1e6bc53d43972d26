"""Form of the page Make, drawn from the parts that the chosen run has."""

from __future__ import annotations

import importlib
from collections.abc import Callable, Mapping, Sequence
from contextlib import suppress
from functools import partial
from importlib.util import find_spec
from typing import TYPE_CHECKING, Any, Literal, get_args, get_origin

from nicegui import ui

from tactogram.cli.verbs import converted
from tactogram.datasets import SEVEN_POINT
from tactogram.errors import TactogramError
from tactogram.model import condition_types
from tactogram_studio import kit
from tactogram_studio.effects.editing import ready_track
from tactogram_studio.effects.effect import Effect
from tactogram_studio.effects.files import SavedEffects
from tactogram_studio.generation.form import MOST_COUNT, MOST_SEED, OF_A_RECORDING, word_label
from tactogram_studio.generation.state import MakePageState
from tactogram_studio.pages.make.files import draw_motion, draw_photo, draw_vibration
from tactogram_studio.pages.make.mix_view import draw_mix
from tactogram_studio.workspace.commands import assignments
from tactogram_studio.workspace.folder import Workspace

if TYPE_CHECKING:
    from tactogram.workflows import Understanding

LOW, HIGH = SEVEN_POINT.low, SEVEN_POINT.high


def draw_form(state: MakePageState) -> None:
    """Draw the choice of a run, and its form."""
    _draw_runs(state)
    form = state.form
    ui.timer(0.05, partial(_load_ahead, state), once=True)
    parts: list[tuple[str, str, Callable[[MakePageState], None]]] = [
        ("image", "Photograph", draw_photo),
        ("words", "Words", draw_words),
        ("text", "Description", draw_text),
        ("material", "Materials", draw_mix if form.mixes else draw_material),
        ("vibration", "Starting vibration" if "vibration" in form.takes else "Recording", _draw_recording),
    ]
    parts.sort(key=lambda part: part[0] in form.instead)
    parts += [("motion", "Motion", draw_motion), ("", "Settings", partial(_draw_settings, parts=[*parts]))]
    used = form.used(state.request).values
    unused = {"material"} if form.mixes and "material" not in used else set()
    if {"vibration", "words"} & used.keys() or find_spec("wordllama") is None:
        unused |= {"text"}
    if {"image", "vibration", "text"} & used.keys():
        unused |= {"vibration" if "image" in used else "words", "words"} & {*form.instead}
    for part, title, draw in parts:
        if part not in unused and (not part or form.shows(part)):
            with ui.element("fieldset").classes("card part"):
                with ui.element("legend"):
                    kit.heading(title)
                draw(state)
                if part in form.instead and form.materials:
                    kit.hint(
                        "In place of the materials; remove it to use these."
                        if part in used
                        else "Describes the surface in place of the materials."
                    )


async def _load_ahead(state: MakePageState) -> None:
    """Load the run and matplotlib while the form is filled in; errors appear when something is generated."""
    if state.run is not None:
        with suppress(TactogramError):
            await kit.in_background(state.runs.load, state.run)
        await kit.in_background(importlib.import_module, "matplotlib")


def _draw_runs(state: MakePageState) -> None:

    def choose(event: Any) -> None:
        if event.value and event.value != state.request.run:
            state.choose(event.value)
            state.commit(redraw=True)
            state.failure = ""  # it was the other run's
            state.redraw_results()

    with kit.card(classes="part"):
        titles = {run.name: run.title for run in state.runs.finished()}
        select = ui.select(titles, value=state.request.run or None, label="Run", on_change=choose)
        select.classes("w-full").props('data-run="1"')
        if state.run is not None:
            model = state.run.model
            with ui.row().classes("items-center gap-2"):
                kit.hint(f"{model.authors[0]} {model.year}: {model.title}")
                kit.mark_simulated(state.run.kind.simulated, "trained on simulated data")


def _draw_recording(state: MakePageState) -> None:
    """Draw the choice of a vibration, and what is known of its recording."""
    draw_vibration(state)
    if "vibration" in state.request.values:
        with ui.element("div").classes("numbers"):
            for name in filter(state.form.has, condition_types()):
                if name.startswith(OF_A_RECORDING):
                    _draw_condition(state, name)


def _draw_settings(
    state: MakePageState, parts: Sequence[tuple[str, str, Callable[[MakePageState], None]]]
) -> None:
    """Draw the conditions that no part is about, length, seed and number of results."""
    form = state.form
    replaced = {"speed_mm_s", "force_n"} if "motion" in state.request.values else set()
    others = {*form.drawn, *replaced, "motion", *(name for name, *_ in parts)}
    optional = []
    with ui.element("div").classes("numbers"):
        for name, condition in condition_types().items():
            if form.has(name) and name not in others and not name.startswith(OF_A_RECORDING):
                _draw_condition(state, name)
                optional += [condition.options[0].name.replace("_", " ")] if name not in form.needs else []
        if form.over == "time":
            _draw_number(state, "seconds", "Length, s")
            optional.append("length")
        _draw_number(state, "seed", "Seed", MOST_SEED)
        _draw_number(state, "count", "Number of results", MOST_COUNT)
    if optional:
        kit.hint(f"Leave empty for the model's default: {', '.join(optional)}.")
    if form.drawn:
        kit.hint(
            "With the same seed the noise stays the same: results differ only by the settings that you change."
            if form.gives == "image"
            else "With the same seed a surface keeps its noise at any speed and force; other surfaces have their own."
        )


def _draw_condition(state: MakePageState, name: str) -> None:
    """Draw the field of a condition as its option declares it: a number, a choice, scores by name, or else a text."""
    condition = condition_types()[name]
    option, label, value = condition.options[0], condition.label, state.request.values.get(name)
    if option.kind is float:
        _draw_number(state, name, label).tooltip(option.help)
        return

    def changed(event: Any) -> None:
        entry = event.value or ""
        if entry and get_origin(option.kind) is Mapping:
            entry = converted(label, entry.split(","), option.kind)
        state.change(redraw=False, **{name: entry})

    shown = assignments(value) if isinstance(value, Mapping) else value
    if get_origin(option.kind) is Literal:
        field: Any = ui.select(list(get_args(option.kind)), label=label, value=shown, clearable=True)
    else:
        field = ui.input(label, value=shown or "", placeholder=option.example).props("debounce=700")
    field.on_value_change(changed).props(f'data-number="{kit.attribute(name)}"').tooltip(option.help)


def _draw_number(state: MakePageState, name: str, label: str, most: int | None = None) -> ui.number:
    """Draw a number that may be empty, or a whole one up to ``most``."""
    request = state.request

    def changed(event: Any) -> None:
        if most is None:
            state.set(**{name: event.value})
        elif event.value is not None:
            state.set(**{name: int(kit.in_range(label, event.value, least=0, most=most, whole=True) or 0)})

    value = vars(request).get(name, request.values.get(name))
    number = kit.NumberField(label, value=value, on_change=changed)
    number.props(f'data-number="{kit.attribute(name)}"' + (" clearable" if most is None else ""))
    return number.on("blur", state.commit).on("keydown.enter", state.commit)


def draw_text(state: MakePageState) -> None:
    """Draw the field of a description in English, what is understood of it, and the effect that it may name."""
    request, materials = state.request, state.form.materials

    async def describe(text: str) -> None:
        text = text.strip()
        about.clear()
        understood = understood_of(text, materials)  # at once: threads may be busy for a minute with the map
        if understood.effect:
            with about:
                offer_effect(state.workspace, understood, text)
            return
        request = await kit.in_background(state.runs.described, state.request, text) if text else None
        state.change(**({"values": request.values, "typed": text} if request else {"text": "", "typed": ""}))

    typed = request.values.get("text", request.typed)
    text = ui.input("Describe it in English, and press Enter", value=typed)
    text.classes("w-full").props('clearable data-describe="1" placeholder="corrugated cardboard"')
    text.on("keydown.enter", lambda: describe(text.value or "")).on("clear", lambda: describe(""))
    with ui.row().classes("items-center") as about:
        if "text" in request.values:
            kit.hint("In place of the materials, with the photograph if there is one; clear it to use these.")
        elif typed:
            kit.hint(_sentence(understood_of(typed, materials)))


def offer_effect(workspace: Workspace, understood: Understanding, text: str) -> None:
    """Draw the effect that a text names, and a button that opens it."""
    kit.hint(_sentence(understood))
    button = ui.button(
        "Open it on the page Edit", on_click=lambda: open_effect(workspace, understood.effect, text)
    )
    button.props("outline dense").classes("my-1")


def open_effect(workspace: Workspace, name: str, title: str) -> None:
    """Open a new effect on the page Edit: the ready one of that name, under a title such as the typed text."""
    effect = Effect(title=title[:120], tracks=(ready_track(name),))
    identifier = SavedEffects(workspace.studio_folder / "effects").add(effect)
    ui.navigate.to(f"/edit?effect={identifier}")


def understood_of(text: str, materials: Sequence[str]) -> Understanding:
    """Return what a text names, without importing what understands it before."""
    from tactogram.workflows import understand

    return understand(text, materials)


def _sentence(understood: Understanding) -> str:
    text = str(understood)
    return f"{text[:1].upper()}{text[1:]}."


def draw_material(state: MakePageState) -> None:
    """Draw the choice of the one material that a photograph shows."""
    materials = state.form.materials
    options = {"": "determined from the photograph", **{name: name for name in materials}}
    select = ui.select(options, value=next(iter(state.request.mix), ""), label="Material")
    select.on_value_change(
        lambda event: state.change(redraw=False, material={event.value: 1.0} if event.value else {})
    )
    select.classes("w-full")


def draw_words(state: MakePageState) -> None:
    """Draw the scores of the words that the run knows, a checkbox and a slider each."""
    kit.hint(
        f"{scale_text(state.run.kind.scale if state.run else None)} Unticked words are "
        + ("left open." if state.form.some_words else "set to their mean over the training data.")
    )
    with ui.element("div").classes("sliders words"):
        for word in state.form.words:
            _draw_word(state, word, unset="open" if state.form.some_words else "mean")


def scale_text(scale: tuple[float, float] | None) -> str:
    """Return the meaning of the sliders for a run whose ratings have this scale."""
    if scale == (0.0, 1.0):
        return f"Share of people who agree: {LOW:g} nobody, {(LOW + HIGH) / 2:g} half, {HIGH:g} everybody."
    text = f"{LOW:g} (not at all) to {HIGH:g} (very)."
    if scale not in (None, (LOW, HIGH)):
        text += f" The run's own ratings, {scale[0]:g} to {scale[1]:g}, are mapped to this range."
    return text


def _draw_word(state: MakePageState, word: str, *, unset: str) -> None:
    scores = state.request.words
    box = ui.checkbox(word_label(word), value=word in scores).props("dense").classes("name")
    slider = ui.slider(min=LOW, max=HIGH, step=0.1, value=scores.get(word, (LOW + HIGH) / 2))
    slider.props(f'aria-label="Score of {kit.attribute(word)}" data-word="{kit.attribute(word)}"')
    share = ui.label("").classes("share")

    def put(score: float | None) -> None:
        """Set or remove the score, with the words in the run's order."""
        scores = {**state.request.words, word: score}
        ordered = {name: scores.get(name) for name in state.form.words}
        state.set(words={name: value for name, value in ordered.items() if value is not None})
        show()

    def show() -> None:
        score = state.request.words.get(word)
        share.text = f"{score:.1f}" if score is not None else unset
        slider.classes(remove="unset") if score is not None else slider.classes("unset")

    def slid(event: Any) -> None:
        put(round(float(event.value), 2))
        box.value = True

    def ticked(event: Any) -> None:
        if event.value != (word in state.request.words):
            put(round(float(slider.value), 2) if event.value else None)
            state.commit()

    slider.on_value_change(slid).on("change", state.commit)
    box.on_value_change(ticked)
    show()
