import numpy as np
import pytest
from hypothesis import given, settings, strategies as st

from tactogram.errors import DataError, ParameterError
from tactogram.signal import timing
from tactogram.signal.timing import estimate_timing, to_uniform


def stamps(count, rate, *, jitter=0.0, lost=0.0, seed=0):
    """Return time stamps with a jitter in periods (rms), and how many were lost."""
    rng = np.random.default_rng(seed)
    k = np.arange(count)
    inside = (k > 0) & (k < count - 1)
    k = k[~(inside & (rng.random(count) < lost))]
    return np.sort((k + jitter * rng.normal(size=len(k))) / rate), count - len(k)


def error_db(signal, start, frequency, level=1.0, margin=30):
    t = start + np.arange(len(signal)) / signal.rate
    error = signal.samples[0] - level * np.sin(2 * np.pi * frequency * t)
    return 20 * np.log10(np.sqrt(np.mean(error[margin:-margin] ** 2)) * np.sqrt(2) / level)


@given(st.floats(100, 10000), st.floats(0, 0.2), st.floats(0, 0.02), st.integers(0, 1000))
@settings(deadline=None, max_examples=25)
def test_rate_is_estimated_within_100_ppm(rate, jitter, lost, seed):
    t, missing = stamps(4000, rate, jitter=jitter, lost=lost, seed=seed)
    timing = estimate_timing(t + 1e3)
    assert timing.rate == pytest.approx(rate, rel=1e-4)
    assert abs(timing.dropped - missing) <= 1
    assert timing.jitter_rms == pytest.approx(jitter / rate, rel=0.1, abs=1e-3 / rate)
    assert timing.largest_gap == np.diff(t + 1e3).max()


@given(st.floats(0.02, 0.6), st.floats(0.005, 0.1), st.integers(0, 1000))
@settings(deadline=None, max_examples=25)
def test_a_sine_is_recovered_from_jittered_samples(share, jitter, seed):
    """The accuracy that `to_uniform` states: -60 dB to 0.6 of half the rate at 10 % jitter."""
    t, _ = stamps(2000, 1000, jitter=jitter, seed=seed)
    signal = to_uniform(t, np.sin(2 * np.pi * share * 500 * t), "m/s^2")
    assert error_db(signal, t[0], share * 500) < -60


@given(st.floats(0.02, 0.4), st.floats(0.005, 0.2), st.floats(0, 0.02), st.integers(0, 1000))
@settings(deadline=None, max_examples=25)
def test_a_sine_is_recovered_when_samples_are_lost(share, jitter, lost, seed):
    """The accuracy that `to_uniform` states: -40 dB to 0.4 of half the rate at 20 % jitter and 2 % losses."""
    t, _ = stamps(2000, 1000, jitter=jitter, lost=lost, seed=seed)
    signal = to_uniform(t, np.sin(2 * np.pi * share * 500 * t), "m/s^2")
    assert error_db(signal, t[0], share * 500) < -40


def test_it_is_far_better_than_the_nearest_sample_or_a_straight_line():
    t, _ = stamps(4000, 1000, jitter=0.1)
    x = np.sin(2 * np.pi * 150 * t)
    signal = to_uniform(t, x, "V")
    grid = t[0] + np.arange(len(signal)) / signal.rate
    line = signal.with_samples(np.interp(grid, t, x))
    nearest = signal.with_samples(x[np.abs(grid[:, None] - t[None, :]).argmin(axis=1)])
    assert error_db(signal, t[0], 150) < error_db(line, t[0], 150) - 50
    assert error_db(line, t[0], 150) < error_db(nearest, t[0], 150)


def test_noise_is_not_amplified():
    rng = np.random.default_rng(3)
    t, _ = stamps(4000, 1000, jitter=0.2, lost=0.02)
    noise = to_uniform(t, rng.normal(size=(3, len(t))), "m/s^2")
    assert noise.samples.std() < 1.5


def test_a_constant_stays_one_even_in_a_long_gap():
    t, _ = stamps(1000, 1000, jitter=0.1)
    t = np.delete(t, slice(300, 360))
    signal = to_uniform(t, np.full((3, len(t)), 9.81), "m/s^2")
    np.testing.assert_allclose(signal.samples, 9.81, atol=1e-5)


