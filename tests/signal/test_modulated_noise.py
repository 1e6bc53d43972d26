"""Modulated noise: spectrum, fluctuation and coupling of what it was fitted to; blocks; mixes; refusals."""

from dataclasses import replace

import numpy as np
import pytest
from scipy.signal import coherence, lfilter, welch
from scipy.stats import multivariate_normal

from tactogram.errors import ParameterError
from tactogram.evaluation.measures import signal_measures
from tactogram.signal import Signal
from tactogram.signal.autoregressive_fit import fit_autoregressive
from tactogram.signal.modulated_noise import BANDS, FRAME_S, RIDGE, equaliser_taps, frame_ends, mix
from tactogram.signal.modulated_noise_fit import fit_modulated_noise, log_likelihood
from tactogram.signal.modulated_noise_synthesis import (
    NoiseProcess,
    parameters_of,
    synthesise_modulated_noise,
)
from tactogram.signal.synthesis import synthesise

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


def yule_walker(covariance):
    """Return coefficients (gain, lag x gain), the latest frame first, and the innovations' covariance."""
    lags, gains = len(covariance) - 1, covariance.shape[1]
    blocks = [
        [covariance[j - i] if j >= i else covariance[i - j].T for j in range(lags)] for i in range(lags)
    ]
    with_past = np.hstack(list(covariance[1:]))
    coefficients = np.linalg.solve(np.block(blocks) + RIDGE * np.eye(lags * gains), with_past.T).T
    return coefficients, covariance[0] + RIDGE * np.eye(gains) - coefficients @ with_past.T


def drawn(model, count=4):
    return [synthesise_modulated_noise(model, 4.0, seed=seed) for seed in range(count)]


def streamed(model, *counts):
    """Return the samples of blocks of some lengths, without the mean, (axis, time)."""
    process, blocks = NoiseProcess(len(model.axes), model.lags, model.rate, seed=3), []
    for count in counts:
        blocks.append(np.empty((len(model.axes), count)))
        process.next(blocks[-1], parameters_of(model))
    return np.hstack(blocks)


def test_what_is_synthesised_without_local_amplitudes_is_what_is_streamed():
    old = replace(MODEL, local=MODEL.local[:0])
    made = synthesise_modulated_noise(old, 0.5, seed=3).samples - old.mean[:, None]
    np.testing.assert_allclose(made, streamed(old, round(0.5 * RATE)), atol=1e-6)


def distance(name, one, other=UNSEEN):
    return signal_measures()[name].function(one, other)


def test_spectrum_level_and_fluctuation_are_those_of_recordings():
    made = drawn(MODEL)
    assert distance("log_spectral_distance_db", made) < 1.5
    assert distance("level_difference_db", made) < 1.0
    assert distance("envelope_spectrum_distance_db", made) < 3.0
    steady = [synthesise(fit_autoregressive(RECORDED), 4.0, seed=seed) for seed in range(4)]
    assert distance("envelope_spectrum_distance_db", steady) > 5.0


def test_blocks_are_the_signal_in_one_piece():
    cut = streamed(MODEL, 1, 4, 5, 19, 20, 21, 330, 2600)
    np.testing.assert_array_equal(cut, streamed(MODEL, 3000))


@pytest.mark.parametrize("rate", [800.0, 1102.5, 3333.3])
def test_blocks_join_where_frames_are_no_whole_number_of_samples(rate):
    noise = np.random.default_rng(0).standard_normal((1, round(2 * rate)))
    model = fit_modulated_noise(Signal(noise, rate, "V"))
    whole = streamed(model, 700)
    np.testing.assert_array_equal(streamed(model, 13, 1, 86, 600), whole)
    assert whole.std() == pytest.approx(1.0, rel=0.15)


def test_seed_decides_every_sample():
    one, same, other = (synthesise_modulated_noise(MODEL, 0.5, seed=seed).samples for seed in (1, 1, 2))
    np.testing.assert_array_equal(one, same)
    assert abs(np.corrcoef(one[0], other[0])[0, 1]) < 0.2


def test_axes_are_as_coherent_as_recorded():
    recorded = []
    for seed in range(4):
        common, own = pulsating(seed).samples[0], pulsating(seed + 50).samples[0]
        recorded.append(
            Signal(np.stack((common, -0.8 * common + 0.6 * own, own)), RATE, "m/s^2", ("x", "y", "z"))
        )
    made = synthesise_modulated_noise(fit_modulated_noise(recorded), 20.0, seed=0).samples
    found = {}
    for a, b in ((0, 1), (1, 2), (0, 2)):
        found[a, b] = float(np.mean(coherence(made[a], made[b], RATE, nperseg=256)[1]))
    assert found[0, 1] == pytest.approx(0.64, abs=0.15)
    assert found[1, 2] == pytest.approx(0.36, abs=0.15)
    assert found[0, 2] < 0.1
    assert np.corrcoef(made[0], made[1])[0, 1] < -0.5


