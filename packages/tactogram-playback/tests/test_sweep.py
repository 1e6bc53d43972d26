"""A display identified by a sweep."""

import numpy as np
import pytest
from scipy import fft

from tactogram.errors import ParameterError
from tactogram.rendering.displays.catalogue import open_display
from tactogram.signal import Signal
from tactogram_playback.sweep import exponential_sweep, identify

COIL = open_display("voice-coil")
SWEEP = exponential_sweep(COIL, seconds=4)
BAND = (20.0, 1000.0)


def recorded(*, delay=0, noise=0.0, bend=0.0, seed=0):
    """Return what an accelerometer on the coil records of the sweep."""
    size = fft.next_fast_len(2 * len(SWEEP))
    f = fft.rfftfreq(size, 1 / SWEEP.rate)
    h = np.concatenate([[0], COIL.response.at(f[1:])])
    y = fft.irfft(fft.rfft(SWEEP.samples[0].astype(np.float64), size) * h, size)[: len(SWEEP) + 2000]
    y = np.concatenate([np.zeros(delay), y])
    y = y + bend * y**2 + noise * np.random.default_rng(seed).normal(size=len(y))
    return Signal(y, SWEEP.rate, "m/s^2")


def gain_error_db(found):
    return np.abs(20 * np.log10(np.abs(found.response / COIL.response.at(found.frequency)))).max()


def test_the_sweep_goes_through_the_band_within_its_share_of_the_limit():
    assert np.abs(SWEEP.samples).max() <= 0.25 * COIL.limit * (1 + 1e-6)
    assert (SWEEP.rate, SWEEP.unit, SWEEP.axes) == (COIL.rate, "V", COIL.channels)
    assert not SWEEP.samples[0, :3900].any()
    power = np.abs(np.fft.rfft(SWEEP.samples[0])) ** 2
    f = np.fft.rfftfreq(len(SWEEP), 1 / SWEEP.rate)
    octaves = [power[(f > low) & (f < 2 * low)].sum() for low in (30, 60, 120, 240, 480)]
    np.testing.assert_allclose(octaves, np.mean(octaves), rtol=0.15)
    assert power[f > 2000].sum() < 1e-4 * power.sum()


def test_the_response_is_found_to_a_twentieth_of_a_db():
    found = identify(SWEEP, recorded(), band=BAND)
    assert found.unit == "m/s^2/V"
    assert found.frequency[[0, -1]] == pytest.approx(BAND)
    assert gain_error_db(found) < 0.05
    assert found.coherence.min() > 0.999


def test_the_phase_is_found_up_to_a_delay():
    found = identify(SWEEP, recorded(delay=123), band=BAND)
    assert found.delay_s == pytest.approx(123 / SWEEP.rate, abs=2 / SWEEP.rate)
    phase = np.unwrap(np.angle(found.response / COIL.response.at(found.frequency)))
    left = phase - np.polyval(np.polyfit(found.frequency, phase, 1), found.frequency)
    assert np.abs(left).max() < 0.01


def test_a_recording_that_began_late_and_at_another_rate_is_understood():
    late = recorded().cut(1600)
    half = Signal(late.samples[:, ::2], SWEEP.rate / 2, "m/s^2")
    found = identify(SWEEP, half, band=(20.0, 500.0))
    assert found.delay_s == pytest.approx(-0.2, abs=1e-3)
    assert gain_error_db(found) < 0.05


def test_noise_lowers_the_coherence_and_repeats_help():
    takes = [recorded(noise=0.5, seed=s) for s in range(4)]
    one = identify(SWEEP, takes[0], band=BAND)
    four = identify(SWEEP, takes[0], band=BAND, repeats=tuple(takes[1:]))
    assert one.coherence.min() < 0.99
    assert gain_error_db(four) < gain_error_db(one)


def test_distortion_hardly_enters_the_response_but_the_coherence():
    found = identify(SWEEP, recorded(bend=0.005), band=BAND)
    assert gain_error_db(found) < 0.5
    assert found.coherence.min() < 0.99


def test_what_cannot_be_identified_is_refused():
    with pytest.raises(ParameterError, match="nothing was recorded"):
        identify(SWEEP, Signal(np.zeros(1000), 8000, "m/s^2"), band=BAND)
    with pytest.raises(ParameterError, match="one recorded axis"):
        identify(SWEEP, Signal(np.ones((3, 1000)), 8000, "m/s^2"), band=BAND)
    with pytest.raises(ParameterError, match="at most 500 Hz"):
        identify(SWEEP, Signal(np.ones(1000), 1000, "m/s^2"), band=BAND)
    for name in ("erm-drv2605", "electrovibration", "ultrasonic"):
        with pytest.raises(
            ParameterError, match="a sweep is for displays whose drive has the shape of their output"
        ):
            exponential_sweep(open_display(name), band=(20, 80))
    biased = open_display("voice-coil", changes={"lowest": 0.0, "dc": True})
    with pytest.raises(ParameterError, match="takes no negative drive"):
        exponential_sweep(biased)
    with pytest.raises(ParameterError, match="share of the limit"):
        exponential_sweep(COIL, level=2)
    with pytest.raises(ParameterError, match="4 periods"):
        exponential_sweep(COIL, seconds=0.1)
