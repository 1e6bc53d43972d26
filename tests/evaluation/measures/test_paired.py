from math import erf

import numpy as np
import pytest
from hypothesis import given, settings, strategies as st

from tactogram.errors import ParameterError
from tactogram.evaluation.measures import align, signal_to_noise_ratio_db, spqi, st_sim
from tactogram.signal import Signal
from tactogram.signal.resampling import resample


def sine(rate=8000.0, seconds=4.0, frequency=120.0, gain=1.0):
    t = np.arange(round(seconds * rate)) / rate
    return Signal(gain * np.sin(2 * np.pi * frequency * t), rate, "1")


def with_noise(signal, level, seed=0):
    noise = np.random.default_rng(seed).standard_normal(signal.samples.shape)
    return signal.with_samples(signal.samples + level * noise)


@given(st.integers(-40, 40), st.integers(0, 100))
@settings(max_examples=25)
def test_a_delay_is_found(delay, seed):
    whole = np.random.default_rng(seed).standard_normal((2, 1000))
    one = Signal(whole[:, 50 + delay : 900 + delay], 1000, "1", ("x", "y"))
    other = Signal(whole[:, 50:900], 1000, "1", ("x", "y"))
    a, b = align(one, other)
    np.testing.assert_array_equal(a.samples, b.samples)
    assert len(a) == 850 - abs(delay)


def test_an_inverted_signal_is_not_aligned_to_its_mirror_image():
    noise = Signal(np.random.default_rng(0).standard_normal(1000), 1000, "1")
    a, b = align(noise.with_samples(-noise.samples), noise, within_s=0.0)
    np.testing.assert_array_equal(a.samples, -b.samples)


def test_a_delay_beyond_the_signal_is_refused():
    with pytest.raises(ParameterError, match="below the 4 s of the signals, got 5"):
        align(sine(1000), sine(1000), within_s=5)
    with pytest.raises(ParameterError, match="within_s must be >= 0"):
        align(sine(1000), sine(1000), within_s=-0.1)


def test_signal_to_noise_ratio_of_a_known_error():
    one = sine()
    assert signal_to_noise_ratio_db(one.with_samples(1.1 * one.samples), one) == pytest.approx(20, abs=1e-4)
    assert signal_to_noise_ratio_db(one, one) == np.inf
    silent = one.with_samples(np.zeros(one.samples.shape))
    assert signal_to_noise_ratio_db(silent, one) == pytest.approx(0)
    assert signal_to_noise_ratio_db(one, silent) == -np.inf


@pytest.mark.parametrize(("noise", "expected"), [(0.01, 1.0), (0.1, 0.97), (0.5, 0.21), (1.0, 0.01)])
def test_spqi_of_a_sine_in_noise_is_that_of_the_public_package(noise, expected):
    # vibromaf 0.0.8 on a unit sine of 120 Hz at 8 kHz, two digits; which draw of noise is not known.
    assert spqi(with_noise(sine(), noise), sine()) == pytest.approx(expected, abs=0.04)


def published(distorted, reference):
    """Return ST-SIM and SPQI by the published steps in plain loops: 8 kHz, blocks of 512."""
    grid = np.arange(512) * 8000 / 1024
    curve = 62 / np.log10(6 / 11) ** 2 * np.log10(grid / 550 + 6 / 11) ** 2 - 77
    threshold = np.minimum(curve, 0)
    n = np.arange(512)
    dct = np.sqrt(2 / 512) * np.cos(np.pi / 512 * (n + 0.5) * n[:, None])
    dct[0] /= np.sqrt(2)
    phi = np.vectorize(lambda z: (1 + erf(z / np.sqrt(2))) / 2)
    time, support, quality = [], [], []
    for start in range(0, len(reference) - 511, 512):
        x, y = (z[start : start + 512].astype(float) for z in (distorted, reference))
        zx, zy = ((z - z.mean()) / z.std() for z in (x, y))
        time.append((zx * zy).sum() / (zy**2).sum())
        lx, ly = (20 * np.log10(np.abs(dct @ z)) - threshold for z in (x, y))
        support.append((phi(lx / 12) * phi(ly / 12)).sum() / (phi(ly / 12) ** 2).sum())
        error = np.abs(10 ** (lx / 10) - 10 ** (ly / 10)).sum() / (10 ** (ly / 10)).sum()
        quality.append((1 - np.tanh(0.3 * 10 * np.log10(error) + 2)) / 2)
    return np.mean(time) ** (2 / 3) * np.mean(support) ** (1 / 3), np.mean(quality)


