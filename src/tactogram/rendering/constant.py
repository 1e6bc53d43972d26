"""The constant part of a motion: gravity or an offset, which no actuator for vibration gives."""

from __future__ import annotations

import numpy as np

from tactogram.rendering.levelled import MOTION
from tactogram.signal import Signal


def without_constant(signal: Signal) -> tuple[Signal, str | None]:
    """Return a motion without its mean, and a sentence where that was more than chance; forces and friction keep it.

    Parameters
    ----------
    signal : Signal
        Of unit m, m/s or m/s^2, or else returned as it is.
    """
    if signal.unit not in MOTION:
        return signal, None
    vibration, largest, rms = _divided(signal)
    return vibration, _told(largest, signal.unit) if largest > 0.05 * rms else None


def without_gravity(signal: Signal) -> tuple[Signal, str | None]:
    """Return a motion without its mean where that is larger than what moves, and a sentence; or it as it is.

    Parameters
    ----------
    signal : Signal
        Of unit m, m/s or m/s^2, or else returned as it is.
    """
    if signal.unit not in MOTION:
        return signal, None
    vibration, largest, rms = _divided(signal)
    return (vibration, _told(largest, signal.unit)) if largest > rms else (signal, None)


def _divided(signal: Signal) -> tuple[Signal, float, float]:
    """Return what moves, the largest mean of an axis, and the rms of what moves."""
    x = signal.samples.astype(np.float64)
    mean = x.mean(axis=1, keepdims=True)
    vibration = signal.with_samples(x - mean)
    return vibration, float(np.abs(mean).max()), float(vibration.samples.std())


def _told(largest: float, unit: str) -> str:
    return f"a constant of up to {largest:.3g} {unit} taken out: gravity or an offset, no vibration"
