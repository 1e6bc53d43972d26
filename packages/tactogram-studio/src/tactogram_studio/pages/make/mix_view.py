"""Mix of the page Make's form: a slider for each material, and a map with a point to drag."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
from nicegui import ui
from numpy.typing import NDArray

from tactogram.errors import TactogramError
from tactogram_studio import kit
from tactogram_studio.generation.runs import point_of, weights_at
from tactogram_studio.generation.state import MakePageState

MOST_SLIDERS = 12
"""Number of materials up to which each has a slider from the start."""
STEP = 0.01
DOT, LETTER = (0.025, 0.028), (0.02, 0.05)
"""Half a dot, and a letter of a name, as shares of the map's sides."""
Box = tuple[float, float, float, float]


def draw_mix(state: MakePageState) -> None:
    """Draw the weights of the materials, and their map."""
    _Mix(state).draw()


class _Mix:
    """Sliders and map, kept in step with each other."""

    def __init__(self, state: MakePageState) -> None:
        self.state = state
        self.materials = state.form.materials
        self.sliders: dict[str, ui.slider] = {}
        self.shares: dict[str, ui.label] = {}
        self.places: NDArray[np.float64] | None = None
        self.setting = False

    def draw(self) -> None:
        weights, materials = self.state.request.weights, self.materials
        few = len(materials) <= MOST_SLIDERS
        shown = [name for name in materials if few or weights.get(name, 0) > 0]
        with ui.element("div").classes("sliders"):
            for name in shown:
                ui.label(name).classes("name")
                slider = ui.slider(min=0, max=1, step=STEP, value=min(1.0, weights.get(name, 0.0)))
                slider.on_value_change(lambda event, name=name: self._slide(name, event.value))
                slider.props(
                    f'aria-label="Weight of {kit.attribute(name)}" data-material="{kit.attribute(name)}"'
                )
                self.sliders[name] = slider.on("change", self._finish_slide)
                self.shares[name] = ui.label("").classes("share")
        self._show_shares()
        if len(shown) < len(materials):
            names = [name for name in materials if name not in shown]
            select = ui.select(names, label=f"Add a material ({len(names)} more)", with_input=True)
            select.on_value_change(self._add_material)
            select.classes("w-full")
        if len(materials) > 1:
            self._draw_map()

    def _show_shares(self) -> None:
        for name, label in self.shares.items():
            label.text = f"{100 * self.state.request.mix.get(name, 0.0):.0f} %"

    def _slide(self, name: str, value: float | None) -> None:
        if not self.setting:
            self.state.set(material={**self.state.request.weights, name: round(float(value or 0), 4)})
            self._show_shares()

    def _finish_slide(self) -> None:
        if self.places is not None:
            x, y = point_of(self.state.request.weights, self.materials, self.places)
            ui.run_javascript(f"window.tactogramMake?.point({x:.4f}, {y:.4f})")
        self.state.commit()

    def _add_material(self, event: Any) -> None:
        if event.value:
            self.state.change(material={**self.state.request.weights, event.value: 0.5})

    # -- the map -----------------------------------------------------------------------------------------

    def _draw_map(self) -> None:
        """Draw the map once it is computed."""
        self.place = ui.element("div").classes("w-full map-place")
        with self.place, ui.row().classes("items-center"):
            ui.spinner(size="sm")
            kit.hint("Computing the map of materials.")
        self.place.on("make-map", self._drag, js_handler="(event) => emit(event.detail)", throttle=0.05)
        ui.timer(0.01, self._fill_map, once=True)

    async def _fill_map(self) -> None:
        run = self.state.run
        if run is None:
            return
        try:
            places = await kit.in_background(self.state.runs.places, run)
        except TactogramError as error:
            self.place.clear()
            with self.place:
                kit.hint(f"No map: {error}")
            return
        self.places = places
        if self.place.is_deleted:
            return
        self.place.clear()
        with self.place:
            x, y = point_of(self.state.request.weights, self.materials, places)
            with ui.element("div").classes("map").props("data-map"):
                chart = ui.echart(map_options(self.materials, places)).classes("absolute-full h-full")
                names = kit.attribute(", ".join(self.materials))
                chart.props(f'role="img" aria-label="Map of {kit.attribute(names)}"')
                handle = ui.element("button").classes("map-handle").props('type="button" data-map-handle')
                handle.props('aria-label="Point on the map of materials: arrow keys move it"')
                handle.style(f"left: {100 * x:.2f}%; top: {100 * y:.2f}%")
            kit.hint(
                "Materials with similar spectra are close together. Drag the point, or move it with the arrow keys, "
                "to mix the three nearest materials."
            )

    def _drag(self, event: Any) -> None:
        if self.places is None:
            return
        point = [min(1.0, max(0.0, float(event.args[key]))) for key in ("x", "y")]
        shares = (round(float(share), 3) for share in weights_at(point, self.places))
        weights = {name: share for name, share in zip(self.materials, shares, strict=True) if share}
        self.state.set(material=weights)
        redraw = len(self.materials) > MOST_SLIDERS
        last = bool(event.args["last"])
        if not (last and redraw):
            self._move_sliders(weights)
        if last:
            self.state.commit(redraw=redraw)

    def _move_sliders(self, weights: Mapping[str, float]) -> None:
        self.setting = True
        for name, slider in self.sliders.items():
            slider.value = weights.get(name, 0.0)
        self.setting = False
        self._show_shares()


