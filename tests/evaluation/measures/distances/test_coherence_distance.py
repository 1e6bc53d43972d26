"""Coherence distance."""

import numpy as np
import pytest
from scipy import signal as dsp

from tactogram.errors import ParameterError
from tactogram.evaluation.measures import coherence, coherence_distance
from tactogram.signal import Signal


def pair(seed, share, n=60_000):
    """Return two axes of white noise, ``share`` of the power of Y being that of X."""
    random = np.random.default_rng(seed)
    x, noise = random.standard_normal((2, n))
    gain = np.sqrt(share / (1 - share))
    return Signal(np.stack([x, gain * x + noise]), 1000, "m/s^2", ("x", "y"))


@pytest.mark.parametrize("share", [0.1, 0.5, 0.9])
def test_coherence_is_the_share_of_power_in_common(share):
    frequency, matrix = coherence([pair(0, share)])
    kept = (frequency > 10) & (frequency < 490)
    assert matrix[0, 1, kept].mean() == pytest.approx(share, abs=0.02)
    np.testing.assert_allclose(matrix[0, 0, kept], 1, atol=1e-4)
    np.testing.assert_allclose(matrix[0, 1], matrix[1, 0])


def test_it_is_scipys_where_there_is_one_signal():
    one = pair(0, 0.5, 4000)
    frequency, ours = coherence([one])
    f, theirs = dsp.coherence(*one.samples.astype(float), 1000, nperseg=250)
    np.testing.assert_allclose(frequency, f)
    np.testing.assert_allclose(ours[0, 1, 2:], theirs[2:], atol=1e-4)


def test_the_distance_is_the_difference_of_coherences():
    assert coherence_distance([pair(0, 0.2)], [pair(1, 0.7)]) == pytest.approx(0.5, abs=0.04)


def test_level_sign_and_delay_between_axes_do_not_count():
    one = pair(0, 0.6)
    x, y = one.samples
    changed = one.with_samples(np.stack([3 * x, -0.1 * np.roll(y, 2)]))
    assert coherence_distance([one], [changed]) < 0.02


def test_a_strong_signal_counts_no_more_than_a_weak_one():
    coherent, apart = pair(0, 0.9), pair(1, 0.1)
    _, both = coherence([coherent, apart])
    _, mixed = coherence([coherent, apart.with_samples(1000 * apart.samples)])
    np.testing.assert_allclose(mixed, both, atol=1e-4)


def test_one_axis_has_none(texture):
    assert coherence_distance([texture(0, axes=1)], [texture(1, axes=1)]) is None


def test_silent_frequencies_are_not_coherent():
    noise = np.random.default_rng(0).standard_normal(8000)
    low = np.fft.irfft(np.fft.rfft(noise) * (np.fft.rfftfreq(8000, 1e-3) < 100), n=8000)
    one = Signal(np.stack([low, low]), 1000, "1", ("x", "y"))
    frequency, matrix = coherence([one])
    assert matrix[0, 1, (frequency > 15) & (frequency < 90)].min() > 0.99
    assert matrix[0, 1, frequency > 150].max() < 1e-3
    silent = one.with_samples(np.zeros((2, 8000)))
    assert coherence_distance([silent], [silent]) == 0


def test_what_does_not_fit_is_refused():
    with pytest.raises(ParameterError, match="at least 0.25 s"):
        coherence_distance([pair(0, 0.5, 100)], [pair(0, 0.5, 100)])
    with pytest.raises(ParameterError, match="band must hold a frequency below 500 Hz"):
        coherence_distance([pair(0, 0.5, 1000)], [pair(0, 0.5, 1000)], band=(800, 900))
