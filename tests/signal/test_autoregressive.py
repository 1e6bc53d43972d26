"""Fitting and mixing autoregressive textures: against scipy, known processes and each other."""

import numpy as np
import pytest
from hypothesis import given, settings, strategies as st
from scipy.signal import lfilter

from tactogram.errors import ParameterError
from tactogram.signal import Signal
from tactogram.signal.autoregressive import AutoregressiveModel, mix
from tactogram.signal.autoregressive_fit import fit_autoregressive
from tactogram.signal.line_spectrum import (
    polynomial_of_reflection,
    reflection_of_line_spectrum,
)

RATE = 1000.0


def resonance(frequency, radius, variance=1.0, unit="m/s^2"):
    angle = 2 * np.pi * frequency / RATE
    polynomial = [1, -2 * radius * np.cos(angle), radius**2]
    return AutoregressiveModel.from_coefficients(polynomial, variance, rate=RATE, unit=unit)


def drawn(polynomial, seconds, seed, deviation=1.0):
    noise = np.random.default_rng(seed).standard_normal(round(seconds * RATE) + 2000) * deviation
    return Signal(lfilter([1], polynomial, noise)[2000:], RATE, "m/s^2")


models = st.builds(
    lambda reflection, variance: AutoregressiveModel(
        np.array([reflection]), np.array([[variance]]), RATE, "m/s^2", ("z",)
    ),
    st.lists(st.floats(-0.99, 0.99), min_size=0, max_size=20),
    st.floats(1e-6, 1e3),
)


def test_power_is_the_integral_of_its_spectrum():
    model = resonance(150, 0.9, 0.3)
    frequencies = np.linspace(0, RATE / 2, 20001)
    integral = np.trapezoid(model.power_spectrum(frequencies)[0], frequencies)
    assert integral == pytest.approx(model.power[0], rel=1e-6)


def test_line_spectrum_and_coefficients_are_the_same_model():
    model = resonance(150, 0.9, 0.3)
    [polynomial] = map(polynomial_of_reflection, map(reflection_of_line_spectrum, model.line_spectrum))
    again = AutoregressiveModel.from_coefficients(polynomial, model.variance, rate=RATE, unit="m/s^2")
    np.testing.assert_allclose(again.coefficients, model.coefficients, atol=1e-12)
    np.testing.assert_allclose(again.power, model.power)


def test_higher_order_is_the_same_process():
    model = resonance(150, 0.9)
    frequencies = np.linspace(0, 500, 50)
    np.testing.assert_allclose(
        model.of_order(30).power_spectrum(frequencies), model.power_spectrum(frequencies)
    )


def test_prediction_error_is_the_inverse_filter():
    signal = drawn([1, -1.6, 0.9], 1, 3)
    model = AutoregressiveModel.from_coefficients([1, -1.6, 0.9], 1, rate=RATE, unit="m/s^2")
    expected = lfilter([1, -1.6, 0.9], [1], signal.samples[0].astype(float))[2:]
    np.testing.assert_allclose(model.prediction_error(signal)[0], expected, atol=1e-9)


@pytest.mark.parametrize(
    ("changes", "message"),
    [
        ({"reflection": np.array([[1.0]])}, "would not be stable"),
        ({"reflection": np.zeros(3)}, "axes, order"),
        ({"innovation": np.eye(2)}, "innovation must be"),
        ({"innovation": np.array([[-1.0]])}, "must be a covariance"),
        ({"innovation": np.array([[np.nan]])}, "finite"),
        ({"rate": 0.0}, "rate must be > 0"),
    ],
)
def test_what_is_no_model_is_refused(changes, message):
    values = {
        "reflection": np.zeros((1, 3)),
        "innovation": np.eye(1),
        "rate": RATE,
        "unit": "N",
        "axes": ("z",),
    }
    with pytest.raises(ParameterError, match=message):
        AutoregressiveModel(**(values | changes))


