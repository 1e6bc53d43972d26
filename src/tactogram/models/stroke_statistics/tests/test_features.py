from itertools import pairwise

import numpy as np
import pytest
import torch
from scipy.signal import welch

from tactogram.models.stroke_statistics.features import LENGTHS, Statistics, band_edges


def noise(count=1, axes=1, samples=2048, seed=0):
    return torch.from_numpy(
        np.random.default_rng(seed).standard_normal((count, axes, samples)).astype(np.float32)
    )


def test_band_levels_are_those_of_welch():
    statistics = Statistics(1, 2048)
    x = noise()
    for length in LENGTHS:
        level = statistics._bands(x, length)[0][0, 0].numpy()
        _, power = welch(x[0, 0].numpy(), nperseg=length, detrend=False, scaling="spectrum", window="hann")
        power[-1] *= 2  # a bin of its own in ours, half of one in a one-sided spectrum
        window = np.hanning(length + 1)[:-1]
        scale = window.sum() ** 2 / (window**2).sum() / 2 / length
        edges = band_edges(length)
        sums = np.array([power[1 + a : 1 + b].sum() for a, b in pairwise(edges)])
        assert level == pytest.approx(10 * np.log10(sums * scale), abs=0.05)


@pytest.mark.parametrize("length", LENGTHS)
def test_every_bin_is_in_one_band(length):
    edges = band_edges(length)
    assert (edges[0], edges[-1]) == (0, length // 2)
    assert edges == sorted(set(edges))


def test_the_level_is_kept_and_shape_is_not_changed_by_it():
    statistics, x = Statistics(2, 512), noise(axes=2, samples=512)
    quiet, loud = statistics(x)[0], statistics(10 * x)[0]
    difference = loud - quiet
    assert difference[:2] == pytest.approx([20, 20], abs=1e-3)  # standard deviation of each axis, dB
    changed = difference.abs() > 0.05
    assert difference[changed].numpy() == pytest.approx(np.full(int(changed.sum()), 20), abs=0.05)
    assert 0.25 < float(changed.float().mean()) < 0.45  # levels and mean levels, two of five of each band


def test_impacts_and_steady_noise_of_one_spectrum_differ():
    rng = np.random.default_rng(1)
    steady = rng.standard_normal((50, 1, 1024))
    rare = rng.standard_normal((50, 1, 1024)) * (rng.random((50, 1, 1024)) < 0.05) * np.sqrt(20)
    features = [Statistics(1, 1024)(torch.from_numpy(x.astype(np.float32))).numpy() for x in (steady, rare)]
    kurtosis = [np.exp(each[:, 1]).mean() for each in features]
    assert kurtosis[0] == pytest.approx(3, abs=0.2)
    assert kurtosis[1] > 30


def test_short_windows_have_short_frames_only_and_silence_is_finite():
    assert Statistics(1, 64).lengths == [16]
    assert Statistics(1, 1024).lengths == [16, 64, 256]
    assert bool(torch.isfinite(Statistics(3, 256)(torch.zeros(2, 3, 256))).all())


def test_a_shift_in_time_changes_little():
    statistics, x = Statistics(1, 2000), noise(samples=2400)
    first, later = statistics(x[..., :2000]), statistics(x[..., 400:])
    other = statistics(noise(samples=2000, seed=5) * torch.linspace(0.2, 2, 2000))
    assert (first - later).abs().mean() < 0.6 * (first - other).abs().mean()
