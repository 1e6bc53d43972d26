"""Strokes over ribs."""

import numpy as np
from scipy.signal import butter, sosfilt

from tactogram.signal import Signal
from tactogram.signal.modulated_noise import band_edges

RATE, BAND = 1000.0, band_edges(1000.0)[[0, -1]]


def ribs(seed, *, hz=60.0, harmonics=(1.0, 0.5), noise=0.2, wander=0.05, seconds=4.0, axes=2):
    """Return ribs under a finger that is not quite steady: harmonics in fixed phase, and noise."""
    random = np.random.default_rng(seed)
    count = round(seconds * RATE)
    slow = sosfilt(butter(2, 1.5, fs=RATE, output="sos"), random.standard_normal(count + 2000))[2000:]
    speed = hz * np.exp(wander * slow / slow.std())
    phase = 2 * np.pi * (np.cumsum(speed) / RATE + random.random())
    wave = sum(a * np.cos((k + 1) * phase + k) for k, a in enumerate(harmonics))
    shares = np.array([1.0, -0.5, 0.2])[:axes, None]
    x = shares * wave + noise * random.standard_normal((axes, count))
    return Signal(x.astype(np.float32), RATE, "m/s^2", ("x", "y", "z")[:axes])
