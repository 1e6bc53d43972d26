"""Drive of the display from scores: sensor spectrum, network and phases."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from tactogram.errors import FailedTrainingError, ParameterError
from tactogram.model import Condition, SignalKind, check_condition, unit_scores
from tactogram.models.ultrasonic_cgan.cluster_evaluation import clamped, distance
from tactogram.models.ultrasonic_cgan.config import Config
from tactogram.models.ultrasonic_cgan.pair import TrainedCluster
from tactogram.models.ultrasonic_cgan.spectra import WINDOW_S, sensor_spectra
from tactogram.models.ultrasonic_cgan.surfaces import SurfaceTable, nearest
from tactogram.signal import Signal
from tactogram.signal.crest_factor import crest_factor, low_crest_phases, periodic_signal, random_phases
from tactogram.training.seeds import child_rng

FULL_SCALE = 1.0
"""Largest sample of the display's modulator, and of the training display signals."""


@dataclass(frozen=True, eq=False)
class GeneratedSpectrum:
    """A generated spectrum and its source.

    Parameters
    ----------
    amplitudes : float64 array, shape (bin,)
        In the display signals' unit, clamped at 0.
    surface : int
        The nearest in words.
    distance : float
        Of the condition's scores from the surface's mean scores.
    source : mapping
        The sensor spectrum of the input.
    clamped : tuple of float
        Shares below 0, of the bins and of the sum of magnitudes.
    """

    amplitudes: NDArray[np.float64]
    surface: int
    distance: float
    source: Mapping[str, Any]
    clamped: tuple[float, float]

    def facts(self, surfaces: SurfaceTable, config: Config, signal: Signal) -> dict[str, Any]:
        """Return the spectrum's facts as JSON values; ``signal`` is its loop."""
        cluster = int(surfaces.clusters[self.surface])
        away = [distance(self.amplitudes, spectrum) for spectrum in surfaces.display.astype(np.float64)]
        index = int(np.argmin(away))
        peak = float(np.abs(signal.samples).max())
        return {
            "surface": surfaces.plates[self.surface],
            "distance": self.distance,
            "group": config.group,
            "cluster": cluster + 1,
            "cluster_surfaces": list(surfaces.members(cluster)),
            "sensor_spectrum": dict(self.source),
            "clamped_bins": self.clamped[0],
            "clamped_amplitude": self.clamped[1],
            "nearest_display_signal": surfaces.display_items[index],
            "nearest_display_distance": away[index],
            "full_scale": FULL_SCALE,
            "peak": peak,
            "crest_factor": crest_factor(signal.samples[0]) if peak else None,
        }


def make(
    condition: Condition,
    surfaces: SurfaceTable,
    trained: Sequence[TrainedCluster],
    kind: SignalKind,
    config: Config,
    *,
    seed: int,
) -> GeneratedSpectrum:
    """Return the spectrum that the networks of the nearest surface's cluster generate for ``condition``."""
    check_condition(condition, needs=("words",), takes=("vibration",))
    scores = unit_scores(condition["words"], kind)
    surface, away = nearest(surfaces.means, scores)
    cluster = int(surfaces.clusters[surface])
    if trained[cluster].chosen is None:
        raise FailedTrainingError(
            f"the training of cluster {cluster + 1} of {config.group} ({', '.join(surfaces.members(cluster))}) "
            f"failed: in none of its {trained[cluster].curves.shape[1]} iterations was the discriminator correct in "
            f"{config.rate_low:.0%} to {config.rate_high:.0%}",
            remedy="use other scores, or train with fewer clusters",
        )
    spectrum, source = _sensor_spectrum(condition.get("vibration"), surface, surfaces, config, seed=seed)
    output, _ = trained[cluster].answers(spectrum[None] / surfaces.sensor_scale, scores)
    return GeneratedSpectrum(
        np.maximum(output[0], 0) * surfaces.display_scale, surface, away, source, clamped(output)
    )


def loop(
    amplitudes: NDArray[np.float64], kind: SignalKind, config: Config, *, seconds: float | None, seed: int
) -> Signal:
    """Return the periodic signal of ``amplitudes`` of 1 Hz, 2 Hz, …, shape (bin,), for ``seconds``, by default 1 s."""
    period = round(WINDOW_S * kind.rate)
    length = period if seconds is None else max(1, round(seconds * kind.rate))
    periods = []
    for axis in kind.axes:
        rng = child_rng(seed, "phase", axis)
        if config.phase == "random":
            phases = random_phases(len(amplitudes), rng=rng)
        else:
            phases = low_crest_phases(amplitudes, length=period, rng=rng)
        periods.append(periodic_signal(amplitudes, phases, length=period))
    samples = np.tile(np.array(periods), math.ceil(length / period))[:, :length]
    return kind.signal(samples.astype(np.float32))


def _sensor_spectrum(
    vibration: Signal | None, surface: int, surfaces: SurfaceTable, config: Config, *, seed: int
) -> tuple[NDArray[np.float32], dict[str, Any]]:
    """Return a sensor spectrum, shape (bin,), drawn from ``vibration`` or the stored ones, and its source."""
    rng = child_rng(seed, "sensor spectrum")
    if vibration is None:
        index = int(rng.integers(surfaces.stored.shape[1]))
        recording, axis, window = surfaces.stored_place[surface, index].tolist()
        source = {"of": "stored", "recording": surfaces.recordings[recording], "axis": axis, "window": window}
        spectrum: NDArray[np.float32] = surfaces.stored[surface, index]
        return spectrum, source
    try:
        spectra = sensor_spectra(vibration, config)
    except ParameterError as error:
        raise ParameterError(f"condition 'vibration': {error}") from error
    axis, window = int(rng.integers(spectra.shape[0])), int(rng.integers(spectra.shape[1]))
    return spectra[axis, window], {"of": "vibration", "axis": vibration.axes[axis], "window": window}