def test_rounded_stamps_leave_the_samples_alone():
    t = np.round(np.arange(3000) / 330, 3)
    x = np.random.default_rng(0).normal(size=3000).astype(np.float32)
    timing = estimate_timing(t)
    assert timing.even
    assert timing.resolution == 1e-3
    assert timing.rate == pytest.approx(330, rel=1e-5)
    np.testing.assert_array_equal(to_uniform(t, x, "V").samples[0], x)


def test_rounded_stamps_with_losses_are_put_back_on_the_clock():
    t, missing = stamps(3000, 330, lost=0.02)
    x = np.sin(2 * np.pi * 40 * t)
    signal = to_uniform(np.round(t, 3), x, "V")
    assert missing > 20
    assert len(signal) == 3000
    assert error_db(signal, 0, 40) < -40


def test_the_asked_rate_is_given():
    t, _ = stamps(3000, 1013.7, jitter=0.05)
    signal = to_uniform(t, np.sin(2 * np.pi * 100 * t), "V", rate=500)
    assert signal.rate == 500
    assert error_db(signal, t[0], 100, margin=50) < -60


def test_the_same_stamp_twice_counts_as_one_instant():
    t, _ = stamps(2000, 1000, jitter=0.05)
    x = np.sin(2 * np.pi * 100 * t)
    doubled = to_uniform(np.insert(t, 700, t[700]), np.insert(x, 700, x[700]), "V")
    timing = estimate_timing(np.insert(t, 700, t[700]))
    assert timing.repeated == 1
    assert timing.dropped == 0
    assert error_db(doubled, t[0], 100) < -60


def test_positions_are_resampled_like_times():
    position, _ = stamps(1000, 20, jitter=0.1)
    signal = to_uniform(position, np.sin(2 * np.pi * position), "1", domain="displacement")
    assert signal.domain == "displacement"
    assert signal.rate == pytest.approx(20, rel=1e-3)


def test_a_late_burst_does_not_move_the_rate():
    t = np.arange(2000) / 1000
    t[500:504] = t[504] - np.array([4, 3, 2, 1]) * 1e-5
    timing = estimate_timing(t)
    assert timing.rate == pytest.approx(1000, rel=1e-5)
    assert timing.dropped == 0


@pytest.mark.parametrize(
    ("times", "line"),
    [
        ([0, 1, 0.5], "time goes backwards at sample 2: 0.5 after 1"),
        ([0, np.nan, 1], "must be finite, got nan at sample 1"),
        ([0.0], "at least two time stamps"),
        ([[0.0, 1.0]], "at least two time stamps"),
        ([2.0, 2.0, 2.0], "time stands still"),
        (np.floor(np.arange(100) / 6), "repeat the one before"),
        ([0, 1, 2, 3, 1e6], "mostly gaps"),
    ],
)
def test_what_is_no_time_is_refused_in_one_line(times, line):
    with pytest.raises(DataError, match=line):
        to_uniform(times, np.zeros(np.shape(times)[-1]), "V")


def test_as_many_samples_as_times_are_needed():
    with pytest.raises(ParameterError, match=r"\(axis, 3\)"):
        to_uniform([0, 1, 2], np.zeros((2, 4)), "V")


@pytest.mark.parametrize(("rate", "digits"), [(1000.0, 3), (1000.0, 6), (833.3, 6), (44_100.0, 7)])
def test_even_stamps_are_timed_in_blocks_as_they_are_at_once(rate, digits, monkeypatch):
    monkeypatch.setattr(timing, "_BLOCK", 100)
    stamps = np.round(5 + np.arange(1234) / rate, digits)
    blocks, (whole, _) = timing._even_timing(stamps), timing._clocked(stamps)
    assert whole.even
    for name, value in vars(whole).items():
        assert getattr(blocks, name) == pytest.approx(value, rel=1e-9, abs=1e-12)


@pytest.mark.parametrize("wrong", [np.nan, np.inf, 0.498, 0.499, 0.502, 0.51])
def test_a_single_stamp_that_is_off_is_noticed_in_any_block(wrong, monkeypatch):
    monkeypatch.setattr(timing, "_BLOCK", 100)
    stamps = np.arange(1234) / 1000
    assert timing.steps_alike(stamps)
    stamps[500] = wrong
    assert not timing.steps_alike(stamps)
