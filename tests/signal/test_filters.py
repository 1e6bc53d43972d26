import subprocess
import sys

import numpy as np
import pytest
from hypothesis import given, settings, strategies as st
from scipy import signal as dsp

from tactogram.errors import ParameterError, UnitError
from tactogram.signal import Signal
from tactogram.signal.filters import bandpass, butterworth, dft321, differentiate, principal_axis

BANDS = [(44100, 20, 1000), (10000, 20, 1000), (330, 10, 160), (1000, 0, 100), (44100, 0.5, 20000)]


def sine(frequency, rate, seconds, *, phase=0.3, level=1.0, unit="m/s^2"):
    t = np.arange(round(rate * seconds)) / rate
    return Signal(level * np.sin(2 * np.pi * frequency * t + phase), rate, unit)


def level_db(signal, reference, margin):
    kept = slice(margin, -margin)
    ratio = signal.samples[0, kept].astype(float).std() / reference.samples[0, kept].astype(float).std()
    return 20 * np.log10(ratio)


@pytest.mark.parametrize(("rate", "low", "high"), BANDS)
@pytest.mark.parametrize("passes", [1, 2])
def test_edges_are_at_3_db_after_all_passes(rate, low, high, passes):
    sos = butterworth(rate, low, high, passes=passes)
    _, response = dsp.sosfreqz(sos, worN=[f for f in (low, high) if f > 0], fs=rate)
    np.testing.assert_allclose(20 * passes * np.log10(np.abs(response)), -3.0103, atol=1e-3)


@pytest.mark.parametrize(("frequency", "expected"), [(20, -3.01), (150, 0), (500, -3.01)])
def test_bandpass_has_its_gain_on_a_sine(frequency, expected):
    x = sine(frequency, 3000, 4)
    assert level_db(bandpass(x, 20, 500), x, 1500) == pytest.approx(expected, abs=0.05)


def test_bandpass_removes_what_is_outside():
    outside = sine(5, 3000, 4).with_samples(
        sine(5, 3000, 4).samples + sine(1200, 3000, 4).samples + np.float32(9.81)
    )
    assert np.abs(bandpass(outside, 20, 500).samples[:, 600:-600]).max() < 1e-3


def test_bandpass_does_not_delay():
    x = np.zeros(2001, np.float32)
    x[1000] = 1
    y = bandpass(Signal(x, 1000, "V"), 50, 200).samples[0]
    np.testing.assert_allclose(y, y[::-1], atol=1e-6)
    assert y.argmax() == 1000


def test_bandpass_from_zero_keeps_a_constant():
    x = Signal(np.full((3, 500), 9.81), 1000, "m/s^2")
    np.testing.assert_allclose(bandpass(x, 0, 100).samples, 9.81, rtol=1e-6)


def test_band_at_half_the_rate_is_refused_in_one_line():
    with pytest.raises(ParameterError, match=r"below half the rate \(165 Hz\), got 20 1000") as refusal:
        bandpass(sine(50, 330, 1), 20, 1000)
    assert "\n" not in str(refusal.value)


@pytest.mark.parametrize(("low", "high"), [(100, 20), (-1, 20), (20, 20), (np.nan, 20)])
def test_an_empty_band_is_refused(low, high):
    with pytest.raises(ParameterError, match="low < high"):
        bandpass(sine(50, 330, 1), low, high)


@given(st.integers(1, 60), st.sampled_from(BANDS))
@settings(deadline=None, max_examples=40)
def test_any_length_can_be_filtered(length, band):
    rate, low, high = band
    x = np.random.default_rng(length).normal(size=(2, length))
    y = bandpass(Signal(x, rate, "N", ("a", "b")), low, high)
    assert y.samples.shape == (2, length)
    assert np.abs(y.samples).max() < 20


