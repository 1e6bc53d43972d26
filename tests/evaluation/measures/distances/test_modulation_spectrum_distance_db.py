"""Modulation spectrum distance."""

import numpy as np
from tests.evaluation.measures.test_spectra import modulated

from tactogram.evaluation.measures import modulation_spectrum_distance
from tactogram.signal import Signal


def test_an_absent_carrier_band_does_not_count():
    one = modulated(0.4, carrier=100.0)
    random = np.random.default_rng(0)
    hiss = one.with_samples(one.samples + 1e-5 * random.standard_normal(one.samples.shape))
    assert modulation_spectrum_distance([one], [hiss]) < 0.1


def test_bursts_in_one_band_are_detected(texture, even):
    # Two bands fluctuate in opposite phase: the whole envelope is nearly even, each band's is not.
    t = np.arange(8000) / 2000
    low, high = np.sin(2 * np.pi * 60 * t), np.sin(2 * np.pi * 400 * t)
    swing = 0.5 * np.sin(2 * np.pi * 6 * t)
    still = Signal(low + high, 2000, "1")
    swinging = Signal(low * (1 + swing) + high * (1 - swing), 2000, "1")
    assert modulation_spectrum_distance([still], [swinging]) > 5
