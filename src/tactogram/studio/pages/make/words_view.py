"""The words of the page Make's form: a tick and a slider each."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from nicegui import ui

from tactogram.datasets.ratings.ratings import SEVEN_POINT
from tactogram.studio.layout import report_errors
from tactogram.studio.pages.make.form import word_label

if TYPE_CHECKING:
    from tactogram.studio.pages.make.page import MakePage


def draw_words(on: MakePage) -> None:
    """Draw the scores of the words that the run knows."""
    desk = on.desk
    scale = desk.choice.kind.scale if desk.choice else None
    ui.label(
        f"{scale_text(scale)} A word that is not ticked is the mean over what the run learned from."
    ).classes("small quiet")
    with ui.element("div").classes("sliders words"):
        for word in desk.form.words if desk.form else ():
            _word(on, word)


def scale_text(scale: tuple[float, float] | None) -> str:
    """Return what the sliders of words mean for a run whose ratings are on a scale."""
    low, high = SEVEN_POINT.low, SEVEN_POINT.high
    if scale == (0.0, 1.0):
        return f"The share of people who say so: {low:g} nobody, {(low + high) / 2:g} one half, {high:g} everybody."
    text = f"{low:g} (not at all) to {high:g} (very)."
    if scale not in (None, (low, high)):
        text += (
            f" The run's own ratings are {scale[0]:g} to {scale[1]:g}: lowest is lowest, highest is highest."
        )
    return text


def _word(on: MakePage, word: str) -> None:
    desk = on.desk
    middle = (SEVEN_POINT.low + SEVEN_POINT.high) / 2
    given = ui.checkbox(word_label(word), value=word in desk.asked.words).props("dense").classes("name")
    slider = ui.slider(
        min=SEVEN_POINT.low, max=SEVEN_POINT.high, step=0.1, value=desk.asked.words.get(word, middle)
    )
    slider.props(f'aria-label="Score of {word}" data-word="{word}"')
    share = ui.label("").classes("share")

    def tell() -> None:
        share.text = f"{desk.asked.words[word]:.1f}" if word in desk.asked.words else "mean"
        slider.classes(remove="unset") if word in desk.asked.words else slider.classes("unset")

    def moved(event: Any) -> None:
        desk.set(words=_in_order(on, {**desk.asked.words, word: round(float(event.value), 2)}))
        given.value = True
        tell()

    def ticked(event: Any) -> None:
        if event.value == (word in desk.asked.words):
            return
        words = dict(desk.asked.words)
        if event.value:
            words[word] = round(float(slider.value), 2)
        else:
            words.pop(word)
        desk.set(words=_in_order(on, words))
        tell()
        on.committed()

    slider.on_value_change(report_errors(moved)).on("change", report_errors(on.committed))
    given.on_value_change(report_errors(ticked))
    tell()


def _in_order(on: MakePage, words: dict[str, float]) -> dict[str, float]:
    form = on.desk.form
    return {word: words[word] for word in (form.words if form else ()) if word in words}
