"""The form of the page Make, drawn from what the run's model needs and takes."""

from __future__ import annotations

import importlib
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from functools import partial
from html import escape
from typing import TYPE_CHECKING, Any

from nicegui import ui

from tactogram.datasets.ratings import SEVEN_POINT
from tactogram.errors import TactogramError
from tactogram.studio.layout import in_background, telling
from tactogram.studio.make.files import draw_photo, draw_vibration
from tactogram.studio.make.form import LONGEST_S, MOST_COUNT, MOST_SEED, word_label
from tactogram.studio.make.material_map import point_of, weights_at

if TYPE_CHECKING:
    from tactogram.studio.make.page import MakePage

FEW = 12
"""Materials up to which each has its slider from the start."""
STEP = 0.01
Box = tuple[float, float, float, float]
MAP_PX = (360.0, 324.0)
"""Size for which names are placed on the map; it is as wide as the form."""
LONGEST_NAME, CHARACTER_PX = 22, 6.0


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
            _words(on)
    if form.has("materials"):
        with part("Materials"):
            if form.mixes:
                _mix(on)
            else:
                _label(on)
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
        select = ui.select(titles, value=desk.asked.run or None, label="Run", on_change=telling(choose))
        select.classes("w-full").props('outlined dense options-dense data-run="1"')
        if desk.choice is not None:
            facts = desk.choice.facts
            with ui.row().classes("items-center gap-2"):
                ui.label(f"{facts.authors[0]} {facts.year}: {facts.title}").classes("small quiet")
                if desk.choice.kind.simulated:
                    ui.label("learned from simulated data").classes("simulated")


# -- materials -------------------------------------------------------------------------------------------


def _mix(on: MakePage) -> None:
    desk = on.desk
    materials = desk.form.materials if desk.form else ()
    shares: dict[str, ui.label] = {}
    sliders: dict[str, ui.slider] = {}
    quiet = [False]

    def tell_shares() -> None:
        mix = desk.asked.mix
        for name, label in shares.items():
            value = mix.get(name, 0.0)
            label.text = f"{100 * value:.0f} %" if desk.asked.to_one else f"{value:.2f}"

    def moved(name: str, value: float | None) -> None:
        if not quiet[0]:
            desk.set(weights={**desk.asked.weights, name: round(float(value or 0), 4)})
            tell_shares()

    def put(weights: dict[str, float]) -> None:
        """Show weights that were set elsewhere."""
        quiet[0] = True
        for name, slider in sliders.items():
            slider.value = weights.get(name, 0.0)
        quiet[0] = False
        tell_shares()

    def finished() -> None:
        handle_to(desk.asked.weights)
        on.committed()

    def to_one(event: Any) -> None:
        desk.set(to_one=bool(event.value))
        tell_shares()
        on.committed()

    ui.switch("Weights sum to 1", value=desk.asked.to_one, on_change=telling(to_one)).props("dense")
    shown = [name for name in materials if len(materials) <= FEW or desk.asked.weights.get(name, 0) > 0]
    with ui.element("div").classes("sliders"):
        for name in shown:
            ui.label(name).classes("name")
            slider = ui.slider(min=0, max=1, step=STEP, value=min(1.0, desk.asked.weights.get(name, 0.0)))
            slider.on_value_change(telling(lambda event, name=name: moved(name, event.value)))
            slider.props(f'aria-label="Weight of {name}" data-material="{name}"').on(
                "change", telling(finished)
            )
            sliders[name] = slider
            shares[name] = ui.label("").classes("share")
    tell_shares()
    if len(shown) < len(materials):
        _add_material(on, [name for name in materials if name not in shown])
    handle_to = _map(on, materials, put, on.committed)


def _add_material(on: MakePage, names: list[str]) -> None:
    def add(event: Any) -> None:
        if event.value:
            on.desk.set(weights={**on.desk.asked.weights, event.value: 0.5})
            on.committed(redraw=True)

    select = ui.select(
        names, label=f"Add one of {len(names)} further materials", with_input=True, on_change=telling(add)
    )
    select.classes("w-full").props("outlined dense options-dense")


def _map(on: MakePage, materials: tuple[str, ...], put: Any, done: Any) -> Any:
    """Draw the map as soon as it is worked out; return what moves its handle to where weights are."""
    held: dict[str, Any] = {}
    if len(materials) < 2:
        return lambda weights: None
    place = ui.element("div").classes("w-full map-place")
    with place, ui.row().classes("items-center"):
        ui.spinner(size="sm")
        ui.label("Working out a map of the materials.").classes("small quiet")

    def handle_to(weights: Any) -> None:
        if held:
            x, y = point_of(weights, materials, held["places"])
            ui.run_javascript(f"window.tactogramMake?.point({x:.4f}, {y:.4f})")

    def moved(event: Any) -> None:
        if not held:
            return
        at, last = [float(event.args[k]) for k in ("x", "y")], bool(event.args["last"])
        share = weights_at([min(1.0, max(0.0, value)) for value in at], held["places"])
        weights = {
            name: round(float(w), 3) for name, w in zip(materials, share, strict=True) if round(float(w), 3)
        }
        on.desk.set(weights=weights)
        if last and len(materials) > FEW:
            on.committed(redraw=True)
            return
        put(weights)
        if last:
            done()

    async def draw() -> None:
        choice = on.desk.choice
        if choice is None:
            return
        try:
            held["places"] = await in_background(on.desk.runs.places, choice)
        except TactogramError as error:
            place.clear()
            with place:
                ui.label(f"No map: {error}").classes("small quiet")
            return
        if place.is_deleted:
            return
        place.clear()
        with place:
            point = point_of(on.desk.asked.weights, materials, held["places"])
            ui.html(map_html(materials, held["places"], point), sanitize=False)
            ui.label(
                "Near materials have like spectra. Drag the point, or move it with the arrow keys: "
                "it is a mix of the three nearest."
            ).classes("small quiet")

    place.on("make-map", telling(moved), js_handler="(event) => emit(event.detail)", throttle=0.05)
    ui.timer(0.01, telling(draw), once=True)
    return handle_to


