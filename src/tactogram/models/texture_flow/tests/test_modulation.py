"""Random changes of strength: what they change, what they keep, and which recordings are given them."""

import numpy as np
import pytest
from scipy.signal import butter, sosfilt

from tactogram.model import Example, ItemRatings
from tactogram.models.texture_flow.modulation import Modulation, modulated
from tactogram.signal import Signal

RATE = 2000.0
NOISE = Signal(np.random.default_rng(0).normal(5.0, 1.0, (1, 40_000)), RATE, "m/s^2", ("z",))
DEEP = Modulation(200.0, 1.0, (1.0, 10.0), (1.0, 0.5), 0.0, 2.0, 0.0)


def power(signal, band):
    x = signal.samples[0] - signal.samples[0].mean()
    return float(np.mean(sosfilt(butter(4, band, "bandpass", fs=RATE, output="sos"), x) ** 2))


def level(signal):
    """Logarithm of the rms in each 20 ms."""
    x = signal.samples[0] - signal.samples[0].mean()
    return np.log(x.reshape(-1, 40).std(1))


def test_strength_changes_and_mean_and_power_of_the_bands_stay():
    signal = DEEP.apply(NOISE, np.random.default_rng(1))
    assert signal.samples.mean() == pytest.approx(5.0, abs=0.02)
    for band in ((20, 100), (400, 900)):
        assert power(signal, band) == pytest.approx(power(NOISE, band), rel=0.15)
    assert level(NOISE).std() < 0.15
    assert 0.8 < level(signal).std() < 1.3


def test_each_drawing_and_each_recording_differs():
    rng = np.random.default_rng(0)
    drawn = [Modulation.drawn(rng) for _ in range(20)]
    assert len(set(drawn)) == 20
    assert all(60 <= each.crossover_hz <= 500 and 0 <= each.together <= 1 for each in drawn)
    one, other = (level(DEEP.apply(NOISE, np.random.default_rng(seed))) for seed in (1, 2))
    assert abs(np.corrcoef(one, other)[0, 1]) < 0.4


def test_skewness_makes_pauses_or_bursts():
    def skewness(share):
        x = level(DEEP._replace(skewness=share).apply(NOISE, np.random.default_rng(3)))
        return float(np.mean(((x - x.mean()) / x.std()) ** 3))

    assert skewness(-0.5) < skewness(0.0) - 0.5 < skewness(0.25) - 0.5


def test_a_hand_that_strokes_back_and_forth_pauses_when_it_turns():
    strokes = DEEP._replace(depths=(0.0, 0.0), power=1.0)
    x = level(strokes.apply(NOISE, np.random.default_rng(4)))
    spectrum = np.abs(np.fft.rfft(x - x.mean()))
    frequencies = np.fft.rfftfreq(len(x), 0.02)
    assert frequencies[spectrum.argmax()] == pytest.approx(2.0, abs=0.05)
    assert np.quantile(x, 0.02) < np.median(x) - 1.5


def test_a_share_of_the_surfaces_is_modulated_with_all_their_strokes_and_no_words():
    rated = ItemRatings(("soft",), ("a",), np.array([[0.5]]))
    examples = [
        Example(f"m{n}-{k}", NOISE.with_samples(NOISE.samples[:, :4000]), f"m{n}", rated=rated)
        for n in range(40)
        for k in range(2)
    ]
    results = modulated(examples, 0.5, seed=0)
    changed = {e.material for e, was in zip(results, examples, strict=True) if e.signal is not was.signal}
    assert 10 < len(changed) < 30
    for example in results:
        assert (example.rated is None) == (example.material in changed)
    for one, other in zip(results, modulated(examples, 0.5, seed=0), strict=True):
        np.testing.assert_array_equal(one.signal.samples, other.signal.samples)
    assert modulated(examples, 0.0, seed=0) == examples
