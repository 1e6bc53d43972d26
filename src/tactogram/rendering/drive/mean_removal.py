"""Removal of a motion's constant part: gravity or an offset, which no vibration actuator renders."""

from __future__ import annotations

import numpy as np

from tactogram.rendering.drive.level_scaling import MOTION
from tactogram.signal import Signal

CHANCE = 0.05
"""Share of the vibration's rms below which a mean is not reported."""


def without_constant(signal: Signal, *, least: float = 0.0) -> tuple[Signal, str | None]:
    """Return a motion (m, m/s or m/s^2) without its mean, and a sentence if the mean was significant.

    Other units are returned unchanged, and so is a motion whose mean is below ``least`` times its rms on every axis.
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
    words = f"a constant of up to {largest:.3g} {signal.unit} removed: gravity or an offset, no vibration"
    return vibration, words
