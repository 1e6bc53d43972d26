"""What a signal is described by: levels, whatever the rate, the length and the place of a beginning."""

import numpy as np
import pytest

from tactogram.errors import ParameterError
from tactogram.models.rater.signal_features import edges, signal_features
from tactogram.signal import Signal
from tactogram.signal.resampling import resample

RATE = 2000.0


def noise(seconds=2.0, *, seed=0, rate=RATE, level=1.0):
    samples = np.random.default_rng(seed).standard_normal((1, round(seconds * rate)))
    return Signal(level * samples, rate, "1")


def tone(frequency, *, seconds=2.0, amplitude=1.0, rate=RATE):
    time = np.arange(round(seconds * rate)) / rate
    return Signal(amplitude * np.sin(2 * np.pi * frequency * time), rate, "1")


def bands(signal):
    return signal_features(signal)[: len(edges(signal.rate)) - 1]


def test_a_tone_has_its_level_in_its_own_band():
    levels, bounds = bands(tone(90.0)), edges(RATE)
    own = int(np.searchsorted(bounds, 90.0)) - 1
    assert levels.argmax() == own
    assert levels[own] == pytest.approx(10 * np.log10(0.5), abs=0.3)
    assert np.delete(levels, [own - 1, own, own + 1]).max() < levels[own] - 20


def test_ten_times_the_amplitude_is_20_db_in_every_band_and_nothing_else():
    difference = signal_features(noise(level=10.0)) - signal_features(noise())
    count = len(edges(RATE))  # bands, and the whole
    np.testing.assert_allclose(difference[:count], 20, atol=1e-3)
    changed = np.flatnonzero(np.abs(difference[count:]) > 1e-3)
    assert len(changed) == 1  # the peak's level
    assert difference[count + changed[0]] == pytest.approx(20)


def test_levels_hold_while_a_signal_lasts_longer_or_has_another_rate():
    np.testing.assert_allclose(bands(noise(20.0)), bands(noise(20.0).cut(0, 20000)), atol=1.5)
    slow = noise(10.0, rate=4000.0)
    below = slice(None, -1)  # the last band is cut by the resampling filter
    np.testing.assert_allclose(bands(slow)[below], bands(resample(slow, 2000.0))[below], atol=0.2)


def test_silence_between_pulses_does_not_lower_the_level():
    pulse = tone(100.0, seconds=0.5)
    apart = Signal(np.concatenate([pulse.samples, np.zeros((1, 3000), np.float32)], axis=1), RATE, "1")
    assert bands(apart).max() == pytest.approx(bands(pulse).max(), abs=1.0)


def test_amplitude_modulation_is_seen_at_its_frequency():
    time = np.arange(8000) / RATE
    still = tone(150.0, seconds=4.0)
    moved = still.with_samples(still.samples * (1 + 0.8 * np.sin(2 * np.pi * 4 * time)))
    start = len(edges(RATE)) - 1 + 1 + 4 + 3
    depths = signal_features(moved)[start : start + 6]
    assert depths.argmax() == 2  # the octave about 4 Hz
    assert depths[2] == pytest.approx(10 * np.log10(0.8**2 / 2), abs=1.0)
    assert signal_features(still)[start : start + 6].max() < -25


def test_axes_are_joined_by_their_power():
    one, other = noise(seed=1), noise(seed=2)
    both = Signal(np.concatenate([one.samples, other.samples]), RATE, "1", ("x", "y"))
    power = 10 ** (bands(one) / 10) + 10 ** (bands(other) / 10)
    np.testing.assert_allclose(bands(both), 10 * np.log10(power), atol=0.1)


@pytest.mark.parametrize("seconds", [0.02, 0.1, 1.0])
def test_short_and_silent_signals_have_finite_features(seconds):
    assert np.isfinite(signal_features(noise(seconds))).all()
    assert np.isfinite(signal_features(noise(seconds, level=0.0))).all()


def test_what_has_no_felt_spectrum_is_refused():
    with pytest.raises(ParameterError, match="at least 80 Hz"):
        signal_features(noise(rate=50.0))
    with pytest.raises(ParameterError, match="over displacement"):
        signal_features(Signal(np.ones(100), 100.0, "1", domain="displacement"))