@given(st.integers(1, 400), st.integers(0, 2**31))
@settings(deadline=None, max_examples=60)
def test_dft321_keeps_the_energy_at_every_frequency(length, seed):
    """Landin et al. 2010: the combined spectrum has the summed power of the three."""
    x = Signal(np.random.default_rng(seed).normal(size=(3, length)), 1000, "m/s^2")
    y = dft321(x)
    power = (np.abs(np.fft.rfft(x.samples.astype(float))) ** 2).sum(axis=0)
    np.testing.assert_allclose(
        np.abs(np.fft.rfft(y.samples[0].astype(float))) ** 2, power, atol=1e-4 * length
    )


def test_dft321_has_the_phase_of_the_sum():
    x = Signal(np.random.default_rng(0).normal(size=(3, 256)), 1000, "m/s^2")
    total = np.fft.rfft(x.samples.astype(float).sum(axis=0))
    combined = np.fft.rfft(dft321(x).samples[0].astype(float))
    assert np.abs(np.angle(combined * total.conj()))[1:-1].max() < 1e-4


def test_dft321_of_one_moving_axis_is_that_axis():
    x = np.zeros((3, 300), np.float32)
    x[1] = sine(50, 1000, 0.3).samples
    np.testing.assert_allclose(dft321(Signal(x, 1000, "m/s^2")).samples[0], x[1], atol=1e-6)


def test_dft321_energy_does_not_depend_on_orientation():
    rng = np.random.default_rng(1)
    turn, _ = np.linalg.qr(rng.normal(size=(3, 3)))
    x = rng.normal(size=(3, 512))
    spectra = [
        np.abs(np.fft.rfft(dft321(Signal(a, 1000, "m/s^2")).samples[0].astype(float))) for a in (x, turn @ x)
    ]
    np.testing.assert_allclose(*spectra, rtol=1e-3, atol=1e-3)


def test_dft321_needs_three_axes():
    with pytest.raises(ParameterError, match="three axes, got 1"):
        dft321(sine(50, 330, 1))


def test_a_signal_costs_no_scipy_until_it_is_filtered():
    code = "import sys, tactogram.signal, tactogram.signal.resampling; assert 'scipy' not in sys.modules"
    subprocess.run([sys.executable, "-c", code], check=True, timeout=60)


T = np.arange(4000) / 2000


@given(st.floats(20, 900))
@settings(deadline=None, max_examples=25)
def test_the_derivative_of_a_sine_is_its_cosine(frequency):
    w = 2 * np.pi * frequency
    velocity = differentiate(Signal(1e-6 * np.sin(w * T), 2000, "m"))
    assert velocity.unit == "m/s"
    np.testing.assert_allclose(velocity.samples[0, 800:-800] / (1e-6 * w), np.cos(w * T)[800:-800], atol=0.02)


def test_a_ramp_has_a_constant_derivative_to_its_ends():
    np.testing.assert_allclose(differentiate(Signal(5 * T, 2000, "m")).samples, 5, rtol=3e-3)


@pytest.mark.parametrize("unit", ["N", "m/s^2"])
def test_only_a_motion_is_differentiated(unit):
    with pytest.raises(UnitError, match="differentiated, got"):
        differentiate(Signal(T, 2000, unit))


def test_what_has_no_derivative_is_refused():
    with pytest.raises(ParameterError, match="two samples"):
        differentiate(Signal([1.0], 2000, "m/s"))
    with pytest.raises(ParameterError, match="displacement"):
        differentiate(Signal(T, 20, "m", domain="displacement"))


def test_the_principal_axis_is_the_direction_of_the_vibration():
    rng = np.random.default_rng(0)
    along = np.array([0.6, 0.0, -0.8])
    vibration, noise = rng.normal(size=500), 1e-3 * rng.normal(size=(3, 500))
    signal = Signal(np.outer(along, vibration) + noise + 9.8, 1000, "m/s^2", ("x", "y", "z"))
    found = principal_axis(signal)
    assert found.axes == ("pca",)
    np.testing.assert_allclose(found.samples[0], -(vibration - vibration.mean()), atol=0.01)