@pytest.mark.parametrize("noise", [0.02, 0.3])
def test_both_are_the_published_steps_at_8_khz(noise):
    reference = with_noise(sine(seconds=0.5, gain=0.4), 0.01)
    distorted = with_noise(reference, noise, seed=1)
    similarity, quality = published(distorted.samples[0], reference.samples[0])
    assert st_sim(distorted, reference) == pytest.approx(similarity, rel=1e-4)
    assert spqi(distorted, reference) == pytest.approx(quality, rel=1e-4)


@pytest.mark.parametrize("rate", [1000.0, 2000.0, 2500.0])
def test_the_rate_does_not_change_the_score(rate):
    # The same vibration below 400 Hz, recorded at 8 kHz or at a lower rate.
    noise = np.fft.rfft(np.random.default_rng(0).standard_normal((2, 32_000)))
    noise *= np.fft.rfftfreq(32_000, 1 / 8000) < 400
    x, error = np.fft.irfft(noise, n=32_000)
    reference, distorted = (Signal(z, 8000, "1") for z in (x, x + 0.25 * error))
    low = [resample(s, rate).cut(100, -100) for s in (distorted, reference)]
    high = [
        resample(s, 8000).cut(int(100 * 8000 / rate), -int(100 * 8000 / rate)) for s in (distorted, reference)
    ]
    assert spqi(*low) == pytest.approx(spqi(*high), abs=0.02)
    assert st_sim(*low) == pytest.approx(st_sim(*high), abs=0.02)


@pytest.mark.parametrize("measure", [st_sim, spqi])
def test_a_copy_scores_1_and_silence_too(measure):
    silent = Signal(np.zeros((2, 800)), 1000, "1", ("x", "y"))
    for signal in (sine(), sine(gain=1e-6), silent):
        score = measure(signal, signal)
        assert isinstance(score, float)
        assert score == pytest.approx(1)


def test_an_inverted_signal_scores_0_and_nothing_is_complex():
    one = with_noise(sine(), 0.1)
    score = st_sim(one.with_samples(-one.samples), one)
    assert isinstance(score, float)
    assert score == 0
    assert spqi(one.with_samples(-one.samples), one) == pytest.approx(1)  # blind to sign


@given(st.integers(0, 50), st.floats(0.001, 10))
@settings(max_examples=20)
def test_scores_stay_in_range(seed, level):
    one = with_noise(sine(1000, 0.5), 0.1, seed)
    other = with_noise(one, level, seed + 1)
    assert 0 <= spqi(other, one) <= 1
    assert 0 <= st_sim(other, one) < 2


def test_full_scale_moves_the_threshold():
    one = with_noise(sine(), 0.1)
    noisy = with_noise(one, 0.2, 1)
    scaled, noisy_scaled = (s.with_samples(9.81 * s.samples) for s in (one, noisy))
    for measure in (st_sim, spqi):
        assert measure(noisy_scaled, scaled, full_scale=9.81) == pytest.approx(measure(noisy, one), rel=1e-4)


def test_a_new_draw_of_the_same_texture_scores_like_another_texture(texture):
    # Why these are for codecs and inversion only.
    one, same, another = texture(0), texture(1), texture(2, centre=60.0)
    assert st_sim(*align(same, one)) < 0.5
    assert spqi(*align(same, one)) < 0.1
    assert abs(spqi(*align(same, one)) - spqi(*align(another, one))) < 0.1


def test_signals_that_are_no_pair_are_refused():
    with pytest.raises(ParameterError, match="equally long, got 8000 and 4000 samples; align them"):
        spqi(sine(1000, 8), sine(1000, 4))
    with pytest.raises(ParameterError, match="at least 0.064 s"):
        st_sim(sine(1000, 0.05), sine(1000, 0.05))
    with pytest.raises(ParameterError, match="full_scale must be > 0"):
        spqi(sine(1000), sine(1000), full_scale=0)
    with pytest.raises(ParameterError, match="eta must be between 0 and 1"):
        st_sim(sine(1000), sine(1000), eta=1)
    with pytest.raises(ParameterError, match="got 2 kinds"):
        signal_to_noise_ratio_db(sine(1000), sine(2000))