def map_html(materials: tuple[str, ...], places: Any, point: list[float]) -> str:
    """Return the map as HTML, with its handle; positions are shares of its sides."""
    dots = []
    for name, (x, y), (dx, dy) in zip(materials, places, label_shifts(materials, places), strict=True):
        where = f"left: {100 * x:.2f}%; top: {100 * y:.2f}%"
        dots.append(
            f'<span class="dot" style="{where}"></span><span class="dot-name" style="{where}; '
            f'transform: translate({dx:.0f}px, {dy:.0f}px)">{escape(shortened(name))}</span>'
        )
    names = escape(", ".join(materials), quote=True)
    return (
        f'<div class="map" data-map><div role="img" aria-label="Map of {names}">{"".join(dots)}</div>'
        f'<button type="button" class="map-handle" data-map-handle '
        f'style="left: {100 * point[0]:.2f}%; top: {100 * point[1]:.2f}%" '
        'aria-label="Point on the map of materials: arrow keys move it"></button></div>'
    )


def shortened(name: str) -> str:
    """Return a name that fits on the map."""
    return name if len(name) <= LONGEST_NAME else name[: LONGEST_NAME - 1] + "…"


def label_shifts(materials: tuple[str, ...], places: Any) -> list[tuple[float, float]]:
    """Return by how many pixels the upper left corner of each name stands from its dot.

    Names are placed one after the other, where they cover the least of dots, of names before, and of the edge, on a map
    of `MAP_PX`.
    """
    width, height = MAP_PX
    dots = [(width * x - 6, height * y - 6, width * x + 6, height * y + 6) for x, y in places]
    taken: list[Box] = []
    shifts = []
    for number, name in enumerate(materials):
        x, y = width * places[number][0], height * places[number][1]
        long = CHARACTER_PX * len(shortened(name))
        others = [*taken, *dots[:number], *dots[number + 1 :]]
        best = (float("inf"), (0.0, 0.0), (0.0, 0.0, 0.0, 0.0))
        for dx in (8, -8 - long, -long / 2, -6, 6 - long):
            for dy in (-7, -20, 6) if dx in (8, -8 - long) else (-20, 6):
                box = (x + dx, y + dy, x + dx + long, y + dy + 14)
                cost = sum(_shared(box, other) for other in others) + _outside(box, width, height)
                if cost < best[0] - 1e-9:
                    best = (cost, (dx, dy), box)
        shifts.append(best[1])
        taken.append(best[2])
    return shifts


def _outside(box: Box, width: float, height: float) -> float:
    """Return how much of a box, in square pixels, is beyond the map."""
    beyond_x = max(0.0, -box[0]) + max(0.0, box[2] - width)
    beyond_y = max(0.0, -box[1]) + max(0.0, box[3] - height)
    return beyond_x * (box[3] - box[1]) + beyond_y * (box[2] - box[0])


def _shared(a: Box, b: Box) -> float:
    """Return the area that two boxes (left, top, right, bottom) share."""
    return max(0.0, min(a[2], b[2]) - max(a[0], b[0])) * max(0.0, min(a[3], b[3]) - max(a[1], b[1]))


def _label(on: MakePage) -> None:
    """Draw the one material that a photograph may be said to be of."""

    def choose(event: Any) -> None:
        on.desk.set(weights={event.value: 1.0} if event.value else {})
        on.committed()

    form = on.desk.form
    names = {
        "": "As the model takes the photograph",
        **{name: name for name in (form.materials if form else ())},
    }
    value = next(iter(on.desk.asked.mix), "")
    select = ui.select(names, value=value, label="Material", on_change=telling(choose))
    select.classes("w-full").props("outlined dense options-dense")


# -- words -----------------------------------------------------------------------------------------------


def _words(on: MakePage) -> None:
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

    slider.on_value_change(telling(moved)).on("change", telling(on.committed))
    given.on_value_change(telling(ticked))
    tell()


def _in_order(on: MakePage, words: dict[str, float]) -> dict[str, float]:
    form = on.desk.form
    return {word: words[word] for word in (form.words if form else ()) if word in words}


# -- numbers ---------------------------------------------------------------------------------------------


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
        notes.append("The seed draws the model's latent input, too.")
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
        label, value=getattr(desk.asked, name), min=least, max=most, on_change=telling(changed)
    )
    number.props(f'outlined dense data-number="{name}"' + (" clearable" if not whole else ""))
    number.on("blur", telling(on.committed)).on("keydown.enter", telling(on.committed))