def test_mean_and_a_silent_axis_stay():
    x = pulsating(0).samples[0]
    signal = Signal(np.stack((x + 9.81, np.zeros_like(x))), RATE, "m/s^2", ("x", "z"))
    made = synthesise_modulated_noise(fit_modulated_noise(signal), 2.0, seed=0).samples
    assert made[0].mean() == pytest.approx(9.81, abs=0.05)
    assert np.abs(made[1]).max() < 1e-3 * made[0].std()


def test_mix_is_between_its_models_in_level_and_spectrum():
    strong = fit_modulated_noise([pulsating(seed, level=3.0) for seed in range(3)])
    weak = fit_modulated_noise([pulsating(seed, level=0.03) for seed in range(3)])
    levels = [
        20 * np.log10(np.concatenate([s.samples[0] for s in drawn(mix((strong, weak), (1 - w, w)))]).std())
        for w in (0, 0.25, 0.5, 0.75, 1)
    ]
    np.testing.assert_allclose(np.diff(levels), -10, atol=2.5)


def test_mix_is_stable_and_of_the_scale_of_its_weights_independent():
    fast = fit_modulated_noise([pulsating(seed, frequency=20) for seed in range(3)])
    mixed = mix((MODEL, fast), (2, 1))
    np.testing.assert_array_equal(mixed.covariance, mix((MODEL, fast), (4, 2)).covariance)
    coefficients, _ = yule_walker(mixed.covariance)
    gains = mixed.gains
    companion = np.vstack((coefficients, np.eye(coefficients.shape[1])[:-gains]))
    assert np.abs(np.linalg.eigvals(companion)).max() < 1
    assert mix((MODEL, fast), (0, 1)) is fast


def test_lattice_is_the_regression_of_the_covariances():
    """Rotations keep lengths; their root is that of the innovations; the likelihood is that of Yule and Walker."""
    rotations, root = MODEL.lattice
    for s, k, t in rotations:
        rotation = np.block([[s, k], [-k.T, t]])
        np.testing.assert_allclose(rotation @ rotation.T, np.eye(2 * MODEL.gains), atol=1e-9)
        root = root @ s
    coefficients, innovations = yule_walker(MODEL.covariance)
    np.testing.assert_allclose(root @ root.T, innovations, atol=1e-9)
    z = np.random.default_rng(0).standard_normal((200, MODEL.gains))
    past = np.hstack([z[MODEL.lags - 1 - k : 199 - k] for k in range(MODEL.lags)])
    error = z[MODEL.lags :] - past @ coefficients.T
    expected = multivariate_normal(cov=innovations).logpdf(error).mean()
    assert MODEL.log_likelihood(z) == pytest.approx(expected, rel=1e-9)


def test_scores_have_the_covariance_that_was_fitted():
    process = NoiseProcess(1, MODEL.lags, RATE, seed=0)
    parameters, out, scores = parameters_of(MODEL), np.empty((1, round(FRAME_S * RATE))), []
    for _ in range(20_000):
        process.next(out, parameters)
        scores.append(process._state.scores.copy())
    before, z = np.array(scores).transpose(1, 0, 2)
    np.testing.assert_array_equal(before[1:], z[:-1])  # a frame begins where the last one ended
    for lag in (0, 1, 5, 10):
        found = z[lag:].T @ z[: len(z) - lag] / len(z)
        expected = MODEL.covariance[lag] + (RIDGE * np.eye(MODEL.gains) if lag == 0 else 0)
        np.testing.assert_allclose(found, expected, atol=0.08)


def test_a_texture_that_changes_all_the_time_keeps_its_strength():
    """Another mean of slow and fast fluctuation in each block: it is even a little weaker, and never out of bounds."""
    fast = fit_modulated_noise([pulsating(seed, frequency=25) for seed in range(4)])
    ends = [parameters_of(model) for model in (MODEL, fast)]
    process, random = NoiseProcess(1, MODEL.lags, RATE, seed=0), np.random.default_rng(1)
    blocks = np.empty((4000, 1, 10))
    for out in blocks:
        share = random.random()
        process.next(out, (1 - share) * ends[0] + share * ends[1])
    assert blocks.std() == pytest.approx(0.3, rel=0.15)
    assert np.abs(blocks).max() < 12 * 0.3


STEADY = replace(MODEL, equaliser=np.zeros_like(MODEL.equaliser))
"""Its filter passes everything as it is."""
LOUDER = np.log(10) * (np.arange(MODEL.gains) >= BANDS)[:, None]
"""Of the levels, not of the bands, whose sum is divided by its level."""


@pytest.mark.parametrize(
    ("strong", "ratio"),
    [
        (replace(STEADY, equaliser=STEADY.equaliser + np.log(10)), lambda share: 1 + 9 * share),
        (replace(STEADY, quantiles=STEADY.quantiles + LOUDER), lambda share: 10**share),
    ],
    ids=["spectrum", "level"],
)
def test_parameters_glide_from_those_of_the_block_before(strong, ratio):
    """To ten times the strength: the last sample of the block has it, the first hardly any of it."""
    same, turned = (NoiseProcess(1, MODEL.lags, RATE, seed=2) for _ in range(2))
    x, y = np.empty((3, 1, 40)), np.empty((3, 1, 40))
    for n, model in enumerate((STEADY, strong, strong)):
        same.next(x[n], parameters_of(STEADY))
        turned.next(y[n], parameters_of(model))
    np.testing.assert_array_equal(y[0], x[0])
    np.testing.assert_allclose(y[1] / x[1], [ratio(np.arange(1, 41) / 40)], rtol=1e-6)
    np.testing.assert_allclose(y[2], 10 * x[2], rtol=1e-6)


