"""Weighted log spectral distance."""

import numpy as np
import pytest
from tests.evaluation.measures.distances.test_log_spectral_distance_db import texture

from tactogram.evaluation.measures import (
    weighted_log_spectral_distance,
)
from tactogram.evaluation.measures.distances.weighted_log_spectral_distance_db import _felt_levels
from tactogram.evaluation.measures.spectra import felt_edges
from tactogram.signal import Signal
from tactogram.signal.perception import detection_threshold, sensation_level_db


def sine(frequency, amplitude, unit="m/s^2", rate=2000.0):
    t = np.arange(round(2 * rate)) / rate
    return Signal(amplitude * np.sin(2 * np.pi * frequency * t), rate, unit)


@pytest.mark.parametrize("frequency", [31.0, 60.0, 250.0, 600.0])
@pytest.mark.parametrize("unit", ["m", "m/s", "m/s^2"])
def test_a_sine_at_threshold_is_at_0_db(frequency, unit):
    signal = sine(frequency, float(detection_threshold(frequency, unit)), unit)
    levels = 10 ** (_felt_levels([signal], felt_edges(signal.rate)) / 10)
    # Neighbouring bins have other thresholds, and what bias the logarithm has is taken from noise.
    assert 10 * np.log10(levels.sum()) == pytest.approx(0, abs=0.7)
    assert 10 * np.log10(levels.sum()) == pytest.approx(sensation_level_db(signal), abs=0.7)


def test_imperceptible_bands_do_not_count():
    strong = sine(100, 1.0).samples
    faint = sine(400, 0.05 * float(detection_threshold(400.0, "m/s^2"))).samples
    one, other = (Signal(x, 2000, "m/s^2") for x in (strong, strong + faint))
    assert weighted_log_spectral_distance([one], [other]) < 0.01
    loud = Signal(strong + 2000 * faint, 2000, "m/s^2")
    assert weighted_log_spectral_distance([one], [loud]) > 5


@pytest.mark.parametrize("unit", ["1", "N", "V"])
def test_without_a_threshold_the_scale_does_not_matter_but_a_level_error_does(unit):
    one, other = texture(0).samples, texture(1, pole=0.5).samples
    apart = [
        weighted_log_spectral_distance([Signal(scale * one, 1000, unit)], [Signal(scale * other, 1000, unit)])
        for scale in (1.0, 1e-4)
    ]
    assert apart[0] == pytest.approx(apart[1], rel=1e-4)
    doubled = weighted_log_spectral_distance([Signal(one, 1000, unit)], [Signal(2 * one, 1000, unit)])
    assert doubled == pytest.approx(20 * np.log10(2), abs=0.5)
