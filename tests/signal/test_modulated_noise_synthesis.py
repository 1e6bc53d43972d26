"""Signals of modulated noise, whole and in blocks."""

from dataclasses import replace

import numpy as np
import pytest
from scipy.signal import coherence, welch
from tests.signal.recorded_noise import MODEL, RATE, RECORDED, UNSEEN, drawn, pulsating

from tactogram.evaluation.measures import signal_measures
from tactogram.signal import Signal
from tactogram.signal.autoregressive_fit import fit_autoregressive
from tactogram.signal.modulated_noise import BANDS, FRAME_S, RIDGE
from tactogram.signal.modulated_noise_fit import fit_modulated_noise
from tactogram.signal.modulated_noise_synthesis import (
    NoiseProcess,
    parameters_of,
    synthesise_modulated_noise,
)
from tactogram.signal.synthesis import synthesise


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


def test_spectrum_has_a_line_where_the_recording_has_one():
    t = np.arange(round(4 * RATE)) / RATE
    hum = Signal(
        np.sin(2 * np.pi * 200 * t) + 0.05 * np.random.default_rng(0).standard_normal(t.size), RATE, "V"
    )
    made = synthesise_modulated_noise(fit_modulated_noise(hum), 4.0, seed=1)
    frequency, density = welch(made.samples[0], RATE, nperseg=500)
    assert frequency[np.argmax(density)] == 200
