"""Pictures of live recognition."""

from __future__ import annotations

from collections.abc import Sequence
from itertools import groupby

import numpy as np
from matplotlib.figure import Figure

from tactogram.capture.live.recognition import WindowClassification
from tactogram.errors import ParameterError


def live_figure(found: Sequence[WindowClassification], truth: Sequence[str], *, title: str) -> Figure:
    """Return probabilities over time beside what was stroked, what was none of these, and the latency.

    Parameters
    ----------
    truth : sequence of str
        What was stroked at the end of each window.
    """
    judged = [guess for guess in found if guess.heard is not None]
    if not judged or len(found) != len(truth):
        raise ParameterError(
            f"a figure needs a judged window and a name for each, got {len(judged)}, {len(truth)}"
        )
    names = sorted({name for guess in judged if guess.heard for name in guess.heard.probabilities})
    figure = Figure(figsize=(10, 5.6), layout="constrained")
    top, bottom = figure.subplots(2, 1, height_ratios=(3, 1), sharex=True)
    times = np.array([guess.time_s for guess in judged])
    edges = np.concatenate([[times[0] - np.median(np.diff(times))], times])
    shares = np.array([[g.heard.probabilities[name] for g in judged if g.heard] for name in names])
    mesh = top.pcolormesh(edges, np.arange(len(names) + 1) - 0.5, shares, cmap="Blues", vmin=0, vmax=1)
    figure.colorbar(mesh, ax=[top, bottom], label="probability", shrink=0.6)
    top.set_yticks(range(len(names)), names)
    odd = [guess.time_s for guess in judged if guess.heard and guess.heard.none_of_these]
    top.plot(odd, np.full(len(odd), len(names) - 0.25), "|", color="tab:red", markersize=7)
    top.set_ylim(-0.5, len(names) + 0.1)
    top.text(
        edges[0], len(names) - 0.25, "none of these ", ha="right", va="center", color="tab:red", fontsize=9
    )
    for name, group in groupby(zip(found, truth, strict=True), key=lambda pair: pair[1]):
        held = [guess.time_s for guess, _ in group]
        begin, end = held[0], held[-1]
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
