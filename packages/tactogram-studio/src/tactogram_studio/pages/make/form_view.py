"""Form of the page Make, drawn from the parts that the chosen run has."""

from __future__ import annotations

import importlib
from collections.abc import Callable
from contextlib import suppress
from functools import partial
from importlib.util import find_spec
from typing import TYPE_CHECKING, Any

from nicegui import ui

from tactogram.errors import TactogramError
from tactogram_studio.layout import heading, hint, in_background, report_errors
from tactogram_studio.pages.make.files import draw_motion, draw_photo, draw_vibration
from tactogram_studio.pages.make.form import LONGEST_S, MOST_COUNT, MOST_SEED
from tactogram_studio.pages.make.materials_view import draw_material, draw_mix, draw_text
from tactogram_studio.pages.make.words_view import draw_words

if TYPE_CHECKING:
    from tactogram_studio.pages.make.page import MakePage

MOST_SPEED_MM_S, MOST_FORCE_N = 2000, 100


def draw_form(page: MakePage) -> None:
    """Draw the choice of a run, and its form."""
    _draw_runs(page)
    form = page.state.form
    if form is None:
        return
    ui.timer(0.05, partial(_load_ahead, page), once=True)
    parts: list[tuple[str, str, Callable[[MakePage], None]]] = [
        ("photo", "Photograph", draw_photo),
        ("words", "Words", draw_words),
        ("text", "Description", draw_text),
        ("materials", "Materials", draw_mix if form.mixes else draw_material),
        ("vibration", "Starting vibration" if "vibration" in form.takes else "Recording", _draw_recording),
    ]
    parts.sort(key=lambda part: part[0] in form.instead)
    parts += [("motion", "Motion", draw_motion), ("", "Settings", _draw_numbers)]
    used = form.used(page.state.request)
    unused = {"materials"} if form.mixes and not used.weights else set()
    if used.vibration or used.words or find_spec("wordllama") is None:
        unused |= {"text"}
    if used.photo or used.vibration or used.text:
        unused |= {"vibration" if used.photo else "words", "words"} & {*form.instead}
    for part, title, draw in parts:
        if part not in unused and (not part or form.shows(part)):
            with ui.element("fieldset").classes("card part"):
                with ui.element("legend"):
                    heading(title)
                draw(page)
                if part in form.instead and form.materials:
                    hint(
                        "In place of the materials; remove it to use these."
                        if getattr(used, part)
                        else "Describes the surface in place of the materials."
                    )


async def _load_ahead(page: MakePage) -> None:
    """Load the run and matplotlib while the form is filled in; errors appear when something is generated."""
    run = page.state.run
    if run is not None:
        with suppress(TactogramError):
            await in_background(page.state.runs.load, run)
        await in_background(importlib.import_module, "matplotlib")


def _draw_runs(page: MakePage) -> None:
    state = page.state
    titles = {run.name: run.title for run in state.runs.finished()}

    def choose(event: Any) -> None:
        if event.value and event.value != state.request.run:
            state.choose(event.value)
            page.committed(redraw=True)

    with ui.element("section").classes("card part"):
        select = ui.select(titles, value=state.request.run or None, label="Run")
        select.on_value_change(report_errors(choose))
        select.classes("w-full").props('outlined dense options-dense data-run="1"')
        if state.run is not None:
            model = state.run.model
            with ui.row().classes("items-center gap-2"):
                hint(f"{model.authors[0]} {model.year}: {model.title}")
                if state.run.kind.simulated:
                    ui.label("trained on simulated data").classes("simulated")


def _draw_recording(page: MakePage) -> None:
    """Draw the choice of a vibration, and the speed and force that it was recorded with."""
    draw_vibration(page)
    form = page.state.form
    if form is None or not page.state.request.vibration:
        return
    with ui.element("div").classes("numbers"):
        for part, field, label, most in (
            ("vibration_speed", "vibration_speed_mm_s", "Recorded at, mm/s", MOST_SPEED_MM_S),
            ("vibration_force", "vibration_force_n", "Recorded with, N", MOST_FORCE_N),
        ):
            if form.has(part):
                _draw_number(page, field, label, most=most)
        if form.has("vibration_contactor"):
            _draw_contactor(page, "vibration_contactor", "Recorded by")


def _draw_numbers(page: MakePage) -> None:
    form = page.state.form
    if form is None:
        return
    optional, moved = [], bool(page.state.request.motion)
    with ui.element("div").classes("numbers"):
        for name, field, label, most, shown in (
            ("speed", "speed_mm_s", "Speed, mm/s", MOST_SPEED_MM_S, form.has("speed") and not moved),
            ("force", "force_n", "Force, N", MOST_FORCE_N, form.has("force") and not moved),
            ("length", "seconds", "Length, s", LONGEST_S, form.over == "time"),
        ):
            if shown:
                _draw_number(page, field, label, most=most)
                optional.append(name)
        if form.has("contactor"):
            _draw_contactor(page, "contactor", "Contactor")
            optional.append("contactor")
        _draw_number(page, "seed", "Seed", whole=True, least=0, most=MOST_SEED)
        _draw_number(page, "count", "Number of results", whole=True, least=1, most=MOST_COUNT)
    if optional:
        hint(f"Leave empty for the model's default: {', '.join(optional)}.")
    if form.drawn:
        hint(
            "With the same seed the noise stays the same: results differ only by the settings that you change."
            if form.gives == "image"
            else "With the same seed a surface keeps its noise at any speed and force; other surfaces have their own."
        )


def _draw_contactor(page: MakePage, name: str, label: str) -> None:
    def changed(event: Any) -> None:
        page.state.set(**{name: event.value})
        page.committed()

    chosen = ui.select(
        ["finger", "stylus"], label=label, value=getattr(page.state.request, name), clearable=True
    )
    chosen.on_value_change(report_errors(changed)).props(f'outlined dense data-number="{name}"')


def _draw_number(
    page: MakePage, name: str, label: str, *, most: float, least: float = 0.0, whole: bool = False
) -> None:
    state = page.state

    def changed(event: Any) -> None:
        value = event.value
        if value is not None:
            state.set(**{name: int(value) if whole else float(value)})
        elif not whole:
            state.set(**{name: None})

    number = ui.number(label, value=getattr(state.request, name), min=least, max=most)
    number.on_value_change(report_errors(changed))
    number.props(f'outlined dense data-number="{name}"' + (" clearable" if not whole else ""))
    number.on("blur", report_errors(page.committed)).on("keydown.enter", report_errors(page.committed))
