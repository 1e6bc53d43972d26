"""Tones found in recordings."""

import numpy as np
import pytest
from scipy.signal import butter, sosfilt
from tests.signal.ribs import BAND, RATE, ribs

from tactogram.signal.tone_fit import split_tones


def centred(signals):
    return [s.samples - s.samples.mean(1, keepdims=True, dtype=np.float64) for s in signals]


def test_lines_are_found_with_their_amplitudes_and_what_is_left_is_the_noise():
    recordings = centred([ribs(seed) for seed in range(3)])
    [tones, *others], rest = split_tones(recordings, RATE, band=BAND)
    assert len(others) == 2
    assert tones.frequency[1] / tones.frequency[0] == pytest.approx(2, abs=1e-3)
    assert tones.frequency[0] == pytest.approx(60, rel=0.05)
    size = np.hypot(*tones.amplitude) * np.exp(tones.unsteadiness[3] ** 2)
    np.testing.assert_allclose(size, np.outer([1, 0.5], [1, 0.5]), rtol=0.1)
    assert np.concatenate(rest, 1).std(1) == pytest.approx([0.2, 0.2], rel=0.1)


def test_harmonics_keep_their_phase_and_axes_their_signs():
    [tones], _ = split_tones(centred([ribs(1)]), RATE, band=BAND)
    complex_ = tones.amplitude[0] + 1j * tones.amplitude[1]
    found = np.angle(complex_[0, 1] / complex_[0, 0] ** 2)
    assert np.angle(np.exp(1j * (found - 1))) == pytest.approx(0, abs=0.15)
    assert (complex_[1, 0] / complex_[0, 0]).real == pytest.approx(-0.5, rel=0.1)


def test_unsteadiness_is_that_of_the_strokes():
    signals = [ribs(seed, hz=hz) for seed, hz in enumerate((55.0, 58.0, 60.0, 62.0, 65.0, 60.5))]
    [tones, *others], _ = split_tones(centred(signals), RATE, band=BAND)
    for each in others:
        np.testing.assert_allclose(each.power, tones.power)
    between, speed, kept, gain, _ = tones.unsteadiness
    assert between == pytest.approx(0.05, abs=0.03)
    assert speed == pytest.approx(0.05, rel=0.2)
    assert 0.9 < kept < 1
    assert gain < 0.1


@pytest.mark.parametrize("band", [None, (55.0, 65.0), (200.0, 300.0)], ids=["white", "narrow", "broad"])
def test_noise_has_no_tones_however_narrow(band):
    noise = np.random.default_rng(0).standard_normal((5, 2, 5000))
    if band:
        noise = sosfilt(butter(1, band, "bandpass", fs=RATE, output="sos"), noise)[..., 1000:]
    tones, rest = split_tones(list(noise), RATE, band=BAND)
    assert tones == []
    assert all(np.array_equal(a, b) for a, b in zip(rest, noise, strict=True))


def test_silence_has_no_tones():
    tones, _ = split_tones([np.zeros((1, 2000))], RATE, band=BAND)
    assert tones == []


def test_tones_of_a_minority_of_recordings_are_left_in_the_noise():
    noise = np.random.default_rng(0).standard_normal((2, 2, 4000))
    recordings = [*centred([ribs(0)]), *noise]
    tones, rest = split_tones(recordings, RATE, band=BAND)
    assert tones == []
    assert np.array_equal(rest[0], recordings[0])
