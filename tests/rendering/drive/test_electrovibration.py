"""Voltage for friction: square law, limits, slew, and friction that cannot be had."""

import numpy as np
import pytest
from hypothesis import given, settings, strategies as st
from pydantic import ValidationError

from tactogram.errors import ParameterError
from tactogram.rendering.drive.electrovibration import (
    Settings,
    friction,
    friction_target,
    modulated,
    slewed,
    voltage,
)
from tactogram.rendering.level import Level
from tactogram.signal import Signal
from tactogram.signal.filters import butterworth

PHYSICAL = Level("physical")


def given_settings(**changes):
    return Settings(**{"newton_per_v2": 2e-5, "mu_0": 0.3, "v_max": 141.0, **changes})


def coefficient(frequency, *, low=0.32, high=0.4, rate=4000, seconds=0.5):
    t = np.arange(round(rate * seconds)) / rate
    middle, swing = (low + high) / 2, (high - low) / 2
    return Signal(middle - swing * np.cos(2 * np.pi * frequency * t), rate, "1")


def felt(drive, s):
    """Return the friction that the square of the drive gives below 3 kHz, by the square law."""
    from scipy import signal as dsp

    sos = butterworth(drive.rate, 0, 3000, passes=2)
    square = dsp.sosfiltfilt(sos, (s.amplifier_gain * drive.samples[0].astype(float)) ** 2)
    return s.mu_0 * (1 + s.newton_per_v2 * square / s.normal_force_n)


def line(x, frequency, rate):
    x = (x - x.mean()) * np.hanning(len(x)) * 2
    return 2 * abs(np.mean(x * np.exp(-2j * np.pi * frequency * np.arange(len(x)) / rate)))


def test_the_square_law_is_its_own_inverse():
    s = given_settings()
    mu = np.linspace(s.mu_0, s.mu_max, 50)
    np.testing.assert_allclose(friction(voltage(mu, s), s), mu, rtol=1e-12)
    assert friction(100.0, s) == pytest.approx(0.3 * (1 + 2e-5 * 1e4 / 0.5))
    assert voltage(0.1, s) == 0
    assert voltage(9.0, s) == pytest.approx(141 / np.sqrt(2))


@settings(max_examples=12)
@given(frequency=st.integers(4, 100).map(lambda n: 5 * n), high=st.floats(0.33, 0.41))
def test_the_root_envelope_leaves_no_second_harmonic(frequency, high):
    s = given_settings(slew_v_per_s=1e9)
    drive, _ = modulated(coefficient(frequency, low=0.31, high=high), s, rate=96_000)
    x = felt(drive, s)[9600:-9600]
    first, second = line(x, frequency, 96_000), line(x, 2 * frequency, 96_000)
    assert first == pytest.approx((high - 0.31) / 2, rel=0.01)
    assert second < 2e-3 * first


def test_a_linear_envelope_would_leave_a_quarter():
    t = np.arange(48_000) / 96_000
    v = 100 * 0.5 * (1 + np.sin(2 * np.pi * 120 * t)) * np.sin(2 * np.pi * 10_000 * t)
    x = felt(Signal(v, 96_000, "V"), given_settings())[9600:-9600]
    assert line(x, 240, 96_000) / line(x, 120, 96_000) == pytest.approx(0.25, rel=0.01)


