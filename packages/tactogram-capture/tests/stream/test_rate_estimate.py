"""The rate of a sensor from sample positions and arrival times."""

import numpy as np
import pytest

from tactogram_capture.stream.rate_estimate import RateMeter, estimate_rate


def arrivals(rate, seconds, *, late_s, seed, loss=0.0, start=0.0):
    rng = np.random.default_rng(seed)
    packets = np.arange(int(seconds * rate / 10))
    kept = packets[rng.random(len(packets)) >= loss]
    due = (kept + 1) * 10 / rate
    return (kept + 1) * 10, start + np.maximum.accumulate(due + rng.exponential(late_s, len(kept)))


def test_rate_of_a_minute_is_within_its_stated_accuracy():
    found = estimate_rate(*arrivals(330.0, 60, late_s=0.005, seed=1, loss=0.02, start=1e6))

    assert found.hz == pytest.approx(330, rel=2e-5)
    assert found.low < found.hz < found.high
    assert (found.high - found.low) / found.hz < 1e-4
    assert found.late_s == pytest.approx(0.005, rel=0.5)


def test_the_interval_contains_the_true_rate_as_often_as_stated():
    rates = np.random.default_rng(0).uniform(100, 800, 100)
    found = [
        estimate_rate(*arrivals(rate, 20, late_s=0.003, seed=seed, loss=0.02))
        for seed, rate in enumerate(rates)
    ]
    held = sum(one.low <= rate <= one.high for one, rate in zip(found, rates, strict=True))

    assert held >= 93


def test_a_burst_of_late_arrivals_does_not_move_it():
    places, times = arrivals(330.0, 30, late_s=0.002, seed=2)
    times[300:360] = times[360]

    assert estimate_rate(places, times).hz == pytest.approx(330, rel=1e-3)


def test_too_few_arrivals_give_no_rate():
    places, times = arrivals(330.0, 1, late_s=0.0, seed=0)

    assert estimate_rate(places[:4], times[:4]) is None
    assert estimate_rate(places, np.full(len(places), np.nan)) is None
    assert estimate_rate(places, np.zeros(len(places))) is None


def test_unknown_arrivals_are_left_out():
    places, times = arrivals(330.0, 10, late_s=0.001, seed=3)
    times[::3] = np.nan

    assert estimate_rate(places, times).hz == pytest.approx(330, rel=1e-3)


def test_meter_keeps_a_long_recording_in_little_memory():
    meter = RateMeter()
    for place, time in zip(*arrivals(330.0, 3600, late_s=0.003, seed=4), strict=True):
        meter.add(int(place), float(time))

    assert len(meter._points) <= 4096
    assert meter.estimate(fresh=True).hz == pytest.approx(330, rel=1e-5)
