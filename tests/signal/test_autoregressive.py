"""Fitting and mixing autoregressive textures: against scipy, known processes and each other."""

import csv

import numpy as np
import pytest
import soundfile
from hypothesis import given, settings, strategies as st
from scipy.linalg import solve_toeplitz
from scipy.signal import freqz, lfilter, welch

from tactogram.errors import ParameterError
from tactogram.recipe import Preparation
from tactogram.signal import Signal
from tactogram.signal.autoregressive import AutoregressiveModel, mix
from tactogram.signal.autoregressive_fit import fit_autoregressive
from tactogram.signal.line_spectrum import (
    polynomial_of_reflection,
    reflection_of_line_spectrum,
    reflection_of_polynomial,
)
from tactogram.signal.synthesis import synthesise

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


# -- the model ----------------------------------------------------------------------------------------------


def test_power_is_the_integral_of_its_spectrum():
    model = resonance(150, 0.9, 0.3)
    frequencies = np.linspace(0, RATE / 2, 20001)
    integral = np.trapezoid(model.power_spectrum(frequencies)[0], frequencies)
    assert integral == pytest.approx(model.power[0], rel=1e-6)


def test_spectrum_is_scipys():
    model = fit_autoregressive(drawn([1, -1.6, 0.9], 5, 0), order=12)
    frequencies = np.linspace(0, RATE / 2, 257)
    _, response = freqz([1], model.coefficients[0], worN=frequencies, fs=RATE)
    expected = 2 / RATE * model.variance[0] * np.abs(response) ** 2
    np.testing.assert_allclose(model.power_spectrum(frequencies)[0], expected, rtol=1e-9)


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


# -- the fit ------------------------------------------------------------------------------------------------


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


# -- the mix ------------------------------------------------------------------------------------------------


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


# -- real recordings ----------------------------------------------------------------------------------------


@pytest.mark.real_data
def test_synthetic_is_as_near_to_unseen_recordings_as_real_ones(real_data):
    """Log-spectral distance at 20-1000 Hz; the model is fitted to four recordings, judged by four others."""
    folder = real_data("lmt108_sound")
    prepare = Preparation(band=(20, 1000), rate=2500)
    rows = list(csv.DictReader((folder / "index.csv").read_text(encoding="utf-8").splitlines()))
    for material in sorted({row["material"] for row in rows})[::5]:
        files = [folder / row["file"] for row in rows if row["material"] == material]
        sounds = [soundfile.read(file, dtype="float32") for file in files]
        signals = [prepare.apply(Signal(x, rate, "1")) for x, rate in sounds]
        model = fit_autoregressive(signals[:4])
        made = [synthesise(model, signals[0].seconds, seed=seed) for seed in range(4)]

        def levels(signal):
            frequencies, density = welch(signal.samples[0], signal.rate, nperseg=256)
            return 10 * np.log10(density[(frequencies >= 20) & (frequencies <= 1000)])

        def distance(some, others):
            pairs = [levels(a) - levels(b) for a in some for b in others]
            return np.mean([np.sqrt(np.mean(pair**2)) for pair in pairs])

        assert distance(made, signals[4:]) < distance(signals[:4], signals[4:]) + 0.5


def test_reflection_of_polynomial_agrees_with_the_fit():
    model = fit_autoregressive(drawn([1, -1.6, 0.9], 5, 0), order=6)
    np.testing.assert_allclose(
        reflection_of_polynomial(model.coefficients[0]), model.reflection[0], atol=1e-9
    )
