"""The form of the page Make, drawn from what the run's model needs and takes."""

from __future__ import annotations

import importlib
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from functools import partial
from typing import TYPE_CHECKING, Any

from nicegui import ui

from tactogram.errors import TactogramError
from tactogram.studio.layout import in_background, report_errors
from tactogram.studio.pages.make.files import draw_photo, draw_vibration
from tactogram.studio.pages.make.form import LONGEST_S, MOST_COUNT, MOST_SEED
from tactogram.studio.pages.make.materials_view import draw_label, draw_mix
from tactogram.studio.pages.make.words_view import draw_words

if TYPE_CHECKING:
    from tactogram.studio.pages.make.page import MakePage


def draw_form(on: MakePage) -> None:
    """Draw the form of the chosen run."""
    _run(on)
    form = on.desk.form
    if form is None:
        return
    ui.timer(0.05, partial(_load_ahead, on), once=True)
    if form.has("photo"):
        with part("Photograph"):
            draw_photo(on)
    if form.has("words"):
        with part("Words"):
            draw_words(on)
    if form.has("materials"):
        with part("Materials"):
            if form.mixes:
                draw_mix(on)
            else:
                draw_label(on)
    if form.has("vibration"):
        with part("Vibration to start from"):
            draw_vibration(on)
    with part("How"):
        _numbers(on)


async def _load_ahead(on: MakePage) -> None:
    """Load the chosen run, and what draws, while the form is filled in; errors are told when it is made."""
    choice = on.desk.choice
    if choice is not None:
        with suppress(TactogramError):
            await in_background(on.desk.runs.load, choice)
        await in_background(importlib.import_module, "matplotlib")


@contextmanager
def part(title: str) -> Iterator[None]:
    """Draw a part of the form with its title."""
    with ui.element("fieldset").classes("card part"):
        with ui.element("legend"):
            ui.label(title).classes("h2")
        yield


def _run(on: MakePage) -> None:
    desk = on.desk
    titles = {choice.name: choice.title for choice in desk.runs.choices()}

    def choose(event: Any) -> None:
        if event.value and event.value != desk.asked.run:
            desk.choose(event.value)
            on.committed(redraw=True)

    with ui.element("section").classes("card part"):
        select = ui.select(titles, value=desk.asked.run or None, label="Run", on_change=report_errors(choose))
        select.classes("w-full").props('outlined dense options-dense data-run="1"')
        if desk.choice is not None:
            facts = desk.choice.facts
            with ui.row().classes("items-center gap-2"):
                ui.label(f"{facts.authors[0]} {facts.year}: {facts.title}").classes("small quiet")
                if desk.choice.kind.simulated:
                    ui.label("learned from simulated data").classes("simulated")


def _numbers(on: MakePage) -> None:
    form = on.desk.form
    if form is None:
        return
    with ui.element("div").classes("numbers"):
        if form.has("speed"):
            _number(on, "speed_mm_s", "Speed, mm/s", most=2000)
        if form.has("force"):
            _number(on, "force_n", "Force, N", most=100)
        if form.over == "time":
            _number(on, "seconds", "Length, s", most=LONGEST_S)
        _number(on, "seed", "Seed", whole=True, least=0, most=MOST_SEED)
        _number(on, "count", "How many", whole=True, least=1, most=MOST_COUNT)
    empty = [
        name
        for name, there in {
            "speed": form.has("speed"),
            "force": form.has("force"),
            "length": form.over == "time",
        }.items()
        if there
    ]
    notes = [f"Left empty: the model's own {', '.join(empty)}."] if empty else []
    if form.own_seed:
        notes.append("The same seed under other values is the same noise: what differs is what was changed.")
    if notes:
        ui.label(" ".join(notes)).classes("small quiet")


def _number(
    on: MakePage, name: str, label: str, *, most: float, least: float = 0.0, whole: bool = False
) -> None:
    desk = on.desk

    def changed(event: Any) -> None:
        value = event.value
        if value is None and whole:
            return
        desk.set(**{name: None if value is None else int(value) if whole else float(value)})

    number = ui.number(
        label, value=getattr(desk.asked, name), min=least, max=most, on_change=report_errors(changed)
    )
    number.props(f'outlined dense data-number="{name}"' + (" clearable" if not whole else ""))
    number.on("blur", report_errors(on.committed)).on("keydown.enter", report_errors(on.committed))
