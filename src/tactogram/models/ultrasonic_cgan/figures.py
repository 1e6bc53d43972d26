"""Figures of a run: tree of the surfaces, and curves of the choice of generators."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from matplotlib.figure import Figure
from scipy.cluster.hierarchy import dendrogram

from tactogram.evaluation.checkpoint_selection import SelectionRule, smoothed
from tactogram.models.ultrasonic_cgan.cluster_evaluation import distance
from tactogram.models.ultrasonic_cgan.pair import TrainedCluster
from tactogram.models.ultrasonic_cgan.surfaces import SurfaceTable
from tactogram.signal.figure import AXIS_COLOURS
from tactogram.statistics.figures import BLUE, GRAY, INK, ORANGE

POINTS = 2000
"""Most points drawn of a raw curve."""


def clusters_figure(surfaces: SurfaceTable, *, method: str, title: str = "") -> Figure:
    """Draw the tree of the surfaces by their mean ratings, with names coloured by cluster."""
    figure = Figure(figsize=(max(5.0, 1.5 + 0.55 * len(surfaces.plates)), 3.6), layout="constrained")
    axes = figure.add_subplot()
    if len(surfaces.tree):
        tree = dendrogram(
            surfaces.tree, labels=list(surfaces.plates), ax=axes, color_threshold=0, above_threshold_color=INK
        )
        heights = np.sort(surfaces.tree[:, 2])
        count = surfaces.count
        if 1 < count <= len(heights):
            cut = (heights[-count + 1] + heights[-count]) / 2
            axes.axhline(cut, color="#999999", lw=0.8, ls="--")
            axes.annotate(
                f"cut: {count} clusters", (1, cut), xycoords=("axes fraction", "data"), xytext=(-3, 2),
                textcoords="offset points", fontsize=8, ha="right", color="#666666",
            )  # fmt: skip
        for tick, leaf in zip(axes.get_xticklabels(), tree["leaves"], strict=True):
            tick.set_color(AXIS_COLOURS[int(surfaces.clusters[leaf]) % len(AXIS_COLOURS)])
            tick.set_rotation(45)
            tick.set_horizontalalignment("right")
    axes.set_ylabel(f"distance of mean ratings\n({method} linkage, Euclidean)", fontsize=9)
    axes.tick_params(axis="x", labelsize=8, length=0)
    for side in ("top", "right"):
        axes.spines[side].set_visible(False)
    axes.set_title(title, fontsize=10)
    return figure


def selection_figure(
    trained: Sequence[TrainedCluster], rule: SelectionRule, names: Sequence[str], *, title: str = ""
) -> Figure:
    """Draw losses and correct rates as in Fig. 5, one row per cluster: thin raw, thick smoothed; the choice marked."""
    rows = len(trained)
    figure = Figure(figsize=(10, 0.5 + 2.1 * rows), layout="constrained")
    grid = figure.subplots(rows, 2, squeeze=False, sharex=True)
    for (left, right), gan, name in zip(grid, trained, names, strict=True):
        iterations = np.arange(1, gan.curves.shape[1] + 1)
        thin = max(1, len(iterations) // POINTS)
        for axes, curve, colour, label in (
            (left, gan.curves[0], ORANGE, "generator"),
            (left, gan.curves[1], BLUE, "discriminator"),
            (right, 100 * gan.curves[2], BLUE, "discriminator"),
        ):
            axes.plot(iterations[::thin], curve[::thin], lw=0.4, alpha=0.35, color=colour)
            axes.plot(
                iterations[::thin], smoothed(curve, rule.window)[::thin], lw=1.2, color=colour, label=label
            )
        right.axhspan(100 * rule.low, 100 * rule.high, color="#4d9221", alpha=0.15, lw=0)
        right.set_ylim(0, 103)
        high = float(np.quantile(gan.curves[:2], 0.995)) if gan.curves.size else 1.0
        left.set_ylim(0, 1.1 * high)
        left.set_ylabel("loss")
        right.set_ylabel("correct, %")
        if gan.chosen is None:
            verdict = "failed: no iteration meets the rule"
        else:
            verdict = f"iteration {gan.chosen.iteration:,}: loss {gan.chosen.loss:.3g}, correct {gan.chosen.rate:.0%}"
            for axes in (left, right):
                axes.axvline(gan.chosen.iteration, color="#4d9221", lw=1.2)
        left.set_title(name, fontsize=9, loc="left")
        right.set_title(verdict, fontsize=9, loc="left", color=INK if gan.chosen else ORANGE)
        for axes in (left, right):
            axes.margins(x=0)
            axes.tick_params(labelsize=8)
    grid[0, 0].legend(frameon=False, fontsize=8, loc="upper right", ncols=2)
    for axes in grid[-1]:
        axes.set_xlabel(f"iteration (smoothed over the last {rule.window})")
    figure.suptitle(title, fontsize=10)
    return figure


def spectra_figure(
    surfaces: SurfaceTable, trained: Sequence[TrainedCluster], names: Sequence[str], *, title: str = ""
) -> Figure:
    """Draw a sensor spectrum and the generated one as in Fig. 6, one row per cluster, for its first surface.

    Beside them are the mean of the surface's sensor spectra, and the display signal with the nearest spectrum.
    """
    figure = Figure(figsize=(10, 0.5 + 2.1 * len(trained)), layout="constrained")
    grid = figure.subplots(len(trained), 2, squeeze=False, sharex=True)
    for cluster, ((left, right), gan) in enumerate(zip(grid, trained, strict=True)):
        plate = surfaces.plates.index(surfaces.members(cluster)[0])
        sensor, hertz = surfaces.stored[plate], np.arange(1, surfaces.stored.shape[2] + 1)
        left.plot(hertz, sensor.mean(0), lw=1.2, color=GRAY, label=f"mean of {surfaces.plates[plate]}")
        left.plot(hertz, sensor[0], lw=0.6, color=BLUE, label="input")
        if gan.generator is None:
            right.text(0.5, 0.5, "failed: no generator", transform=right.transAxes, ha="center", color=ORANGE)
        else:
            output, _ = gan.answers(sensor[:1] / surfaces.sensor_scale, surfaces.means[plate])
            spectrum = np.maximum(output[0], 0) * surfaces.display_scale
            away = [distance(spectrum, shown) for shown in surfaces.display.astype(np.float64)]
            index = int(np.argmin(away))
            right.plot(
                hertz,
                surfaces.display[index],
                lw=1.2,
                color=GRAY,
                label=f"nearest: {surfaces.display_items[index]}",
            )
            right.plot(hertz, spectrum, lw=0.6, color=ORANGE, label="output")
            right.legend(frameon=False, fontsize=8)
        left.legend(frameon=False, fontsize=8)
        left.set_title(names[cluster], fontsize=9, loc="left")
        left.set_ylabel("amplitude")
    for axes in grid.ravel():
        axes.set_xscale("log")
        axes.margins(x=0)
        axes.tick_params(labelsize=8)
    for axes, side in zip(grid[-1], ("sensor, standardised", "display's drive, full scale 1"), strict=True):
        axes.set_xlabel(f"Hz ({side})")
    figure.suptitle(title, fontsize=10)
    return figure
