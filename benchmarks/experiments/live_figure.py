"""Figures of live recognition."""

from __future__ import annotations

from collections.abc import Sequence
from itertools import groupby

import numpy as np
from matplotlib.figure import Figure

from tactogram.errors import ParameterError
from tactogram_capture.live.recognition import WindowClassification


def live_figure(found: Sequence[WindowClassification], truth: Sequence[str], *, title: str) -> Figure:
    """Draw probabilities over time with the true materials, windows that are none of these, and the latency.

    ``truth`` is the material stroked at the end of each window.
    """
    classified = [guess for guess in found if guess.classification is not None]
    if not classified or len(found) != len(truth):
        raise ParameterError(
            "a figure needs a classified window and a material for each window, got "
            f"{len(classified)} classified, {len(truth)} materials of {len(found)} windows"
        )
    results = [guess.classification for guess in classified if guess.classification]
    names = sorted({name for result in results for name in result.probabilities})
    figure = Figure(figsize=(10, 5.6), layout="constrained")
    top, bottom = figure.subplots(2, 1, height_ratios=(3, 1), sharex=True)
    times = np.array([guess.time_s for guess in classified])
    edges = np.concatenate([[times[0] - np.median(np.diff(times))], times])
    shares = np.array([[result.probabilities[name] for result in results] for name in names])
    mesh = top.pcolormesh(edges, np.arange(len(names) + 1) - 0.5, shares, cmap="Blues", vmin=0, vmax=1)
    figure.colorbar(mesh, ax=[top, bottom], label="probability", shrink=0.6)
    top.set_yticks(range(len(names)), names)
    odd = [
        guess.time_s for guess in classified if guess.classification and guess.classification.none_of_these
    ]
    top.plot(odd, np.full(len(odd), len(names) - 0.25), "|", color="tab:red", markersize=7)
    top.set_ylim(-0.5, len(names) + 0.1)
    top.text(
        edges[0], len(names) - 0.25, "none of these ", ha="right", va="center", color="tab:red", fontsize=9
    )
    for name, group in groupby(zip(found, truth, strict=True), key=lambda pair: pair[1]):
        times_s = [guess.time_s for guess, _ in group]
        begin, end = times_s[0], times_s[-1]
        known = name in names
        if known:
            row = names.index(name)
            top.plot([begin, end], [row - 0.46] * 2, color="tab:green", linewidth=3, solid_capstyle="butt")
        top.axvline(begin, color="0.6", linewidth=0.6)
        top.text(
            (begin + end) / 2, len(names) + 0.15, name if known else f"{name}\n(not trained on)",
            ha="center", va="bottom", fontsize=8, color="tab:green" if known else "tab:red",
        )  # fmt: skip
    figure.suptitle(title, fontsize=10)
    late = [(guess.time_s, 1e3 * guess.latency_s) for guess in found if guess.latency_s is not None]
    if late:
        bottom.plot(*np.array(late).T, ".", color="0.3", markersize=3)
    bottom.set(xlabel="s", ylabel="latency, ms", ylim=(0, None))
    return figure
