"""Autoregressive models fitted to recordings."""

import numpy as np
import pytest
from scipy.linalg import solve_toeplitz
from scipy.signal import freqz, lfilter

from tactogram.errors import ParameterError
from tactogram.signal import Signal
from tactogram.signal.autoregressive_fit import fit_autoregressive

RATE = 1000.0


def drawn(polynomial, seconds, seed, deviation=1.0):
    noise = np.random.default_rng(seed).standard_normal(round(seconds * RATE) + 2000) * deviation
    return Signal(lfilter([1], polynomial, noise)[2000:], RATE, "m/s^2")


def test_spectrum_is_scipys():
    model = fit_autoregressive(drawn([1, -1.6, 0.9], 5, 0), order=12)
    frequencies = np.linspace(0, RATE / 2, 257)
    _, response = freqz([1], model.coefficients[0], worN=frequencies, fs=RATE)
    expected = 2 / RATE * model.variance[0] * np.abs(response) ** 2
    np.testing.assert_allclose(model.power_spectrum(frequencies)[0], expected, rtol=1e-9)


@pytest.mark.parametrize("method", ["burg", "yule-walker"])
def test_known_process_is_found(method):
    polynomial = np.poly([0.95 * np.exp(0.7j), 0.95 * np.exp(-0.7j), 0.8, -0.5]).real
    model = fit_autoregressive(drawn(polynomial, 60, 1, deviation=0.2), order=4, method=method)
    np.testing.assert_allclose(model.coefficients[0], polynomial, atol=0.02)
    assert model.variance[0] == pytest.approx(0.04, rel=0.03)


def test_aic_takes_about_the_true_order():
    polynomial = np.poly([0.9 * np.exp(0.7j), 0.9 * np.exp(-0.7j), 0.9 * np.exp(2j), 0.9 * np.exp(-2j)]).real
    orders = [fit_autoregressive(drawn(polynomial, 10, seed), max_order=30).order for seed in range(12)]
    assert min(orders) >= 4  # AIC never takes too few here,
    assert np.median(orders) <= 6  # and a few too many at most (Shibata 1976)


def test_yule_walker_is_scipys_solution():
    signal = drawn([1, -1.2, 0.8], 2, 5)
    x = signal.samples[0].astype(float) - signal.samples[0].astype(float).mean()
    r = np.correlate(x, x, "full")[x.size - 1 : x.size + 8]
    model = fit_autoregressive(signal, order=8, method="yule-walker")
    np.testing.assert_allclose(model.coefficients[0, 1:], solve_toeplitz(r[:-1], -r[1:]), atol=1e-7)


def test_burg_is_its_definition():
    x = drawn([1, -1.2, 0.8], 0.3, 6).samples[0].astype(float)
    x -= x.mean()
    forward, backward, expected = x, x, []
    for _ in range(5):
        f, b = forward[1:], backward[:-1]
        k = -2 * (f @ b) / (f @ f + b @ b)
        expected.append(k)
        forward, backward = f + k * b, b + k * f
    model = fit_autoregressive(Signal(x, RATE, "m/s^2"), order=5)
    np.testing.assert_allclose(model.reflection[0], expected, atol=1e-5)


def test_pieces_are_not_joined():
    """Two pieces of a slow sine, the second upside down: joined there would be a jump to explain."""
    t = np.arange(1000) / RATE
    pieces = [Signal(sign * np.sin(2 * np.pi * 10 * t + 1), RATE, "m/s^2") for sign in (1, -1)]
    joined = Signal(np.hstack([p.samples for p in pieces]), RATE, "m/s^2")
    apart, together = (fit_autoregressive(s, order=4).variance[0] for s in (pieces, joined))
    assert apart < 0.01 * together


def test_many_short_pieces_are_as_good_as_one_long():
    polynomial = [1, -1.6, 0.9]
    pieces = [drawn(polynomial, 0.1, seed) for seed in range(200)]
    model = fit_autoregressive(pieces, order=2)
    np.testing.assert_allclose(model.coefficients[0], polynomial, atol=0.02)


@pytest.mark.parametrize("method", ["burg", "yule-walker"])
def test_level_unit_and_mean_are_those_of_the_data(method):
    signal = Signal(0.3 + 1e-3 * drawn([1, -1.6, 0.9], 2, 7).samples, RATE, "1", ("mu",))
    model = fit_autoregressive(signal, method=method)
    assert (model.unit, model.axes, model.rate) == ("1", ("mu",), RATE)
    assert model.power[0] == pytest.approx(signal.samples[0].astype(float).var(), rel=1e-6)
    assert model.mean[0] == pytest.approx(signal.samples[0].astype(float).mean())


def test_correlation_of_the_axes_is_kept():
    noise = np.random.default_rng(0).multivariate_normal(
        [0, 0, 0], [[1, 0.6, 0], [0.6, 1, 0], [0, 0, 4]], 40000
    )
    signal = Signal(lfilter([1], [1, -1.2, 0.5], noise.T), RATE, "m/s^2")
    model = fit_autoregressive(signal, max_order=10)
    np.testing.assert_allclose(model.correlation, [[1, 0.6, 0], [0.6, 1, 0], [0, 0, 1]], atol=0.02)
    assert model.power[2] / model.power[0] == pytest.approx(4, rel=0.05)


@pytest.mark.parametrize("method", ["burg", "yule-walker"])
def test_silence_and_a_pure_tone_are_fitted(method):
    tone = Signal(np.sin(0.3 * np.arange(3000)), RATE, "V")
    silence = Signal(np.zeros(100), RATE, "V")
    assert fit_autoregressive(tone, max_order=20, method=method).power[0] == pytest.approx(0.5, rel=1e-3)
    assert fit_autoregressive(silence, method=method).power[0] == 0


@pytest.mark.parametrize(
    ("signals", "options", "message"),
    [
        ([], {}, "at least one signal"),
        (Signal(np.ones(10), RATE, "N"), {"order": 10}, "less than the 10 samples"),
        (Signal(np.ones(10), RATE, "N"), {"method": "lpc"}, "method must be"),
        (Signal(np.ones(10), 5, "N", domain="displacement"), {}, "over time"),
        ([Signal(np.ones(10), RATE, "N"), Signal(np.ones(10), RATE, "V")], {}, "equal in rate, unit"),
    ],
)
def test_what_cannot_be_fitted_is_refused(signals, options, message):
    with pytest.raises(ParameterError, match=message):
        fit_autoregressive(signals, **options)
