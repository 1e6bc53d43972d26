"""Local amplitudes: clicks of recordings are made, level and spectrum of what is made stay."""

from dataclasses import replace

import numpy as np
import pytest
import scipy

from tactogram.signal import Signal
from tactogram.signal.local_amplitudes import LEVELS, WINDOWS_S, local_quantiles, with_local_quantiles
from tactogram.signal.modulated_noise import mix
from tactogram.signal.modulated_noise_fit import fit_modulated_noise
from tactogram.signal.modulated_noise_synthesis import synthesise_modulated_noise

RATE = 2000.0


def coloured(seed, *, clicks=0.0, axes=1, seconds=6.0):
    """Return noise of one resonance, with ``clicks`` per sample that it answers, shape (axis, time)."""
    random = np.random.default_rng(seed)
    driven = random.standard_normal((axes, round(seconds * RATE)))
    driven += (random.random(driven.shape) < clicks) * 12 * random.standard_normal(driven.shape)
    x = scipy.signal.lfilter([1], [1, -0.9, 0.6], driven)
    return x / x.std(axis=1, keepdims=True)


def kurtosis(x):
    level = np.sqrt(scipy.ndimage.uniform_filter1d(x**2, round(0.05 * RATE), axis=-1))
    return scipy.stats.kurtosis(x / level, axis=-1, fisher=False)


CLICKING = [coloured(seed, clicks=0.01) for seed in range(4)]
QUANTILES = local_quantiles(CLICKING, RATE)


def test_the_quantiles_are_those_of_the_normalised_samples():
    x = CLICKING[0]
    level = np.sqrt(scipy.ndimage.uniform_filter1d(x**2, 100, axis=-1, mode="nearest"))
    own = local_quantiles([x], RATE)
    assert own.shape == (1, len(WINDOWS_S), len(LEVELS))
    median = len(LEVELS) // 2
    assert own[0, 1, median] == pytest.approx(np.median(x / level), abs=1e-9)
    assert own[0, 1, median + 10] == pytest.approx(np.quantile(x / level, scipy.special.ndtr(2.0)), rel=1e-9)
    assert (np.diff(QUANTILES, axis=-1) >= 0).all()


def test_clicks_are_made_and_level_and_spectrum_stay():
    plain = 3 * coloured(9)
    made = with_local_quantiles(plain, RATE, QUANTILES)
    recorded = np.mean([kurtosis(x) for x in CLICKING])
    assert recorded > kurtosis(plain)[0] + 3
    assert recorded - kurtosis(made)[0] < 0.4 * (recorded - kurtosis(plain)[0])
    assert made.std() == pytest.approx(plain.std(), rel=0.02)
    before, after = (scipy.signal.welch(x[0], RATE, nperseg=500)[1][4:-4] for x in (plain, made))
    assert np.sqrt(np.mean((10 * np.log10(after / before)) ** 2)) < 0.3


def test_fluctuations_of_the_level_stay():
    swelling = coloured(9) * (1 + 0.9 * np.sin(2 * np.pi * np.arange(round(6 * RATE)) / RATE))
    made = with_local_quantiles(swelling, RATE, QUANTILES)
    levels = [np.log(x.reshape(-1, 200).std(axis=1)) for x in (swelling, made)]
    assert np.corrcoef(levels)[0, 1] > 0.95


@pytest.mark.parametrize("samples", [np.zeros((1, 400)), np.ones((1, 1)), coloured(1)[:, :7]])
def test_silence_and_the_shortest_signals_stay_finite(samples):
    made = with_local_quantiles(samples, RATE, QUANTILES)
    assert made.shape == samples.shape
    assert np.isfinite(made).all()
    assert np.abs(made.astype(np.float32)).max() <= 10 * np.abs(samples).max()


def signals(recordings):
    return [Signal(x.astype(np.float32), RATE, "m/s^2", ("x", "y")[: len(x)]) for x in recordings]


def test_modulated_noise_has_the_clicks_of_its_recordings():
    model = fit_modulated_noise(signals(CLICKING))
    made = synthesise_modulated_noise(model, 6.0, seed=0)
    streamed = synthesise_modulated_noise(replace(model, local=model.local[:0]), 6.0, seed=0)
    recorded = np.mean([kurtosis(x) for x in CLICKING])
    assert abs(kurtosis(made.samples)[0] - recorded) < 0.5 * abs(kurtosis(streamed.samples)[0] - recorded)


def test_a_mix_has_the_mean_of_the_quantiles():
    clicking, plain = (
        fit_modulated_noise(signals(each), lags=2)
        for each in (CLICKING[:2], [coloured(seed) for seed in (5, 6)])
    )
    mixed = mix([clicking, plain], [1, 3])
    np.testing.assert_allclose(mixed.local, 0.25 * clicking.local + 0.75 * plain.local)
