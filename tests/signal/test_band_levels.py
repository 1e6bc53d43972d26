import numpy as np
import pytest
from scipy.signal import hilbert, lfilter, welch

from tactogram.signal import band_levels
from tactogram.signal.band_levels import BandLevels, band_filters

RATE = 1000.0
ONE = np.array([1.0])


def noise(seed, axes=1, length=4000):
    return np.random.default_rng(seed).standard_normal((axes, length))


def measured(recorded, generated):
    """Levels of materials, each given as its recorded and its generated signals."""
    levels = BandLevels(RATE)
    levels.recorded = np.array([levels.quantiles(signals) for signals in recorded])
    levels.generated = np.array([levels.quantiles(signals) for signals in generated])
    return levels


def test_filters_add_up_to_what_is_felt_and_pass_nothing_constant():
    taps = band_filters(RATE, 250)
    response = np.fft.fft(taps, 4096)
    frequency = np.fft.fftfreq(4096, 1 / RATE)
    felt = (frequency > 25) & (frequency < 490)
    np.testing.assert_allclose(np.abs(response.sum(0)[felt]), 2, atol=0.02)
    assert np.abs(response[:, (frequency < -8) & (frequency > -490)]).max() < 0.02
    np.testing.assert_allclose(response[:, 0], 0, atol=1e-12)
    assert len(taps) == 10  # 16 to 362 Hz
    assert len(band_filters(20.0, 5)) == 0


def test_what_is_right_already_stays():
    signals = [noise(seed) for seed in range(3)]
    levels = measured([signals], [signals])
    assert levels.correction_db() == 0
    np.testing.assert_allclose(levels.apply(signals[0], ONE), signals[0][:, 250:-250])


def test_level_and_spectrum_become_those_of_recordings():
    recorded = [9.81 + 3 * lfilter([1], [1, -0.8], noise(seed)) for seed in range(6)]
    generated = [9.81 + noise(10 + seed) for seed in range(6)]
    levels = measured([recorded], [generated])
    x = np.concatenate([levels.apply(9.81 + noise(20 + seed), ONE)[0] for seed in range(6)])
    assert x.mean() == pytest.approx(9.81, abs=0.1)
    f, found = welch(x, RATE, nperseg=256)
    wanted = welch(np.concatenate(recorded, 1)[0], RATE, nperseg=256)[1]
    felt = f > 20
    off = 10 * np.log10(found[felt] / wanted[felt])
    assert np.sqrt(np.mean(off**2)) < 1.0
    assert levels.correction_db() > 6


def test_a_tone_becomes_more_even():
    time = np.arange(4000) / RATE
    tones = [np.sin(2 * np.pi * (75 * time + seed / 7))[None] for seed in range(4)]
    faint = [0.01 * noise(seed) for seed in range(4)]
    narrow = [
        3 * lfilter([0.05], [1, -2 * 0.97 * np.cos(2 * np.pi * 0.075), 0.97**2], x)
        for x in map(noise, range(10, 15))
    ]
    levels = measured([[t + n for t, n in zip(tones, faint, strict=True)]], [narrow[:4]])

    def unevenness(x):
        envelope = np.abs(hilbert(x[0]))[200:-200]
        return envelope.std() / envelope.mean()

    mapped = levels.apply(narrow[4], ONE)
    assert unevenness(mapped) < 0.75 * unevenness(narrow[4])
    assert mapped.std() == pytest.approx(np.sqrt(0.5), rel=0.2)


def test_how_levels_differ_between_recordings_is_not_spread_within_a_signal():
    signals = [noise(seed) for seed in range(8)]
    loud = [x * 4.0 ** (-1) ** place for place, x in enumerate(signals)]
    levels = measured([loud], [signals])
    moved = levels.recorded - levels.generated
    np.testing.assert_allclose(moved, 0, atol=1e-9)


def test_between_materials_it_is_corrected_half_as_much_in_db():
    signals = [noise(seed) for seed in range(4)]
    levels = measured([[4 * x for x in signals], signals], [signals, signals])
    for weights, gain in (((1, 0), 4), ((3, 3), 2), ((0, 1), 1)):
        x = levels.apply(noise(9), np.array(weights, float))
        _, found = welch(x[0], RATE, nperseg=256)
        _, before = welch(noise(9)[0, 250:-250], RATE, nperseg=256)
        np.testing.assert_allclose(np.sqrt(found[10:100] / before[10:100]), gain, rtol=0.02)


def test_portions_and_lengths_change_nothing(monkeypatch):
    levels = measured([[2 * noise(seed, 2) ** 3 for seed in range(3)]], [[noise(5, 2), noise(6, 2)]])
    x = noise(7, 2)
    whole = levels.apply(x, ONE)
    monkeypatch.setattr(band_levels, "PORTION", 700)
    np.testing.assert_allclose(levels.apply(x, ONE), whole, atol=1e-9)
    np.testing.assert_allclose(levels.apply(x[:, :1500], ONE), whole[:, :1000], atol=1e-9)


def test_silence_stays_silent():
    silent = np.zeros((1, 2000))
    levels = measured([[silent], [noise(0)]], [[noise(1)], [silent]])
    f, power = welch(levels.apply(noise(2), np.array([1.0, 0]))[0], RATE, nperseg=256)
    assert 10 * np.log10(power[(f > 30) & (f < 450)] / (2 / RATE)).max() < -30  # of the noise's
    np.testing.assert_array_equal(levels.apply(silent, np.array([0, 1.0])), 0)
