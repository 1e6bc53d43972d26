"""Map of materials: their places by spectral differences, the mix at a point between them, and the chart."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
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


def map_options(materials: Sequence[str], places: NDArray[np.float64]) -> dict[str, Any]:
    """Return the options of an ECharts chart with the materials as named dots, x to the right and y down.

    A name that would hide another shows when its dot is pointed at.
    """
    axis = {"type": "value", "min": 0, "max": 1, "show": False}
    dots = [
        {"name": name, "value": [float(x), float(y)], "label": {"position": "right" if x < 0.5 else "left"}}
        for name, (x, y) in zip(materials, places, strict=True)
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
            | {"overflow": "truncate"},
            "labelLayout": {"hideOverlap": True},
            "data": dots,
        },
    }
