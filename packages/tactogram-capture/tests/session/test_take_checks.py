"""Verdicts on takes: each fault is found, and a good take has none."""

import numpy as np
import pytest

from tactogram_capture.session.plan import TakeLimits
from tactogram_capture.session.take import Take
from tactogram_capture.session.take_checks import check_take, clipped, level

RATE, N = 330.0, 3300


def samples(scale=1.0):
    return (scale * np.random.default_rng(0).standard_normal((3, N)) + [[0], [0], [9.81]]).astype(np.float32)


def verdict(x, limits=None, *, measured=330.0, seconds=10.0, **options):
    take = Take(np.asarray(x, np.float32), ("x", "y", "z"), "m/s^2", RATE, measured, 0)
    return check_take(take, TakeLimits(**(limits or {})), seconds=seconds, nominal=330.0, **options)


def bad(found):
    return [f.name for f in found.findings if f.verdict == "bad"]


def test_a_good_take_is_good():
    found = verdict(samples())
    assert found.good
    assert str(found) == "good"
    assert {f.name for f in found.findings} == {"length", "losses", "rate", "clipping", "flat", "level"}


def lost(x, share, run=10):
    for start in range(0, N, round(run / share)):
        x[:, start : start + run] = np.nan
    return x


def test_each_fault_is_found():
    flat, square = samples(), samples()
    flat[1, 1000:1300] = 0.5
    square = np.clip(square, -1.5, 11.0)
    assert bad(verdict(samples()[:, :3000])) == ["length"]
    assert bad(verdict(lost(samples(), 0.1))) == ["losses"]
    assert bad(verdict(lost(samples(), 0.04, run=100))) == ["losses"]
    assert bad(verdict(square, full_scale=11.0)) == ["clipping"]
    assert bad(verdict(flat)) == ["flat"]
    assert bad(verdict(samples(0.05))) == ["level"]
    assert bad(verdict(samples(), measured=300.0)) == ["rate"]


def test_a_take_with_all_samples_lost_is_bad():
    assert bad(verdict(np.full((3, N), np.nan))) == ["losses"]


def test_a_small_loss_is_noted_and_the_take_good():
    found = verdict(lost(samples(), 0.02))
    assert found.good
    assert "2.1 % lost in 7 gaps" in str(found)


def test_clipping_is_detected_without_a_known_full_scale():
    sine = 5 * np.sin(2 * np.pi * 20 * np.arange(N) / RATE)[None]
    noise = samples(1.0)
    assert clipped(np.clip(sine, -4, 4).astype(np.float32), None) > 500
    assert clipped(np.clip(4 * noise, -5, 42).astype(np.float32), None) > 10
    assert clipped(noise, None) == 0


def test_a_sensor_at_rest_with_visible_steps_is_not_clipping():
    steps = np.round(0.4 * np.random.default_rng(1).standard_normal((3, 20_000))) * 0.038
    assert clipped(steps.astype(np.float32), None) == 0


def test_the_level_is_the_rms_about_the_mean_over_all_axes():
    x = np.array([[3, -3, 3, -3], [4, -4, 4, -4], [9, 9, 9, 9]], np.float32)
    assert level(x) == pytest.approx(5.0)
    x[:, 3] = np.nan
    assert level(x) == pytest.approx(np.sqrt(np.var([3, -3, 3]) + np.var([4, -4, 4])))


def test_the_default_least_level_is_for_accelerations_only():
    take = Take(samples(0.01), ("x", "y", "z"), "V", RATE, 330.0, 0)
    assert check_take(take, TakeLimits(), seconds=10).good
    assert not check_take(take, TakeLimits(least_rms=1.0), seconds=10).good