@settings(max_examples=60)
@given(
    seed=st.integers(0, 999),
    k_e=st.floats(1e-7, 1e-3),
    v_max=st.floats(1, 400),
    amplifier=st.floats(1, 100),
    gain=st.floats(0.2, 8),
    below=st.sampled_from(["shift", "clip"]),
    over=st.sampled_from(["scale", "clip"]),
    output=st.sampled_from(["waveform", "envelope"]),
    slew=st.floats(1e3, 1e7),
)
def test_no_drive_exceeds_its_limit(seed, k_e, v_max, amplifier, gain, below, over, output, slew):
    s = given_settings(
        newton_per_v2=k_e,
        v_max=v_max,
        amplifier_gain=amplifier,
        perceptual_gain=gain,
        below=below,
        over=over,
        output=output,
        slew_v_per_s=slew,
    )
    mu = Signal(0.4 + 0.2 * np.random.default_rng(seed).standard_normal(200), 2000, "1")
    target, facts, _ = friction_target(mu, s, PHYSICAL)
    drive, more = modulated(target, s, rate=48_000)
    assert np.abs(drive.samples.astype(float)).max() <= s.peak_v
    assert more["highest_v"] <= v_max * (1 + 1e-9)
    assert facts["mu_given"][0] >= s.mu_0 * (1 - 1e-9)
    if output == "envelope":
        volts = drive.samples[0].astype(float) * amplifier
        assert volts.min() >= 0
        assert np.abs(np.diff(volts)).max() <= slew / 48_000 + 1e-5 * v_max


@settings(max_examples=40)
@given(st.lists(st.floats(0, 10), min_size=1, max_size=60), st.floats(0.01, 5))
def test_a_slewed_envelope_is_the_largest_below(values, most):
    x = np.array(values)
    y = slewed(x, most)
    n = np.arange(len(x))
    np.testing.assert_allclose(y, (x[None] + most * np.abs(n[:, None] - n[None])).min(axis=1), atol=1e-9)


def test_friction_below_the_bare_display_is_raised_and_reported():
    mu = coefficient(50, low=0.2, high=0.26)
    target, facts, words = friction_target(mu, given_settings(), PHYSICAL)
    assert facts["shift"] == pytest.approx(0.1, abs=1e-6)
    assert target.samples.min() == pytest.approx(0.3)
    np.testing.assert_allclose(target.samples - mu.samples, 0.1, atol=1e-6)
    assert "only increases are possible" in words["scaled"][1]
    assert "below 0.3" in words["unreachable"][0]


def test_friction_below_may_be_clipped_instead():
    target, facts, _ = friction_target(
        coefficient(50, low=0.25, high=0.35), given_settings(below="clip"), PHYSICAL
    )
    assert facts["below_share"] == pytest.approx(0.5, abs=0.03)
    assert facts["shift"] == 0
    assert target.samples.max() == pytest.approx(0.35)


def test_too_much_friction_is_scaled_clipped_or_refused():
    mu = coefficient(50, low=0.3, high=0.8)
    s = given_settings()
    target, facts, _ = friction_target(mu, s, PHYSICAL)
    assert facts["increase_scaled_by"] == pytest.approx((s.mu_max - 0.3) / 0.5)
    assert target.samples.max() == pytest.approx(s.mu_max)
    _, facts, words = friction_target(mu, given_settings(over="clip"), PHYSICAL)
    assert facts["beyond_share"] > 0.5
    assert words["clipped"]
    with pytest.raises(ParameterError, match=r"beyond 0\.419, what v_max 141 V gives"):
        friction_target(mu, given_settings(over="refuse"), PHYSICAL)


def test_the_perceptual_gain_is_of_the_deviation_and_logged():
    mu = coefficient(50, low=0.34, high=0.36)
    target, facts, words = friction_target(mu, given_settings(perceptual_gain=3), PHYSICAL)
    assert (facts["perceptual_gain"], facts["gain"]) == (3, 3)
    assert np.ptp(target.samples) == pytest.approx(0.06, rel=1e-3)
    assert target.samples.mean() == pytest.approx(0.35, abs=1e-4)
    assert "not a physical match" in words["scaled"][1]
    assert "assumed, not calibrated" in words["scaled"][0]


@pytest.mark.parametrize(
    ("change", "match"),
    [
        ({"v_max": 0}, "greater than 0"),
        ({"carrier_hz": 500}, "above what is felt"),
        ({"volts": 3}, "Extra inputs"),
        ({"newton_per_v2": float("nan")}, "finite|greater"),
    ],
)
def test_settings_that_cannot_be_are_refused(change, match):
    with pytest.raises(ValidationError, match=match):
        given_settings(**change)
