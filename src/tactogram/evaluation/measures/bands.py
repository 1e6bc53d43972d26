"""Frequency bands of measures, their weight by what is felt, and the removal of drift."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike, NDArray
from scipy.signal import sosfiltfilt

from tactogram.errors import ParameterError
from tactogram.signal.filters import butterworth
from tactogram.signal.perception import FELT_HZ, detection_threshold

THRESHOLD_UNITS = ("m", "m/s", "m/s^2")
"""Units with a known detection threshold."""

FELT_LIKE = {"N": "m", "V": "m/s^2", "1": "m/s^2"}
"""Units without a threshold of their own, and the unit whose threshold curve they borrow: its shape, not its level.

Skin is elastic below some 100 Hz, so force follows displacement; the sound of a surface follows its
acceleration, and so do most sensors that give volts or counts."""

FELT_RANGE_DB = 50.0
"""Bands farther than this below the strongest are not counted, whatever the unit. About the range from
the threshold to the unpleasant, which is general knowledge of the field and was not checked in a source."""

UNCERTAIN_DB = 20.0
"""By how much people and contactors may be more sensitive than the threshold curve: some people feel a grasped cylinder
at a tenth of its minimum (see `tactogram.signal.perception`)."""

DRIFT_HZ = 10.0
"""Slower components are movement and drift and would outweigh the vibration."""


def band_edges(low: float, high: float, *, per_octave: int) -> NDArray[np.float64]:
    """Return edges spaced evenly on a logarithmic scale from ``low`` to ``high``, both included.

    ``per_octave`` is approximate: the number of bands is rounded. float64, shape (band + 1,), Hz.
    """
    if not 0 < low < high:
        raise ParameterError(f"band must be 0 < low < high in Hz, got {low:g} {high:g}")
    bands = max(1, round(np.log2(high / low) * per_octave))
    return np.geomspace(low, high, bands + 1)


def felt_edges(rate: float, *, per_octave: int = 3) -> NDArray[np.float64]:
    """Return the edges of the bands of `FELT_HZ` below half of ``rate``, Hz; errors as `check_felt`."""
    check_felt(rate)
    low, high = FELT_HZ
    return band_edges(low, min(high, rate / 2), per_octave=per_octave)


def check_felt(rate: float) -> None:
    """Refuse a ``rate`` in Hz that is too low for vibration."""
    if rate / 2 <= FELT_HZ[0]:
        raise ParameterError(f"rate must be above {2 * FELT_HZ[0]:g} Hz to hold vibration, got {rate:g}")


def band_sums(
    values: NDArray[np.float64], frequency: NDArray[np.float64], edges: NDArray[np.float64]
) -> NDArray[np.float64]:
    """Return ``values``, shape (..., frequency), summed in each band: float64, shape (..., band).

    ``frequency`` is evenly spaced from 0. A value covers one spacing around its frequency and is split between two
    bands at an edge, so no band is empty, however narrow. ``edges`` has shape (band + 1,), Hz.
    """
    spacing = frequency[1] - frequency[0]
    below = np.clip((edges[:, None] - frequency) / spacing + 0.5, 0, 1)
    return np.asarray(values @ np.diff(below, axis=0).T)


def felt_weight(frequency: ArrayLike, unit: str) -> NDArray[np.float64]:
    """Return the factor that turns a power at ``frequency``, > 0 Hz, into a multiple of the threshold's; same shape.

    For `THRESHOLD_UNITS` the weight is absolute: a sine whose *peak* is at the threshold gives 1/2, its mean square in
    units of the threshold's peak. For any other unit it is the shape of a related curve (`FELT_LIKE`), at most 1:
    levels are then only relative. Not limited to `FELT_HZ`.
    """
    weight = detection_threshold(frequency, FELT_LIKE.get(unit, unit)) ** -2.0
    return weight if unit in THRESHOLD_UNITS else weight / weight.max()


def felt_floor_db(unit: str, *levels: NDArray[np.float64]) -> float:
    """Return the level below which nothing is felt next to ``levels`` (dB re threshold), dB.

    `FELT_RANGE_DB` below the strongest, and never lower than `UNCERTAIN_DB` below the threshold (0 dB) where
    ``unit`` has one.
    """
    floor = max(float(level.max()) for level in levels) - FELT_RANGE_DB
    return max(floor, -UNCERTAIN_DB) if unit in THRESHOLD_UNITS else floor


def without_drift(stack: NDArray[np.float64], rate: float) -> NDArray[np.float64]:
    """Return ``stack`` (..., time) high-passed at `DRIFT_HZ`, without its mean and without delay."""
    x = stack - stack.mean(axis=-1, keepdims=True)
    if rate / 2 <= DRIFT_HZ:
        return np.asarray(x)
    sos = butterworth(rate, DRIFT_HZ, np.inf, order=2, passes=2)
    pad = min(x.shape[-1] - 1, int(np.ceil(3 * rate / DRIFT_HZ)))
    return np.asarray(sosfiltfilt(sos, x, axis=-1, padtype="even" if pad else None, padlen=pad))