@settings(deadline=None)
@given(st.lists(models, min_size=2, max_size=4), st.data())
def test_every_mix_is_stable_and_within_the_levels(some, data):
    weights = data.draw(st.lists(st.floats(0.01, 1), min_size=len(some), max_size=len(some)))
    for level in ("log", "linear"):
        mixed = mix(some, weights, level=level)
        powers = [m.power[0] for m in some]
        assert np.all(np.abs(mixed.reflection) < 1)
        assert min(powers) * (1 - 1e-6) <= mixed.power[0] <= max(powers) * (1 + 1e-6)


def test_level_moves_evenly_in_db():
    quiet, loud = resonance(60, 0.95, 1e-4), resonance(300, 0.6, 1.0)
    powers = [mix([quiet, loud], [1 - w, w]).power[0] for w in np.linspace(0, 1, 11)]
    steps = np.diff(10 * np.log10(powers))
    np.testing.assert_allclose(steps, steps.mean(), rtol=1e-6)
    assert powers[0] == pytest.approx(quiet.power[0])
    assert powers[-1] == pytest.approx(loud.power[0])


def test_peak_moves_from_one_to_the_other():
    one, other = resonance(100, 0.95), resonance(200, 0.95)
    frequencies = np.linspace(0, 500, 5001)
    peaks = [
        frequencies[np.argmax(mix([one, other], [1 - w, w]).power_spectrum(frequencies))]
        for w in np.linspace(0, 1, 9)
    ]
    assert np.all(np.diff(peaks) > 0)
    assert peaks[4] == pytest.approx(150, abs=15)


def test_mixing_a_model_with_itself_changes_nothing():
    model = fit_autoregressive(drawn([1, -1.6, 0.9], 5, 0), order=30)
    mixed = mix([model, model], [0.3, 0.7])
    frequencies = np.linspace(0, 500, 200)
    np.testing.assert_allclose(
        mixed.power_spectrum(frequencies), model.power_spectrum(frequencies), rtol=1e-6
    )


def test_mix_knows_its_frequencies():
    """They are kept from the mixing; they must be those of the filter that came out."""
    mixed = mix([resonance(100, 0.95), fit_autoregressive(drawn([1, -1.6, 0.9], 5, 0), order=9)], [0.3, 0.7])
    again = AutoregressiveModel(mixed.reflection, mixed.innovation, mixed.rate, mixed.unit, mixed.axes)
    np.testing.assert_allclose(mixed.line_spectrum, again.line_spectrum, atol=1e-12)


def test_one_weight_alone_is_that_model():
    one, other = resonance(100, 0.95), resonance(200, 0.95)
    assert mix([one, other], [0, 3]) is other


def test_silence_fades_in_and_has_no_spectrum_of_its_own():
    silent = AutoregressiveModel(np.zeros((1, 2)), np.zeros((1, 1)), RATE, "m/s^2", ("z",))
    loud = resonance(200, 0.9)
    mixed = mix([silent, loud], [0.5, 0.5])
    np.testing.assert_allclose(mixed.reflection, loud.reflection, atol=1e-12)
    assert 10 * np.log10(mixed.power[0] / loud.power[0]) == pytest.approx(-30)
    assert mix([silent, loud], [0.5, 0.5], level="linear").power[0] == pytest.approx(loud.power[0] / 2)
    assert mix([silent, silent], [0.5, 0.5]).power[0] == 0


def test_mixing_different_kinds_is_refused():
    with pytest.raises(ParameterError, match="expected 1000 Hz, m/s"):
        mix([resonance(100, 0.9), resonance(100, 0.9, unit="N")], [1, 1])


@pytest.mark.parametrize("weights", [[1], [0, 0], [-1, 2], [np.nan, 1]])
def test_weights_that_are_none_are_refused(weights):
    with pytest.raises(ParameterError, match="weights must be 2 numbers"):
        mix([resonance(100, 0.9), resonance(200, 0.9)], weights)
