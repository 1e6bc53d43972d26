"""Map of materials as HTML, with as many of its names as fit beside each other."""

from __future__ import annotations

from html import escape
from typing import Any

Box = tuple[float, float, float, float]
WIDE_PX, NARROW_PX = (360.0, 324.0), (268.0, 241.0)
"""Sizes of the map (width, height) on a desktop and on a tablet; names are placed for each."""
LONGEST_NAME, CHARACTER_PX = 22, 6.0
MOST_HIDDEN = 0.2
"""Share of a name that earlier ones may hide; beyond this it is left out, and shows when its dot is pointed at."""


def map_html(materials: tuple[str, ...], places: Any, point: list[float]) -> str:
    """Return the map as HTML, with its handle at ``point``; positions are shares of its sides."""
    dots = []
    shifts = [label_shifts(materials, places, size) for size in (WIDE_PX, NARROW_PX)]
    for name, (x, y), wide, narrow in zip(materials, places, *shifts, strict=True):
        where = f"left: {100 * x:.2f}%; top: {100 * y:.2f}%"
        dots.append(
            f'<span class="dot" style="{where}" title="{escape(name, quote=True)}"></span>'
            f'<span class="dot-name" style="{where}; --wide: {_translation(wide)}; '
            f'--narrow: {_translation(narrow)}">{escape(_shortened(name))}</span>'
        )
    names = escape(", ".join(materials), quote=True)
    return (
        f'<div class="map" data-map><div role="img" aria-label="Map of {names}">{"".join(dots)}</div>'
        f'<button type="button" class="map-handle" data-map-handle '
        f'style="left: {100 * point[0]:.2f}%; top: {100 * point[1]:.2f}%" '
        'aria-label="Point on the map of materials: arrow keys move it"></button></div>'
    )


def _shortened(name: str) -> str:
    return name if len(name) <= LONGEST_NAME else name[: LONGEST_NAME - 1] + "…"


def _translation(shift: tuple[float, float] | None) -> str:
    return "scale(0)" if shift is None else f"translate({shift[0]:.0f}px, {shift[1]:.0f}px)"


def label_shifts(
    materials: tuple[str, ...], places: Any, size: tuple[float, float]
) -> list[tuple[float, float] | None]:
    """Return the offset of each name's upper left corner from its dot, in pixels, on a map of ``size``.

    Names are placed one after another, where they overlap least with dots, earlier names and the edge; None for one
    that does not fit.
    """
    width, height = size
    dots = [(width * x - 6, height * y - 6, width * x + 6, height * y + 6) for x, y in places]
    taken: list[Box] = []
    shifts: list[tuple[float, float] | None] = []
    for number, name in enumerate(materials):
        x, y = width * places[number][0], height * places[number][1]
        long = CHARACTER_PX * len(_shortened(name))
        others = [*taken, *dots[:number], *dots[number + 1 :]]
        best = (float("inf"), (0.0, 0.0), (0.0, 0.0, 0.0, 0.0))
        for dx in (8, -8 - long, -long / 2, -6, 6 - long):
            for dy in (-7, -20, 6) if dx in (8, -8 - long) else (-20, 6):
                box = (x + dx, y + dy, x + dx + long, y + dy + 14)
                cost = sum(_shared(box, other) for other in others) + _outside(box, width, height)
                if cost < best[0] - 1e-9:
                    best = (cost, (dx, dy), box)
        hidden = sum(_shared(best[2], other) for other in taken) + _outside(best[2], width, height)
        if hidden > MOST_HIDDEN * 14 * long:
            shifts.append(None)
        else:
            shifts.append(best[1])
            taken.append(best[2])
    return shifts


def _outside(box: Box, width: float, height: float) -> float:
    """Return roughly the area of a box outside the map."""
    beyond_x = max(0.0, -box[0]) + max(0.0, box[2] - width)
    beyond_y = max(0.0, -box[1]) + max(0.0, box[3] - height)
    return beyond_x * (box[3] - box[1]) + beyond_y * (box[2] - box[0])


def _shared(a: Box, b: Box) -> float:
    """Return the area that two boxes (left, top, right, bottom) share."""
    return max(0.0, min(a[2], b[2]) - max(a[0], b[0])) * max(0.0, min(a[3], b[3]) - max(a[1], b[1]))
