"""Takes: losses are marked, reported and restored."""

import numpy as np
import pytest
from hypothesis import given, strategies as st

from tactogram.errors import DataError
from tactogram_capture.session.plan import TakeLimits
from tactogram_capture.session.take import (
    Take,
    check_take,
    clipped,
    joined,
    level,
    rate_of,
    recording_of,
    restored,
)
from tactogram_capture.source import Block
from tactogram_capture.stream.gaps import bridged

AXES = ("x", "y", "z")


def take(samples, rate=330.0, measured=329.9):
    return Take(np.asarray(samples, np.float32), AXES, "m/s^2", rate, measured, 70)


def noise(n=100, seed=0):
    return np.random.default_rng(seed).standard_normal((3, n)).astype(np.float32)


@given(st.lists(st.booleans(), min_size=2, max_size=60).filter(any), st.integers(0, 5))
def test_lost_samples_are_restored_as_lost_and_received_ones_exactly(came, seed):
    samples = noise(len(came), seed)
    samples[:, ~np.array(came)] = np.nan
    recording = recording_of(take(samples), what={"material": "a"}, simulated=False)
    np.testing.assert_array_equal(restored(recording), samples)
    assert ("received" in recording.streams) == (not all(came))


def test_a_loss_is_bridged_by_a_straight_line_and_reported():
    samples = noise()
    samples[:, 30:40] = np.nan
    recording = recording_of(take(samples), what={}, simulated=True)
    x = recording.stream("acceleration").samples.astype(np.float64)
    a, b = x[:, 29], x[:, 40]
    np.testing.assert_allclose(x[:, 34], a + (b - a) * 5 / 11, atol=1e-6)
    assert recording.stream("received").samples.sum() == 90
    assert "lost 10 of 100 samples in 1 gaps" in recording.history[1]
    assert "0.091-0.121" in recording.history[1]
    assert "measured 329.9 Hz (-303 ppm)" in recording.history[0]
    assert recording.simulated


def test_a_take_without_losses_has_no_stream_of_losses():
    recording = recording_of(take(noise()), what={}, simulated=False)
    assert set(recording.streams) == {"acceleration"}
    assert len(recording.history) == 1


def test_a_take_with_all_samples_lost_is_no_recording():
    with pytest.raises(DataError, match="all 5 samples were lost"):
        bridged(np.full((3, 5), np.nan, np.float32))


@pytest.mark.parametrize(
    ("measured", "reference", "rate"),
    [
        ((330.2, 330.1, 330.3), 330.0, 330.0),  # near
        ((331.0, 329.0, 333.0), 330.0, 330.0),  # not sure that it is another
        ((331.0, 330.9, 331.1), 330.0, 331.0),
        ((385.0, 360.0, 400.0), 330.0, 330.0),  # a busy computer: a few arrivals say little
        ((400.0, 399.5, 400.5), 330.0, 400.0),
        (None, 330.0, 330.0),
        ((328.0, 327.9, 328.1), None, 328.0),
        ((328.0, 320.0, 336.0), None, None),  # not known well enough to begin
        (None, None, None),
    ],
)
def test_the_rate_is_nominal_unless_the_measurement_contradicts_it(measured, reference, rate):
    measured = measured and dict(zip(("hz", "low", "high"), measured, strict=True))
    assert rate_of(measured, reference) == rate


def test_blocks_are_cut_at_the_limits_and_must_be_consecutive():
    samples = noise(30)
    blocks = [Block(samples[:, i : i + 10], i, 0.0) for i in (0, 10, 20)]
    np.testing.assert_array_equal(joined(blocks, start=7, stop=23), samples[:, 7:23])
    with pytest.raises(DataError, match="consecutive"):
        joined([blocks[0], blocks[2]], start=0, stop=30)
    with pytest.raises(DataError, match="no sample"):
        joined(blocks, start=40, stop=50)


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
