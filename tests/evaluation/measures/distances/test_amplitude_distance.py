"""Amplitude distance."""

import numpy as np
import pytest
from hypothesis import given, settings, strategies as st
from scipy.stats import laplace, norm

from tactogram.evaluation.measures import amplitude_distance
from tactogram.evaluation.measures.distances.amplitude_distance import _squared_wasserstein_2
from tactogram.evaluation.measures.spectra import without_drift
from tactogram.signal import Signal


def drawn(name, seed, n=200_000, **changes):
    return Signal(getattr(np.random.default_rng(seed), name)(size=n), changes.get("rate", 1000), "1")


@given(st.integers(1, 9), st.integers(1, 9), st.integers(0, 100))
@settings(max_examples=40)
def test_samples_of_any_sizes_are_as_far_as_when_repeated_to_one_size(n, m, seed):
    random = np.random.default_rng(seed)
    a, b = np.sort(random.standard_normal(n)), np.sort(random.standard_normal(m))
    expected = np.mean((np.repeat(a, m) - np.repeat(b, n)) ** 2)
    assert _squared_wasserstein_2(a, b) == pytest.approx(expected)


def test_uniform_from_normal_is_as_far_as_their_quantiles():
    # The correlation of quantiles is sqrt(12) E[Phi^-1(U) (U - 1/2)] = sqrt(3 / pi).
    # The high-pass takes 2 % of white noise away and makes the uniform a little more normal.
    expected = np.sqrt(2 * (1 - np.sqrt(3 / np.pi)))
    distance = amplitude_distance([drawn("standard_normal", 0)], [drawn("uniform", 1)])
    assert distance == pytest.approx(expected, abs=0.03)


def test_laplace_from_normal():
    # The correlation of their quantiles, by numerical integration.
    u = (np.arange(1_000_000) + 0.5) / 1_000_000
    r = np.mean(norm.ppf(u) * laplace.ppf(u)) / np.sqrt(2)
    distance = amplitude_distance([drawn("standard_normal", 0)], [drawn("laplace", 1)])
    assert distance == pytest.approx(np.sqrt(2 * (1 - r)), abs=0.03)


def test_rare_impacts_are_detected():
    random = np.random.default_rng(0)
    noise = random.standard_normal(20_000)
    impacts = noise + 15 * (random.random(20_000) < 0.002)
    floor = amplitude_distance([Signal(noise, 1000, "1")], [drawn("standard_normal", 1, 20_000)])
    assert amplitude_distance([Signal(noise, 1000, "1")], [Signal(impacts, 1000, "1")]) > 8 * floor


def test_level_and_order_do_not_count(texture):
    one, other = texture(0), texture(1)
    apart = amplitude_distance([one], [other])
    assert amplitude_distance([one], [other.with_samples(100 * other.samples)]) == pytest.approx(
        apart, rel=1e-3
    )
    quiet = one.with_samples(0.01 * one.samples)
    # Two levels in a set are no heavy tails.
    assert amplitude_distance([one, quiet], [one]) < 1e-3


def test_drift_does_not_count(texture):
    one = texture(0)
    t = np.arange(len(one)) / one.rate
    drifting = one.with_samples(one.samples + 9.81 + 20 * np.sin(2 * np.pi * 0.3 * t))
    assert amplitude_distance([one], [drifting]) < 0.1
    kept = without_drift(drifting.samples.astype(float), 1000.0)
    assert np.std(kept) == pytest.approx(np.std(one.samples), rel=0.05)


def test_the_mirror_image_is_distinguished():
    # Slips jump one way: the mirror image is another texture.
    saw = np.random.default_rng(0).exponential(size=50_000)
    one = Signal(saw - 1, 1000, "1")
    assert amplitude_distance([one], [one.with_samples(-one.samples)]) > 0.5


def test_silence_against_anything_is_1(texture):
    silent = Signal(np.zeros((3, 4000)), 1000, "m/s^2", ("x", "y", "z"))
    assert amplitude_distance([silent], [texture(0)]) == pytest.approx(1, abs=1e-6)
    assert amplitude_distance([silent], [silent]) == 0
    tiny = Signal(np.ones(1), 1000, "1")
    assert amplitude_distance([tiny], [tiny]) == 0