def map_options(materials: Sequence[str], places: NDArray[np.float64]) -> dict[str, Any]:
    """Return the options of an ECharts chart with the materials as named dots, x to the right and y down.

    A name that would hide another shows when its dot is pointed at.
    """
    axis = {"type": "value", "min": 0, "max": 1, "show": False}
    dots = [
        {"name": name, "value": [float(x), float(y)], "label": {"position": side}}
        for name, (x, y), side in zip(materials, places, label_sides(materials, places), strict=True)
    ]
    return {
        "animation": False,
        "grid": {"left": 0, "right": 0, "top": 0, "bottom": 0},
        "xAxis": axis,
        "yAxis": {**axis, "inverse": True},
        "tooltip": {"formatter": "{b}"},
        "series": {
            "type": "scatter",
            "symbolSize": 9,
            "itemStyle": {"color": "#51606e"},
            "label": {"show": True, "formatter": "{b}", "color": "#17202a", "fontSize": 11, "width": 130}
            | {"overflow": "truncate", "textBorderColor": "#f6f8f9", "textBorderWidth": 3, "distance": 14},
            "labelLayout": {"hideOverlap": True},
            "data": dots,
        },
    }


def label_sides(materials: Sequence[str], places: NDArray[np.float64]) -> list[str]:
    """Return the side of each dot where its name covers least of dots and earlier names, and stays within the map."""
    taken = [(x - DOT[0], y - DOT[1], x + DOT[0], y + DOT[1]) for x, y in places]
    sides = []
    for name, (x, y) in zip(materials, places, strict=True):
        wide, high = LETTER[0] * len(name), LETTER[1]
        left, top = x - wide / 2, y - high / 2
        corners = {
            "right": (x + DOT[0], top),
            "left": (x - DOT[0] - wide, top),
            "top": (left, y - DOT[1] - high),
            "bottom": (left, y + DOT[1]),
        }
        boxes = {side: (a, b, a + wide, b + high) for side, (a, b) in corners.items()}
        side = min(boxes, key=lambda side: covered(boxes[side], taken))
        sides.append(side)
        taken.append(boxes[side])
    return sides


def covered(box: Box, others: Sequence[Box]) -> float:
    """Return the area of a box that is outside of the map or in ``others``; all are left, top, right and bottom."""
    left, top, right, bottom = box
    outside = (right - left) * (bottom - top) - _common(box, (0, 0, 1, 1))
    return outside + sum(_common(box, other) for other in others)


def _common(one: Box, other: Box) -> float:
    wide, high = min(one[2], other[2]) - max(one[0], other[0]), min(one[3], other[3]) - max(one[1], other[1])
    return max(0.0, wide) * max(0.0, high)
