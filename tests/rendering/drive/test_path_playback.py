import numpy as np
import pytest
from hypothesis import given, settings, strategies as st

from tactogram.errors import ParameterError
from tactogram.rendering.drive.path_playback import PathPlayback
from tactogram.signal import Signal
from tactogram.signal.displacement import played
from tactogram.signal.resampling import resample


def ridges(period_mm, *, rate=20.0, length_mm=200):
    k = np.arange(int(length_mm * rate)) / rate
    return Signal(np.sin(2 * np.pi * k / period_mm), rate, "1", domain="displacement")


def met_at(texture, speed_mm_s, seconds, *, rate=8000, **options):
    """Return what a finger meets at a constant speed, in blocks of 32 samples."""
    playback = PathPlayback(texture, rate=rate, **options)
    places = speed_mm_s * np.arange(round(rate * seconds)) / rate
    return np.concatenate(
        [playback.process(part, len(part)) for part in np.split(places, range(32, len(places), 32))]
    )


def level(x, frequency, rate):
    x = x.astype(float) * np.hanning(len(x)) * 2
    return 2 * abs(np.mean(x * np.exp(-2j * np.pi * frequency * np.arange(len(x)) / rate)))


@pytest.mark.parametrize("speed", [20, 60, 150])
def test_pitch_follows_speed_and_level_stays(speed):
    x = met_at(ridges(1.0), speed, 1)[400:-400]
    assert level(x, speed, 8000) == pytest.approx(1, abs=0.01)


def test_it_is_what_the_whole_signal_gives():
    noise = Signal(np.random.default_rng(0).standard_normal(400), 2, "1", domain="displacement")
    texture = resample(noise, 4)
    ours = met_at(texture, 100, 1.5, hysteresis_mm=0)
    theirs = played(texture, 100.0, 8000)
    np.testing.assert_allclose(ours[400:11_000], theirs.samples[0, 400:11_000], atol=0.02)


@settings(max_examples=8)
@given(speed=st.floats(50, 900), seed=st.integers(0, 99))
def test_nothing_comes_out_above_the_band(speed, seed):
    texture = Signal(np.random.default_rng(seed).standard_normal(4000), 20, "1", domain="displacement")
    x = met_at(texture, speed, 0.3, highest_hz=500)[800:]
    power = np.abs(np.fft.rfft((x - x.mean()) * np.hanning(len(x)))) ** 2
    above = np.fft.rfftfreq(len(x), 1 / 8000) > 540
    assert power[above].sum() <= 2e-4 * power.sum() + 1e-9


def test_two_fifths_of_the_band_are_kept_at_any_speed():
    for speed in (300, 430, 700):
        x = met_at(ridges(speed / 200), speed, 0.25, highest_hz=500)[800:]
        assert level(x, 200, 8000) == pytest.approx(1, abs=0.05), speed


def test_blocks_join_without_a_step():
    playback = PathPlayback(ridges(2.0), rate=8000)
    x = np.concatenate([playback.process([5 + k * 0.5], 40) for k in range(60)])
    slope = 2 * np.pi / 2.0 * 0.5 / 40
    assert np.abs(np.diff(x)).max() < 1.05 * slope


def test_a_change_of_speed_is_no_step():
    playback = PathPlayback(ridges(2.0), rate=8000, highest_hz=300)
    places = np.cumsum(np.concatenate([np.full(30, 0.5), np.full(30, 4.0)]))
    x = np.concatenate([playback.process([place], 40) for place in places])
    assert np.abs(np.diff(x)).max() < 1.1 * 2 * np.pi / 2.0 * 4.0 / 40


def test_a_trembling_finger_plays_nothing():
    playback = PathPlayback(ridges(0.4), rate=8000, hysteresis_mm=0.1)
    playback.process([5.0], 40)
    tremor = 5.0 + 0.045 * np.sin(np.arange(100))
    assert np.ptp(np.concatenate([playback.process([place], 40) for place in tremor])) < 1e-9
    assert np.ptp(np.concatenate([playback.process([5 + 0.2 * np.sin(k)], 40) for k in range(20)])) > 0.5


def test_a_lift_holds_and_a_landing_is_at_once():
    playback = PathPlayback(ridges(2.0), rate=8000, hysteresis_mm=0)
    playback.process([0.5], 40)
    held = playback.process([9.0], 40, contact=False)
    np.testing.assert_allclose(held, 1, atol=1e-3)
    assert playback.place_mm == 0.5
    np.testing.assert_allclose(playback.process([1.5], 40), -1, atol=1e-3)


def test_no_news_is_no_movement():
    playback = PathPlayback(ridges(2.0), rate=8000, hysteresis_mm=0)
    playback.process([0.5], 40)
    np.testing.assert_allclose(playback.process(None, 40), 1, atol=1e-3)
    np.testing.assert_allclose(playback.process([np.nan, np.inf], 40), 1, atol=1e-3)


def test_beyond_the_end_the_ground_comes_back():
    ramp = Signal(np.arange(101) / 10, 10, "1", domain="displacement")
    mirrored = PathPlayback(ramp, rate=8000, hysteresis_mm=0).process([9.0, 11.0], 40)
    assert mirrored[-1] == pytest.approx(9, abs=0.1)


def test_what_cannot_be_played_is_refused():
    with pytest.raises(ParameterError, match="one axis over displacement"):
        PathPlayback(Signal(np.ones(10), 1000, "1"), rate=8000)
    with pytest.raises(ParameterError, match="at most 3600"):
        PathPlayback(ridges(1), rate=8000, highest_hz=4000)
