"""Noise as recorded: of an autoregressive spectrum, of a strength that follows a sine; and a model of it."""

import numpy as np
from scipy.signal import lfilter

from tactogram.signal import Signal
from tactogram.signal.modulated_noise_fit import fit_modulated_noise
from tactogram.signal.modulated_noise_synthesis import synthesise_modulated_noise

RATE = 2000.0


def pulsating(seed, *, frequency=5.0, depth=0.9, level=0.3, seconds=4.0, pole=0.9, axes=1):
    """Return noise of an autoregressive spectrum whose strength follows a sine of random phase."""
    random = np.random.default_rng(seed)
    count = round(seconds * RATE)
    x = lfilter([1], [1, -1.2, pole**2], random.standard_normal((axes, count + 200)))[:, 200:]
    t = np.arange(count) / RATE
    x *= 1 + depth * np.sin(2 * np.pi * (frequency * t + random.random()))
    return Signal(level * x / x.std(), RATE, "m/s^2", ("x", "y", "z")[:axes])


RECORDED = [pulsating(seed) for seed in range(4)]
UNSEEN = [pulsating(seed) for seed in range(10, 14)]
MODEL = fit_modulated_noise(RECORDED)


def drawn(model, count=4):
    return [synthesise_modulated_noise(model, 4.0, seed=seed) for seed in range(count)]
