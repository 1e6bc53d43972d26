import numpy as np
import pytest
from scipy.signal import lfilter

from tactogram.errors import ParameterError
from tactogram.evaluation.measures import (
    level_difference_db,
    log_spectral_distance,
    weighted_log_spectral_distance,
)
from tactogram.evaluation.measures.distances.weighted_log_spectral_distance_db import _felt_levels
from tactogram.evaluation.measures.spectra import SILENT, felt_edges
from tactogram.signal import Signal
from tactogram.signal.perception import detection_threshold, sensation_level_db


def texture(seed, pole=0.9, gain=1.0, seconds=4):
    noise = np.random.default_rng(seed).standard_normal(int(1000 * seconds))
    return Signal(gain * lfilter([1], [1, -pole], noise), 1000, "m/s^2")


def sine(frequency, amplitude, unit="m/s^2", rate=2000.0):
    t = np.arange(round(2 * rate)) / rate
    return Signal(amplitude * np.sin(2 * np.pi * frequency * t), rate, unit)


def test_identical_sets_have_distance_0():
    assert log_spectral_distance([texture(0)], [texture(0)]) == 0


def test_a_level_difference_of_6_db_is_6_db():
    assert log_spectral_distance([texture(0, gain=2)], [texture(0)]) == pytest.approx(
        20 * np.log10(2), abs=1e-4
    )


def test_phase_and_shift_do_not_count_but_another_texture_does():
    floor = log_spectral_distance([texture(0)], [texture(1)])
    late = texture(0).cut(2)
    assert log_spectral_distance([late], [texture(0)]) < 0.2
    assert floor < 2
    assert log_spectral_distance([texture(0)], [texture(1, pole=-0.5)]) > 5 * floor


def test_signals_of_different_kinds_are_refused():
    with pytest.raises(ParameterError, match="got 2 kinds"):
        log_spectral_distance([texture(0)], [Signal(np.ones(500), 500, "m/s^2")])
    with pytest.raises(ParameterError, match=r"at least 0.25 s, got 0.1 s"):
        log_spectral_distance([texture(0, seconds=0.1)], [texture(0)])
    with pytest.raises(ParameterError, match="band must hold a frequency below 500 Hz, got 600 800"):
        log_spectral_distance([texture(0)], [texture(0)], band=(600, 800))


def test_the_distance_is_the_difference_of_two_filters():
    # White noise and the same through 1 - 0.5/z: the distance is that of the filter's gain from 0 dB.
    noise = [np.random.default_rng(k).standard_normal(4000) for k in range(6)]
    one = [Signal(x, 1000, "1") for x in noise]
    other = [Signal(lfilter([1, -0.5], [1], x), 1000, "1") for x in noise]
    f = np.arange(12, 501, 4)  # segments of 0.25 s: 4 Hz
    gain_db = 20 * np.log10(np.abs(1 - 0.5 * np.exp(-2j * np.pi * f / 1000)))
    assert log_spectral_distance(one, other) == pytest.approx(np.sqrt(np.mean(gain_db**2)), abs=0.05)


def test_length_does_not_bias_the_distance():
    # The mean logarithm of the spectrum of one segment is 2.5 dB below that of many.
    random = np.random.default_rng(0)
    short = [Signal(random.standard_normal(250), 1000, "1") for _ in range(1500)]
    long = [Signal(random.standard_normal(4000), 1000, "1") for _ in range(60)]
    assert log_spectral_distance(short, long) < 0.5
    assert weighted_log_spectral_distance(short, long) < 0.5


def test_a_filtered_out_band_does_not_count():
    t = texture(0).samples
    a = Signal(t + 1e-7 * texture(1, pole=-0.9).samples, 1000, "1")
    low = np.fft.irfft(np.fft.rfft(t) * (np.fft.rfftfreq(4000, 1e-3) < 200), n=4000)
    quiet = [
        Signal(low + g * np.random.default_rng(2).standard_normal(4000), 1000, "1") for g in (1e-6, 1e-5)
    ]
    assert log_spectral_distance(quiet[:1], quiet[1:]) < 0.1  # 20 dB apart where nothing is
    assert log_spectral_distance([a], [Signal(t, 1000, "1")]) < 0.1


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


def test_the_level_of_sines_is_that_of_their_amplitudes():
    assert level_difference_db([sine(100, 3.0)], [sine(300, 1.0)]) == pytest.approx(
        20 * np.log10(3), abs=1e-3
    )
    # Sets are compared by their mean level in dB: 0 and 20 dB on one side are 10 dB.
    assert level_difference_db([sine(100, 1.0), sine(100, 10.0)], [sine(100, 1.0)]) == pytest.approx(
        10, abs=1e-3
    )


def test_gravity_and_drift_have_no_level():
    still = sine(100, 1.0)
    moved = still.with_samples(still.samples + 9.81 + np.sin(np.arange(len(still)) / 2000))
    assert level_difference_db([still], [moved]) < 0.02


def test_silence_is_finite():
    silent = Signal(np.zeros(500), 1000, "m/s^2")
    for measure in (log_spectral_distance, weighted_log_spectral_distance, level_difference_db):
        assert measure([silent], [silent]) == 0
        assert np.isfinite(measure([silent], [texture(0)]))
    assert level_difference_db([silent], [texture(0)]) > -10 * np.log10(SILENT) - 40
