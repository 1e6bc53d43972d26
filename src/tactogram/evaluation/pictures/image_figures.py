"""Figures of image generators: images per label with the losses, and the trade-off between label and image."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np
from matplotlib.figure import Figure

from tactogram.errors import ParameterError
from tactogram.evaluation.figures import plot_losses
from tactogram.signal import Image


@dataclass(frozen=True, eq=False)
class GeneratorRow:
    """Images and losses of a generator, a row of a figure."""

    title: str
    trials: Sequence[Sequence[Image]]
    """Per noise, the image of each label."""
    losses: Mapping[str, Sequence[tuple[int, float]]]
    """Update and loss, by the network's name."""


def generated_figure(rows: Sequence[GeneratorRow], labels: Sequence[str], *, title: str = "") -> Figure:
    """Draw, per generator, the images of each label from two or more noises, and the losses: Fig. 4 of the paper.

    ``labels`` names the intended impression of each image, e.g. a plate. Raises `ParameterError` if there is no row, or
    a trial has another number of images than ``labels``.
    """
    if not rows:
        raise ParameterError("at least one generator is needed, got none")
    for row in rows:
        if any(len(trial) != len(labels) for trial in row.trials):
            raise ParameterError(f"{row.title}: each trial needs {len(labels)} images, one per label")
    across = 6
    down = -(-len(labels) // across)
    trials = len(rows[0].trials)
    figure = Figure(
        figsize=(1.1 * across * trials + 4.2, 0.4 + len(rows) * (1.12 * down + 0.45)), layout="constrained"
    )
    if title:
        figure.suptitle(title, fontsize=11)
    parts = figure.subfigures(len(rows), 1, squeeze=False)
    for part, row in zip(parts.ravel(), rows, strict=True):
        part.suptitle(row.title, fontsize=10, x=0.01, ha="left")
        cells = part.subfigures(1, trials + 1, width_ratios=[1.1 * across] * trials + [4.2])
        for number, (cell, trial) in enumerate(zip(cells[:-1], row.trials, strict=True), start=1):
            places = cell.subplots(down, across, squeeze=False).ravel()
            for place in places:
                place.axis("off")
            for place, image, label in zip(places, trial, labels, strict=False):
                place.imshow(image.pixels, interpolation="nearest")
                place.set_title(label, fontsize=7, pad=2)
            places[0].text(
                -0.18,
                0.5,
                f"noise {number}",
                rotation=90,
                va="center",
                ha="center",
                fontsize=7,
                transform=places[0].transAxes,
            )
        curves = cells[-1].subplots()
        plot_losses(curves, row.losses)
        curves.set_xlabel("update", fontsize=8)
        curves.set_ylabel("loss", fontsize=8)
        curves.set_ylim(bottom=0)
        curves.tick_params(labelsize=7)
        curves.legend(fontsize=7)
    return figure


@dataclass(frozen=True)
class TradeOff:
    """Label fidelity and distance from real images of one variant; each sequence has a value per training."""

    name: str
    correlation: Sequence[float]
    """Correlation of predicted with requested scores."""
    distance: Sequence[float]
    """Fréchet distance from real images."""
    noise_share: Sequence[float]
    """Spread of images over noises, as a share of that of real ones."""
    label_share: Sequence[float]
    """Spread of images over labels, as a share of that of real ones."""


def trade_off_figure(
    variants: Sequence[TradeOff], *, distance: str, best: float | None = None, title: str = ""
) -> Figure:
    """Draw label fidelity against the ``distance`` (its name) from real images, and the spread of images.

    ``best`` is the correlation that the rater model reaches on real images, an upper limit.
    """
    figure = Figure(figsize=(10.5, 4.0), layout="constrained")
    curve, spread = figure.subplots(1, 2)
    x = [float(np.mean(one.distance)) for one in variants]
    y = [float(np.mean(one.correlation)) for one in variants]
    curve.plot(x, y, "o", color="tab:blue")
    near = 0.1 * (max(x) - min(x))
    for place, (one, left, up) in enumerate(zip(variants, x, y, strict=True)):
        curve.plot(one.distance, one.correlation, ".", color="tab:blue", alpha=0.4)
        stacked = sum(abs(left - other) < near and abs(up - y[n]) < 0.05 for n, other in enumerate(x[:place]))
        curve.annotate(
            one.name,
            (left, up),
            xytext=(6, 6 + 11 * stacked),
            textcoords="offset points",
            fontsize=8,
        )
    curve.axhline(0, color="0.7", linewidth=0.8)
    if best is not None:
        curve.axhline(best, color="0.4", linewidth=0.8, linestyle="--")
        curve.text(
            0.99,
            best,
            "real images unknown to the rater model",
            fontsize=7,
            color="0.3",
            ha="right",
            va="bottom",
            transform=curve.get_yaxis_transform(),
        )
    curve.margins(x=0.3, y=0.15)
    curve.set(
        xlabel=f"{distance} (lower: more like real images)",
        ylabel="correlation of predicted with requested scores",
    )
    places = np.arange(len(variants))
    by_noise = [float(np.mean(one.noise_share)) for one in variants]
    by_label = [float(np.mean(one.label_share)) for one in variants]
    spread.bar(places - 0.18, by_noise, 0.36, color="tab:green", label="over noises of one label")
    spread.bar(places + 0.18, by_label, 0.36, color="tab:purple", label="over labels of one noise")
    spread.axhline(1, color="0.7", linewidth=0.8)
    spread.set_xticks(places, [one.name for one in variants], rotation=30, ha="right", fontsize=8)
    spread.set(ylabel="spread of images, share of real ones")
    spread.legend(fontsize=8)
    if title:
        figure.suptitle(title, fontsize=10)
    return figure
