"""Words of the page Make's form: a checkbox and a slider each."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from nicegui import ui

from tactogram.datasets import SEVEN_POINT
from tactogram_studio.layout import attribute, hint, report_errors
from tactogram_studio.pages.make.form import word_label

if TYPE_CHECKING:
    from tactogram_studio.pages.make.page import MakePage

LOW, HIGH = SEVEN_POINT.low, SEVEN_POINT.high


def draw_words(page: MakePage) -> None:
    """Draw the scores of the words that the run knows."""
    state = page.state
    some = state.form is not None and state.form.some_words
    hint(
        f"{scale_text(state.run.kind.scale if state.run else None)} Unticked words are "
        + ("left open." if some else "set to their mean over the training data.")
    )
    with ui.element("div").classes("sliders words"):
        for word in state.form.words if state.form else ():
            _draw_word(page, word, unset="open" if some else "mean")


def scale_text(scale: tuple[float, float] | None) -> str:
    """Return the meaning of the sliders for a run whose ratings have this scale."""
    if scale == (0.0, 1.0):
        return f"Share of people who agree: {LOW:g} nobody, {(LOW + HIGH) / 2:g} half, {HIGH:g} everybody."
    text = f"{LOW:g} (not at all) to {HIGH:g} (very)."
    if scale not in (None, (LOW, HIGH)):
        text += f" The run's own ratings, {scale[0]:g} to {scale[1]:g}, are mapped to this range."
    return text


def _draw_word(page: MakePage, word: str, *, unset: str) -> None:
    state = page.state
    scores = state.request.words
    box = ui.checkbox(word_label(word), value=word in scores).props("dense").classes("name")
    slider = ui.slider(min=LOW, max=HIGH, step=0.1, value=scores.get(word, (LOW + HIGH) / 2))
    slider.props(f'aria-label="Score of {attribute(word)}" data-word="{attribute(word)}"')
    share = ui.label("").classes("share")

    def put(score: float | None) -> None:
        """Set or remove the score, with the words in the run's order."""
        scores = {**state.request.words, word: score}
        ordered = {name: scores.get(name) for name in (state.form.words if state.form else ())}
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
            page.committed()

    slider.on_value_change(report_errors(slid)).on("change", report_errors(page.committed))
    box.on_value_change(report_errors(ticked))
    show()
