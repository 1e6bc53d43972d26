"""Trade-off of generated images between their labels and their likeness to real images, as a figure."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from matplotlib.figure import Figure


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
    x = [float(np.mean(variant.distance)) for variant in variants]
    y = [float(np.mean(variant.correlation)) for variant in variants]
    curve.plot(x, y, "o", color="tab:blue")
    near = 0.1 * (max(x) - min(x))
    for index, (variant, left, up) in enumerate(zip(variants, x, y, strict=True)):
        curve.plot(variant.distance, variant.correlation, ".", color="tab:blue", alpha=0.4)
        stacked = sum(abs(left - other) < near and abs(up - y[n]) < 0.05 for n, other in enumerate(x[:index]))
        curve.annotate(
            variant.name,
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
    by_noise = [float(np.mean(variant.noise_share)) for variant in variants]
    by_label = [float(np.mean(variant.label_share)) for variant in variants]
    spread.bar(places - 0.18, by_noise, 0.36, color="tab:green", label="over noises of one label")
    spread.bar(places + 0.18, by_label, 0.36, color="tab:purple", label="over labels of one noise")
    spread.axhline(1, color="0.7", linewidth=0.8)
    spread.set_xticks(places, [variant.name for variant in variants], rotation=30, ha="right", fontsize=8)
    spread.set(ylabel="spread of images, share of real ones")
    spread.legend(fontsize=8)
    if title:
        figure.suptitle(title, fontsize=10)
    return figure
