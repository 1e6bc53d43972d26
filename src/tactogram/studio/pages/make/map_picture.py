"""The map of materials as HTML, its names placed where they cover the least."""

from __future__ import annotations

from html import escape
from typing import Any

Box = tuple[float, float, float, float]
WIDE_PX, NARROW_PX = (360.0, 324.0), (268.0, 241.0)
"""Sizes for which names are placed on the map, which is as wide as the form: of a desktop, and of a tablet."""
LONGEST_NAME, CHARACTER_PX = 22, 6.0


def map_html(materials: tuple[str, ...], places: Any, point: list[float]) -> str:
    """Return the map as HTML, with its handle; positions are shares of its sides."""
    dots = []
    shifts = [label_shifts(materials, places, size) for size in (WIDE_PX, NARROW_PX)]
    for name, (x, y), wide, narrow in zip(materials, places, *shifts, strict=True):
        where = f"left: {100 * x:.2f}%; top: {100 * y:.2f}%"
        dots.append(
            f'<span class="dot" style="{where}"></span><span class="dot-name" style="{where}; '
            f'--wide: {_moved(wide)}; --narrow: {_moved(narrow)}">{escape(shortened(name))}</span>'
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


def _moved(shift: tuple[float, float]) -> str:
    return f"translate({shift[0]:.0f}px, {shift[1]:.0f}px)"


def label_shifts(
    materials: tuple[str, ...], places: Any, size: tuple[float, float]
) -> list[tuple[float, float]]:
    """Return by how many pixels the upper left corner of each name stands from its dot.

    Names are placed one after the other, where they cover the least of dots, of names before, and of the edge, on a map
    of ``size`` (width, height).
    """
    width, height = size
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
