import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from tactogram.errors import ParameterError, UnitError
from tactogram.signal import Signal
from tactogram.signal.kinematics import differentiate, integrate

RATE = 2000
T = np.arange(2 * RATE) / RATE
MIDDLE = slice(800, -800)


@given(st.floats(40, 900))
@settings(deadline=None, max_examples=25)
def test_the_integral_of_a_sine_is_its_cosine(frequency):
    w = 2 * np.pi * frequency
    velocity = integrate(Signal(np.sin(w * T), RATE, "m/s^2"))
    assert velocity.unit == "m/s"
    np.testing.assert_allclose(velocity.samples[0, MIDDLE] * w, -np.cos(w * T)[MIDDLE], atol=0.01)


@given(st.floats(20, 900))
@settings(deadline=None, max_examples=25)
def test_the_derivative_of_a_sine_is_its_cosine(frequency):
    w = 2 * np.pi * frequency
    velocity = differentiate(Signal(1e-6 * np.sin(w * T), RATE, "m"))
    assert velocity.unit == "m/s"
    np.testing.assert_allclose(velocity.samples[0, MIDDLE] / (1e-6 * w), np.cos(w * T)[MIDDLE], atol=0.02)


def test_a_ramp_has_a_constant_derivative_to_its_ends():
    np.testing.assert_allclose(differentiate(Signal(5 * T, RATE, "m")).samples, 5, rtol=3e-3)


def test_differentiating_undoes_integrating_within_the_band():
    w = 2 * np.pi * 150
    x = Signal(np.stack([np.sin(w * T), np.cos(w * T), np.sin(2 * w * T)]), RATE, "m/s^2")
    twice = differentiate(differentiate(integrate(integrate(x))))
    assert twice.unit == "m/s^2"
    np.testing.assert_allclose(twice.samples[:, MIDDLE], x.samples[:, MIDDLE], atol=5e-3)


def test_an_offset_does_not_drift():
    velocity = integrate(Signal(np.full((3, 4000), 9.81), RATE, "m/s^2"))
    assert np.abs(velocity.samples).max() < 1e-6


@pytest.mark.parametrize(("frequency", "expected"), [(5, -3.01), (1, -60)])
def test_what_is_slower_than_below_is_given_up(frequency, expected):
    t = np.arange(40000) / RATE
    w = 2 * np.pi * frequency
    velocity = integrate(Signal(np.sin(w * t), RATE, "m/s^2"), below=5)
    level = 20 * np.log10(velocity.samples[0, 8000:-8000].std() * np.sqrt(2) * w)
    assert level == pytest.approx(expected, abs=0.1) if frequency == 5 else level < expected


@pytest.mark.parametrize("unit", ["N", "V", "1", "m"])
def test_only_a_motion_is_integrated(unit):
    with pytest.raises(UnitError, match=f"integrated, got {unit}"):
        integrate(Signal(T, RATE, unit))


@pytest.mark.parametrize("unit", ["N", "m/s^2"])
def test_only_a_motion_is_differentiated(unit):
    with pytest.raises(UnitError, match="differentiated, got"):
        differentiate(Signal(T, RATE, unit))


def test_bad_arguments_are_refused():
    x = Signal(T, RATE, "m/s")
    with pytest.raises(ParameterError, match="below must be > 0"):
        integrate(x, below=0)
    with pytest.raises(ParameterError, match="one period of 5 Hz"):
        integrate(x.cut(0, 100))
    with pytest.raises(ParameterError, match="two samples"):
        differentiate(x.cut(0, 1))
    with pytest.raises(ParameterError, match="displacement"):
        differentiate(Signal(T, 20, "m", domain="displacement"))
