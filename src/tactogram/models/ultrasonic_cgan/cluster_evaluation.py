"""Figures of the chosen networks on unseen recordings, including collapses."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from itertools import combinations

import numpy as np
from numpy.typing import NDArray

from tactogram.models.ultrasonic_cgan.pair import TrainedCluster
from tactogram.models.ultrasonic_cgan.surfaces import SurfaceTable


def figures_of(
    spectra: Mapping[int, NDArray[np.float32]], surfaces: SurfaceTable, trained: Sequence[TrainedCluster]
) -> dict[str, float]:
    """Return means over the surfaces whose cluster's training did not fail.

    Parameters
    ----------
    spectra : mapping from int to float32 array, shape (spectrum, bin)
        Unseen sensor spectra by surface.
    trained : sequence of TrainedCluster
        One per cluster.

    Returns
    -------
    dict
        ``told_apart_unseen`` (share of the generated spectra that the discriminator detects as generated),
        ``generator_loss_unseen``, ``clamped_bins`` and ``clamped_amplitude`` (shares below 0, of the bins and of the
        sum of their magnitudes), ``within_surface`` and ``between_surfaces`` (distance of generated spectra among
        windows of one surface, and of the surfaces' mean spectra, as a share of their norm: near 0 between surfaces is
        a collapse) and ``to_nearest_display`` (distance of a surface's mean spectrum to the nearest display signal's:
        near 0 is a copy). Empty if every training failed.
    """
    collected: dict[str, list[float]] = {}
    centres = []
    for plate, sensor in spectra.items():
        cluster = trained[surfaces.clusters[plate]]
        if cluster.generator is None:
            continue
        output, probability = cluster.answers(sensor / surfaces.sensor_scale, surfaces.means[plate])
        bins, amplitude = clamped(output)
        generated = np.maximum(output, 0) * surfaces.display_scale
        centres.append(centre := generated.mean(0))
        away = [distance(centre, spectrum) for spectrum in surfaces.display.astype(np.float64)]
        values = {
            "told_apart_unseen": float((probability <= 0.5).mean()),
            "generator_loss_unseen": float(-np.log(np.maximum(probability, 1e-30)).mean()),
            "clamped_bins": bins,
            "clamped_amplitude": amplitude,
            "within_surface": float(np.mean([distance(spectrum, centre) for spectrum in generated])),
            "to_nearest_display": min(away),
        }
        for name, value in values.items():
            collected.setdefault(name, []).append(value)
    figures = {name: float(np.mean(values)) for name, values in collected.items()}
    if len(centres) > 1:
        figures["between_surfaces"] = float(np.mean([distance(a, b) for a, b in combinations(centres, 2)]))
    return figures


def clamped(made: NDArray[np.float64]) -> tuple[float, float]:
    """Return the share of bins below 0, and their share of the sum of magnitudes."""
    total = float(np.abs(made).sum())
    below = float(-np.minimum(made, 0).sum())
    return float((made < 0).mean()), below / total if total else 0.0


def distance(a: NDArray[np.float64], b: NDArray[np.float64]) -> float:
    """Return the Euclidean distance of two spectra, (bin,), over the mean of their norms: 0 same, 2 opposite."""
    size = (float(np.linalg.norm(a)) + float(np.linalg.norm(b))) / 2
    return float(np.linalg.norm(a - b)) / size if size else 0.0
