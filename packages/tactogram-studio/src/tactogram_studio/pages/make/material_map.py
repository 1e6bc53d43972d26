"""Map of materials: their places by spectral differences, the mix at a point between them, and the map as HTML."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from html import escape
from typing import Any

import numpy as np
from numpy.typing import NDArray

from tactogram.signal import Signal
from tactogram_studio.signals.traits import band_levels

NEIGHBOURS = 3
"""Most materials in the mix of a point."""
MARGIN = 0.1
APART = 0.1
"""Least distance between two materials, in sides of the map, so that each can be reached."""
DEEPEST_DB = 60.0
"""Level below the strongest band at which differences no longer count."""
LEAST = 0.01
"""Share below which a material is omitted from a mix."""

Box = tuple[float, float, float, float]
WIDE_PX, NARROW_PX = (360.0, 324.0), (268.0, 241.0)
"""Sizes of the map (width, height) on a desktop and on a tablet; names are placed for each."""
LONGEST_NAME, CHARACTER_PX = 22, 6.0
MOST_HIDDEN = 0.2
"""Share of a name that earlier ones may hide; beyond this it is left out, and shows when its dot is pointed at."""


def levels_db(signals: Sequence[Signal]) -> NDArray[np.float64]:
    """Return third-octave levels in the bands that all signals share, float64, shape (signal, band), dB."""
    spectra = [band_levels(signal) for signal in signals]
    shared = sorted(set.intersection(*(set(np.round(f, 6)) for f, _ in spectra)))
    rows = [
        [a for f, a in zip(*spectrum, strict=True) if round(float(f), 6) in shared] for spectrum in spectra
    ]
    level = 20 * np.log10(np.maximum(np.array(rows, np.float64), 1e-12))
    if not level.size:
        return np.zeros((len(signals), 0))
    return np.asarray(np.maximum(level, level.max() - DEEPEST_DB))


def positions(features: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return places in the unit square whose distances approximate those of ``features``.

    Classical multidimensional scaling (Torgerson 1952): the two strongest components; places closer than `APART` are
    then moved apart.

    Parameters
    ----------
    features : float64 array, shape (item, feature)

    Returns
    -------
    float64 array, shape (item, 2)
        From the left and from the top, each at least `MARGIN` from the edge. Deterministic.
    """
    n = len(features)
    centred = features - features.mean(0)
    u, s, _ = np.linalg.svd(centred, full_matrices=False)
    place = np.zeros((n, 2))
    for k in range(min(2, len(s))):
        component = u[:, k] * s[k]
        largest = np.argmax(np.abs(component))
        place[:, k] = component * (np.sign(component[largest]) or 1.0)
    extent = np.ptp(place, axis=0).max()
    middle = (place.max(0) + place.min(0)) / 2
    unit = (place - middle) / (extent or 1.0) * (1 - 2 * MARGIN) + 0.5
    return _apart(unit)


def weights_at(point: Sequence[float], places: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return the weights of the items at a point, float64, shape (item,), sum 1.

    Only the nearest `NEIGHBOURS` count, weighted by ((R - d) / (R d))^2 with R the distance of the next one (Franke
    and Nielson 1980): weights change continuously between neighbours, and an item's place gives that item alone.
    """
    distance = np.linalg.norm(places - np.asarray(point, np.float64), axis=1)
    on = distance < 1e-6
    if on.any():
        return np.asarray(on / on.sum())
    if len(places) > NEIGHBOURS:
        reach = np.sort(distance)[NEIGHBOURS]
        share = np.maximum(reach - distance, 0) / (reach * distance)
    else:
        share = 1 / distance
    weight = share**2
    if not weight.any():  # all at the same distance
        weight = np.asarray(distance <= distance.min() * (1 + 1e-9), np.float64)
    weight /= weight.sum()
    weight[weight < LEAST] = 0
    return np.asarray(weight / weight.sum())


def point_of(weights: Mapping[str, float], names: Sequence[str], places: NDArray[np.float64]) -> list[float]:
    """Return the place of the handle for arbitrary weights: their centre."""
    share = np.array([max(0.0, weights.get(name, 0.0)) for name in names])
    if not share.any():
        return [0.5, 0.5]
    return [float(value) for value in share @ places / share.sum()]


def _apart(places: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return places moved until no two are closer than `APART`, in at most a hundred rounds."""
    moved = places.copy()
    n = len(moved)
    least = min(APART, 0.7 / max(1.0, np.sqrt(n)))
    for _ in range(100):
        close = False
        for i in range(n):
            for j in range(i):
                step = moved[i] - moved[j]
                distance = float(np.linalg.norm(step))
                if distance < least * 0.999:
                    close = True
                    angle = 2.4 * (i + j)  # a fixed direction for two at the same place
                    away = step / distance if distance > 1e-9 else np.array([np.cos(angle), np.sin(angle)])
                    moved[i] += away * (least - distance) / 2
                    moved[j] -= away * (least - distance) / 2
        moved = np.clip(moved, MARGIN, 1 - MARGIN)
        if not close:
            break
    return moved


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