def test_signals_differ_in_level_as_the_recordings_do():
    """An offset of sd 1 in every normal score: signals are spread like quantiles, and each keeps its own level."""
    flat = replace(MODEL, covariance=0 * MODEL.covariance, equaliser=STEADY.equaliser)
    spread = replace(flat, offsets=np.ones_like(MODEL.offsets))

    def levels(model):
        made = [synthesise_modulated_noise(model, 2.0, seed=seed).samples[0] for seed in range(40)]
        return np.log([[x[:2000].std(), x[2000:].std()] for x in made])

    found = levels(spread)
    assert levels(flat).std() < 0.05
    assert found.std() > 0.3
    np.testing.assert_allclose(found[:, 0], found[:, 1], atol=0.1)


def test_likelihood_prefers_the_fluctuation_it_was_fitted_to():
    other = fit_modulated_noise([pulsating(seed, frequency=25, depth=0.5) for seed in range(4)])
    assert log_likelihood(MODEL, UNSEEN[0]) > log_likelihood(other, UNSEEN[0]) + 0.5


def test_recordings_too_short_for_a_spectrum_are_left_out():
    short = RECORDED[0].cut(0, 10)
    assert fit_modulated_noise([*RECORDED, short]).covariance.tolist() == MODEL.covariance.tolist()


def test_minimum_phase_filter_has_the_magnitude_asked_for():
    wanted = np.log(1 / np.abs(np.fft.rfft([1, -0.9], 500)))
    found = np.abs(np.fft.rfft(equaliser_taps(wanted), 500))
    np.testing.assert_allclose(20 * np.log10(found), 20 / np.log(10) * wanted, atol=0.2)
    energy = np.cumsum(equaliser_taps(wanted) ** 2)
    assert energy[20] > 0.98 * energy[-1]


def test_frames_end_at_the_nearest_sample():
    assert frame_ends(4, 1025.0).tolist() == [10, 21, 31, 41]
    assert frame_ends(4, 1025.0, per_frame=4).tolist() == [3, 5, 8, 10]


@pytest.mark.parametrize(
    ("signals", "options", "message"),
    [
        ([], {}, "at least one recording"),
        (Signal(np.ones(4000), 500.0, "V"), {}, "at least 800 Hz for modulated noise, got 500"),
        (Signal(np.ones(999), 4000.0, "1", domain="displacement"), {}, "over time, not over displacement"),
        (Signal(np.ones(100), RATE, "V"), {}, "at least 0.25 s, got 0.05"),
        (Signal(np.ones(600), RATE, "V"), {"lags": 0}, "lags must be >= 1, got 0"),
        (Signal(np.ones(600), RATE, "V"), {"lags": 40}, "at least 0.42 s, got 0.3"),
        (
            [Signal(np.ones(999), RATE, "V"), Signal(np.ones(999), RATE, "N")],
            {},
            "one rate, unit and set of axes",
        ),
    ],
)
def test_what_cannot_be_fitted_is_refused(signals, options, message):
    with pytest.raises(ParameterError, match=message):
        fit_modulated_noise(signals, **options)


@pytest.mark.parametrize(
    ("call", "message"),
    [
        (lambda: mix((MODEL,), (0,)), "1 numbers >= 0, not all 0"),
        (lambda: mix((MODEL, replace(MODEL, unit="V")), (1, 1)), "one rate, unit, set of axes and order"),
        (
            lambda: replace(MODEL, coupling=np.ones((BANDS, 2, 2))),
            r"coupling must have the shape \(4, 1, 1\)",
        ),
        (lambda: replace(MODEL, mean=np.array([np.nan])), "mean must be finite"),
        (lambda: synthesise_modulated_noise(MODEL, 0.0, seed=0), "seconds must be > 0"),
        (lambda: MODEL.log_likelihood(np.zeros((5, 8))), "frames must be more than 10, got 5"),
    ],
)
def test_invalid_use_is_refused(call, message):
    with pytest.raises(ParameterError, match=message):
        call()


def test_spectrum_has_a_line_where_the_recording_has_one():
    t = np.arange(round(4 * RATE)) / RATE
    hum = Signal(
        np.sin(2 * np.pi * 200 * t) + 0.05 * np.random.default_rng(0).standard_normal(t.size), RATE, "V"
    )
    made = synthesise_modulated_noise(fit_modulated_noise(hum), 4.0, seed=1)
    frequency, density = welch(made.samples[0], RATE, nperseg=500)
    assert frequency[np.argmax(density)] == 200
