"""Seeded textures to hold against each other: simulated, all of it."""

import numpy as np
import pytest
from scipy.signal import lfilter

from tactogram.signal import Signal


def texture(seed, *, centre=150.0, burst_hz=0.0, gain=1.0, seconds=4.0, rate=1000.0, unit="m/s^2", axes=3):
    """Return noise with a resonance, even or in bursts; Y holds X as well, so that they are coherent."""
    random = np.random.default_rng(seed)
    n = round(rate * seconds)
    pole = 0.9 * np.exp(2j * np.pi * centre / rate)
    noise = random.standard_normal((axes, n + 200))
    x = lfilter([1], [1, -2 * pole.real, abs(pole) ** 2], noise)[:, 200:]
    if axes > 1:
        x[1] += x[0]
    if burst_hz:
        speed = 1 + 0.2 * np.repeat(random.standard_normal(n // 250 + 1), 250)[:n]
        x = x * (0.1 + np.maximum(np.sin(2 * np.pi * np.cumsum(burst_hz * speed) / rate), 0) ** 2)
    return Signal(gain * x, rate, unit, tuple("xyzabc"[:axes]))


def even(signal, seed):
    """Return noise with the spectrum of ``signal`` and random phases: its envelope is lost."""
    spectrum = np.fft.rfft(signal.samples)
    phase = np.exp(2j * np.pi * np.random.default_rng(seed).random(spectrum.shape[1]))
    return signal.with_samples(np.fft.irfft(spectrum * phase, n=len(signal)))


@pytest.fixture(name="texture")
def texture_fixture():
    return texture


@pytest.fixture(name="even")
def even_fixture():
    return even
