import numpy as np
import pytest
from hypothesis import given, settings, strategies as st

from tactogram.errors import ParameterError, UnitError
from tactogram.signal import Signal
from tactogram.signal.displacement import over_displacement, played


def ripple(k, length_mm=100.0, rate=40.0):
    """0.4 plus a ripple of k cycles per mm."""
    x = np.arange(round(length_mm * rate)) / rate
    return Signal(0.4 + 0.1 * np.sin(2 * np.pi * k * x), rate, "1", ("friction",), "displacement")


def inner(signal, share=0.1):
    cut = int(share * len(signal))
    return signal.samples[0, cut:-cut].astype(float)


def amplitude(signal, frequency):
    """The amplitude of a sinusoid by least squares, away from the ends."""
    cut = int(0.1 * len(signal))
    at = np.arange(cut, len(signal) - cut) / signal.rate
    basis = np.stack(
        [np.ones_like(at), np.cos(2 * np.pi * frequency * at), np.sin(2 * np.pi * frequency * at)]
    )
    found = np.linalg.lstsq(basis.T, signal.samples[0, cut : len(signal) - cut].astype(float), rcond=None)[0]
    return np.hypot(found[1], found[2])


@settings(max_examples=20, deadline=None)
@given(st.floats(0.2, 8), st.floats(10, 200))
def test_a_ripple_is_felt_at_speed_times_spatial_frequency(k, speed):
    felt = played(ripple(k), speed, 4000.0)
    assert (felt.domain, felt.rate, felt.unit) == ("time", 4000.0, "1")
    assert felt.seconds == pytest.approx(100 / speed, abs=2 / 4000)
    assert amplitude(felt, k * speed) == pytest.approx(0.1, abs=2e-4)
    assert inner(felt).mean() == pytest.approx(0.4, abs=5e-3)


def test_what_would_be_above_half_the_rate_is_removed_not_folded_back():
    felt = played(ripple(8.0), 100.0, 1000.0)  # 800 Hz at a rate of 1000
    assert np.abs(inner(felt) - 0.4).max() < 1e-3
    assert amplitude(felt, 200.0) < 1e-3


def test_there_and_back_at_a_constant_speed():
    surface = ripple(3.0)
    again = over_displacement(played(surface, 50.0, 4000.0), 50.0, rate=surface.rate)
    assert again.domain == "displacement"
    assert again.length_mm == pytest.approx(100.0, abs=0.05)
    np.testing.assert_allclose(inner(again), inner(surface), atol=2e-4)


def varying(rate=1000.0, seconds=1.5):
    t = np.arange(round(seconds * rate)) / rate
    return Signal(1e-3 * (60 + 20 * np.sin(2 * np.pi * t)), rate, "m/s"), t


def test_a_speed_that_varies_is_undone():
    surface = ripple(2.0)
    speed, t = varying()
    felt = played(surface, speed, 2000.0)
    assert len(felt) == 3000
    place = 60 * t + 20 / (2 * np.pi) * (1 - np.cos(2 * np.pi * t))
    expected = 0.4 + 0.1 * np.sin(2 * np.pi * 2.0 * place)
    np.testing.assert_allclose(felt.samples[0, 200:-200:2], expected[100:-100], atol=5e-4)
    again = over_displacement(felt, speed, rate=40.0)
    n = len(again)
    assert again.length_mm == pytest.approx(place[-1], abs=0.2)
    np.testing.assert_allclose(again.samples[0, 100 : n - 100], surface.samples[0, 100 : n - 100], atol=1e-3)


def test_a_finger_that_comes_back_meets_the_same_ground():
    t = np.arange(2000) / 1000
    speed = Signal(1e-3 * 40 * np.sign(1 - t), 1000.0, "m/s")
    felt = played(ripple(0.7), speed, 1000.0)
    np.testing.assert_allclose(felt.samples[0, 300:700], felt.samples[0, 1700:1300:-1], atol=2e-3)


def test_standstill_is_dropped_and_travel_is_monotone():
    rate = 1000.0
    t = np.arange(3000) / rate
    v = np.where(t < 1, 50.0, np.where(t < 2, 0.0, -50.0))
    friction = Signal(np.where(t < 1, 0.3, np.where(t < 2, 0.9, 0.5)), rate, "1")
    moved = over_displacement(friction, Signal(1e-3 * v, rate, "m/s"), rate=10.0)
    assert moved.length_mm == pytest.approx(100.0, abs=0.3)
    np.testing.assert_allclose(moved.samples[0, 20:480], 0.3, atol=2e-3)
    np.testing.assert_allclose(moved.samples[0, 520:980], 0.5, atol=2e-3)
    assert moved.samples.max() < 0.6


def test_a_speed_of_another_rate_will_do():
    surface = ripple(1.0)
    speed, _ = varying(rate=100.0)
    felt = played(surface, speed, 2000.0)
    again = over_displacement(felt, speed, rate=40.0)
    np.testing.assert_allclose(again.samples[0, 200:3000], surface.samples[0, 200:3000], atol=2e-2)


@pytest.mark.parametrize(
    ("call", "error", "message"),
    [
        (lambda: played(Signal(np.ones(9), 10, "1"), 5.0, 100.0), ParameterError, "over time already"),
        (lambda: over_displacement(ripple(1), 5.0), ParameterError, "over displacement already"),
        (lambda: played(ripple(1), 0.0, 100.0), ParameterError, "speed must be > 0"),
        (lambda: played(ripple(1), 5.0, -1.0), ParameterError, "rate must be > 0"),
        (lambda: played(ripple(1), Signal(np.ones(9), 10, "N"), 100.0), UnitError, "in m/s"),
        (
            lambda: played(ripple(1), Signal(np.ones(9), 1, "m/s"), 100.0),
            ParameterError,
            "the finger moves over",
        ),
        (
            lambda: over_displacement(Signal(np.ones(9), 10, "1"), Signal(np.zeros(9), 10, "m/s")),
            ParameterError,
            "nothing moves",
        ),
        (
            lambda: over_displacement(Signal(np.ones(9), 10, "1"), Signal(np.ones(90), 10, "m/s")),
            ParameterError,
            "equally long",
        ),
    ],
)
def test_refused(call, error, message):
    with pytest.raises(error, match=message):
        call()
