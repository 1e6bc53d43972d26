import numpy as np
import pytest

from tactogram.signal import Signal
from tactogram.signal.listening import audible


def test_the_strongest_axis_is_heard_without_its_mean_at_its_level():
    time = np.arange(2000) / 1000
    samples = np.stack([0.2 * np.sin(2 * np.pi * 50 * time), 9.8 + np.sin(2 * np.pi * 100 * time)])
    heard = audible(Signal(samples, 1000, "m/s^2", ("x", "z")))
    assert (heard.rate, heard.axes, heard.seconds) == (8000, ("z",), 2)
    expected = np.sin(2 * np.pi * 100 * np.arange(16000) / 8000)
    np.testing.assert_allclose(heard.samples[0, 400:-400], expected[400:-400], atol=0.01)


def test_friction_is_heard_under_a_finger_at_100_mm_per_s():
    wave = np.sin(2 * np.pi * np.arange(1000) / 20)  # 0.5 cycles per mm: 50 Hz
    heard = audible(Signal(wave, 10, "1", domain="displacement"))
    assert (heard.rate, heard.domain, heard.seconds) == (8000, "time", pytest.approx(1))
    spectrum = np.abs(np.fft.rfft(heard.samples[0]))
    assert spectrum.argmax() == 50


def test_what_is_fast_enough_stays_as_it_is():
    wave = np.random.default_rng(0).normal(size=4410)
    heard = audible(Signal(wave, 44100, "1"))
    np.testing.assert_allclose(heard.samples[0], wave - wave.mean(), atol=1e-6)
