"""The constant part of a motion: gravity or an offset, which no actuator for vibration gives."""

from __future__ import annotations

import numpy as np

from tactogram.rendering.drive.level_scaling import MOTION
from tactogram.signal import Signal

CHANCE = 0.05
"""Share of the vibration's rms below which a mean is not worth a word."""


def without_constant(signal: Signal, *, least: float = 0.0) -> tuple[Signal, str | None]:
    """Return a motion without its mean, and a sentence where that was more than chance.

    Parameters
    ----------
    signal : Signal
        Of unit m, m/s or m/s^2; forces and friction are returned as they are.
    least : float
        A mean is left where it is, on every axis, below this share of what moves (rms).
    """
    if signal.unit not in MOTION:
        return signal, None
    x = signal.samples.astype(np.float64)
    mean = x.mean(axis=1, keepdims=True)
    vibration = signal.with_samples(x - mean)
    largest, rms = float(np.abs(mean).max()), float(vibration.samples.std())
    if largest < least * rms:
        return signal, None
    if not largest > CHANCE * rms:
        return vibration, None
    words = f"a constant of up to {largest:.3g} {signal.unit} taken out: gravity or an offset, no vibration"
    return vibration, words
