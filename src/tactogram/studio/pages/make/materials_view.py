"""The materials of the page Make's form: a slider each, and a map with a point that is dragged."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from nicegui import ui

from tactogram.errors import TactogramError
from tactogram.studio.layout import in_background, report_errors
from tactogram.studio.pages.make.map_picture import map_html
from tactogram.studio.pages.make.material_map import point_of, weights_at

if TYPE_CHECKING:
    from tactogram.studio.pages.make.page import MakePage

FEW = 12
"""Materials up to which each has its slider from the start."""
STEP = 0.01


def draw_mix(on: MakePage) -> None:
    """Draw the weights of the materials, and their map."""
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

    ui.switch("Weights sum to 1", value=desk.asked.to_one, on_change=report_errors(to_one)).props("dense")
    shown = [name for name in materials if len(materials) <= FEW or desk.asked.weights.get(name, 0) > 0]
    with ui.element("div").classes("sliders"):
        for name in shown:
            ui.label(name).classes("name")
            slider = ui.slider(min=0, max=1, step=STEP, value=min(1.0, desk.asked.weights.get(name, 0.0)))
            slider.on_value_change(report_errors(lambda event, name=name: moved(name, event.value)))
            slider.props(f'aria-label="Weight of {name}" data-material="{name}"').on(
                "change", report_errors(finished)
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
        names,
        label=f"Add one of {len(names)} further materials",
        with_input=True,
        on_change=report_errors(add),
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

    place.on("make-map", report_errors(moved), js_handler="(event) => emit(event.detail)", throttle=0.05)
    ui.timer(0.01, report_errors(draw), once=True)
    return handle_to


def draw_label(on: MakePage) -> None:
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
    select = ui.select(names, value=value, label="Material", on_change=report_errors(choose))
    select.classes("w-full").props("outlined dense options-dense")
