"""Generated items by their scores in words: distances to their targets, and a map."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np
from matplotlib.figure import Figure
from numpy.typing import NDArray

from tactogram.errors import ParameterError
from tactogram.signal import AXIS_COLOURS
from tactogram.statistics import BLUE, GRAY, INK, ORANGE

MARKS = "osD^vP*Xh<>"
Floats = NDArray[np.float64]


def distances_to_targets(
    scores: Mapping[str, Floats], targets: Mapping[str, Floats]
) -> dict[str, tuple[str, float]]:
    """Return each generated item's target and its root mean square distance to it over words, points of the scale.

    Raises `ParameterError` if a name has no target.

    Parameters
    ----------
    scores : mapping from str to float64 array, shape (word,)
        By item, named ``GROUP/TARGET``.
    targets : mapping from str to float64 array, shape (word,)
    """
    distances = {}
    for name, row in scores.items():
        target = name.rpartition("/")[2]
        if target not in targets:
            raise ParameterError(f"{name}: target must be one of {', '.join(targets)}, got {target!r}")
        distances[name] = (target, float(np.sqrt(np.nanmean((row - targets[target]) ** 2))))
    return distances


def word_map_figure(
    kinds: Mapping[str, Mapping[str, NDArray[np.float64]]],
    words: Sequence[str],
    *,
    targets: Mapping[str, str] | None = None,
    title: str = "",
) -> Figure:
    """Draw surfaces, signals and generated signals by their scores, with a line from each to its target.

    The plane is spanned by the first two principal components of the first two kinds, so generated items do not
    rotate it. Each line is labelled with the distance over all words, which the plane does not show.

    Parameters
    ----------
    kinds : mapping from str to mapping from str to float64 array, shape (word,)
        By kind and item: scores.
    targets : mapping from str to str, optional
        ``KIND:ITEM`` to ``KIND:ITEM``.
    """
    fitted = np.array([row for items in list(kinds.values())[:2] for row in items.values()])
    centre = fitted.mean(0)
    _, sizes, directions = np.linalg.svd(fitted - centre, full_matrices=False)
    plane = directions[:2] * np.sign(directions[:2].sum(1, keepdims=True) + 1e-12)
    share = sizes[:2] ** 2 / (sizes**2).sum()
    places = {
        f"{kind}:{item}": (row - centre) @ plane.T
        for kind, items in kinds.items()
        for item, row in items.items()
    }
    scores = {f"{kind}:{item}": row for kind, items in kinds.items() for item, row in items.items()}
    figure = Figure(figsize=(9, 7), layout="constrained")
    axes = figure.add_subplot()
    colours = (INK, GRAY, *AXIS_COLOURS)
    for source, target in (targets or {}).items():
        ends = np.array([places[source], places[target]])
        away = float(np.sqrt(np.mean((scores[source] - scores[target]) ** 2)))
        axes.plot(*ends.T, color=ORANGE, lw=0.6, alpha=0.6, zorder=1)
        middle = ends.mean(0).tolist()
        axes.text(middle[0], middle[1], f"{away:.1f}", fontsize=5.5, color=ORANGE, ha="center", zorder=4)
    for number, (kind, items) in enumerate(kinds.items()):
        xy = np.array([places[f"{kind}:{item}"] for item in items])
        colour = colours[number % len(colours)]
        axes.plot(
            *xy.T, MARKS[number % len(MARKS)], color=colour, ms=8 if number == 0 else 5, label=kind, zorder=3
        )
        if number == 0:
            for item, point in zip(items, xy, strict=True):
                axes.annotate(
                    item, point, xytext=(5, 4), textcoords="offset points", fontsize=7, color=colour
                )
    reach = 0.9 * float(np.abs(np.array(list(places.values()))).max())
    longest = float(np.linalg.norm(plane, axis=0).max())
    for word, (x, y) in zip(words, (plane / longest * reach * 0.55).T, strict=True):
        if np.hypot(x, y) > 0.12 * reach:
            axes.annotate(
                word,
                (0, 0),
                (x, y),
                fontsize=8,
                color=BLUE,
                ha="center",
                alpha=0.8,
                arrowprops={"arrowstyle": "<-", "color": BLUE, "alpha": 0.3},
            )
    axes.set_xlabel(f"first principal component, points ({100 * share[0]:.0f} % of the variance)")
    axes.set_ylabel(f"second, points ({100 * share[1]:.0f} %)")
    axes.set_title(title, fontsize=10)
    axes.set_aspect("equal", adjustable="datalim")
    figure.legend(loc="outside lower center", ncols=min(len(kinds), 4), fontsize=8, frameon=False)
    return figure
