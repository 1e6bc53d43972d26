"""Blocks start regularly even if a device requests them irregularly."""

import numpy as np
import pytest

from tactogram_playback.streaming.timing import BlockClock, Durations

LENGTH = 0.005


def begun(asked):
    clock = BlockClock()
    return np.array([clock.start_of(time, LENGTH) for time in asked])


def test_even_requests_stay_as_they_are():
    asked = 3.0 + LENGTH * np.arange(500)
    np.testing.assert_allclose(begun(asked), asked, atol=1e-12)


def test_uneven_requests_become_even():
    rng = np.random.default_rng(0)
    even = LENGTH * np.arange(2000)
    made = begun(even + rng.exponential(0.002, 2000))
    steps = np.diff(made[400:])
    assert np.std(steps) < 5e-5, "a fortieth of the requests' 2 ms"
    assert abs(np.mean(made[400:] - even[400:]) - 0.002) < 5e-4, "late by their mean"


def test_requests_in_pairs_become_even():
    asked = np.repeat(2 * LENGTH * np.arange(1000), 2)  # a device with buffers of two blocks
    assert np.std(np.diff(begun(asked)[400:])) < 2e-4


def test_a_clock_that_runs_fast_is_followed():
    asked = LENGTH * 1.001 * np.arange(4000)  # 0.1 %: far worse than any sound card
    assert np.abs(begun(asked) - asked)[2000:].max() < 1e-4


def test_after_a_standstill_it_begins_anew():
    asked = LENGTH * np.arange(400) + np.where(np.arange(400) < 200, 0, 0.3)
    np.testing.assert_allclose(begun(asked), asked, atol=1e-9)


def test_durations_have_quantiles_to_a_percent():
    durations = Durations()
    values = np.exp(np.random.default_rng(0).normal(-7, 1, 5000))
    for value in values:
        durations.add(float(value))
    for share in (0.5, 0.99):
        assert durations.quantile(share) == pytest.approx(np.quantile(values, share), rel=0.02)
    assert durations.facts()["max_ms"] == pytest.approx(1e3 * values.max())
    assert Durations().facts()["p50_ms"] is None
