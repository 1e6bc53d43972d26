"""Register values for ERM and LRA drivers, and patterns for phones."""

import numpy as np
import pytest

from tactogram.errors import ParameterError, UnitError
from tactogram.rendering.displays.catalogue import open_display
from tactogram.rendering.drive.fit import fit
from tactogram.rendering.families.amplitude_stream import Settings, register_bytes, setup_registers
from tactogram.rendering.level import parse_level
from tactogram.signal import Signal
from tactogram.signal.perception import detection_threshold

T = np.arange(3000) / 2000


def tone(amplitude, hz=100.0, *, unit="m/s^2", swell=None):
    shape = np.ones(len(T)) if swell is None else 0.5 - 0.5 * np.cos(2 * np.pi * swell * T)
    return Signal(amplitude * shape * np.sin(2 * np.pi * hz * T), 2000, unit)


def lra(**changes):
    named = {f"amplitude_stream.{key}": value for key, value in changes.items()}
    return open_display("lra-drv2605", changes=named)


def steady(drive):
    """Return the value in the middle of a drive."""
    return float(drive.signal.samples[0, len(drive.signal) // 2])


def test_values_are_whole_and_of_eight_signed_bits():
    drive = fit(tone(5, swell=4), lra(), level=parse_level("sensation")).signal
    np.testing.assert_array_equal(drive.samples, np.round(drive.samples))
    values = register_bytes(drive)
    assert values.dtype == np.uint8
    np.testing.assert_array_equal(values.view(np.int8), drive.samples[0])


def test_a_physical_match_is_the_share_of_full_output():
    """15 m/s^2 at rated drive, which is 0.7 of 127: 6 m/s^2 need 0.4 of that."""
    assert steady(fit(tone(6), lra(), level=parse_level("physical"))) == pytest.approx(0.4 * 0.7 * 127, abs=1)


def test_an_erm_takes_the_root_since_its_force_goes_with_the_square():
    erm = open_display("erm-drv2605")
    drive = fit(tone(9.8 / 4), erm, level=parse_level("physical"))
    assert steady(drive) == pytest.approx(0.5 * 127, abs=1)


def test_a_sensation_level_is_carried_to_the_actuators_own_frequency():
    """A sine of 60 Hz becomes 175 Hz at the same multiple of the threshold."""
    times = 20.0
    signal = tone(times * float(detection_threshold(60.0, "m/s^2")), 60.0)
    wanted = times * float(detection_threshold(175.0, "m/s^2")) / 15
    drive = fit(signal, lra(), level=parse_level("sensation"))
    assert steady(drive) == pytest.approx(wanted * 0.7 * 127, abs=1)
    louder = fit(signal, lra(), level=parse_level(f"sensation={20 * np.log10(times) + 6.0206:.4f}"))
    assert steady(louder) == pytest.approx(2 * wanted * 0.7 * 127, abs=2)


def test_overdrive_makes_an_lra_follow_what_it_would_lag_behind():
    signal = tone(5, swell=8)
    plain = fit(signal, lra(overdrive=False, rise_ms=40), level=parse_level("physical")).report.facts
    driven = fit(signal, lra(rise_ms=40), level=parse_level("physical")).report.facts
    assert driven["strength_rms_error"] < 0.5 * plain["strength_rms_error"]
    assert driven["strength_correlation"] > 0.99
    assert driven["braking_share"] > 0
    assert plain["braking_share"] == plain["overdriven_share"] == 0


def test_in_closed_loop_nothing_is_negative():
    drive = fit(tone(5, swell=4), open_display("erm-drv2605"), level=parse_level("sensation"))
    assert drive.signal.samples.min() == 0
    assert any("driver's own" in line for line in drive.report.scaled)


def test_what_is_too_weak_to_start_a_motor_is_silent_and_counted():
    erm = open_display("erm-drv2605", changes={"amplitude_stream.start": 0.4})
    drive = fit(tone(9.8 * 0.3, swell=1), erm, level=parse_level("physical"))
    sent = drive.signal.samples[0]
    assert sent[sent > 0].min() >= 0.4 * 127 - 1
    assert drive.report.facts["silent_share"] > 0.2
    assert any("too weak to move it" in line for line in drive.report.unreachable)


def test_too_strong_is_scaled_clipped_or_refused():
    loud = tone(60, swell=2)
    scaled = fit(loud, lra(), level=parse_level("physical")).report
    assert scaled.facts["limiting"] == pytest.approx(0.25, abs=0.03)
    assert fit(loud, lra(over="clip"), level=parse_level("physical")).report.clipped
    with pytest.raises(ParameterError, match="over the limit"):
        fit(loud, lra(over="refuse"), level=parse_level("physical"))


def test_the_last_value_is_rest_since_the_driver_holds_it():
    for name in ("lra-drv2605", "erm-drv2605", "phone", "phone-on-off"):
        assert fit(tone(5), open_display(name), level=parse_level("peak=1")).signal.samples[0, -1] == 0


def test_a_friction_coefficient_has_a_peak_or_a_gain_only():
    with pytest.raises(UnitError, match="the signal is in 1"):
        fit(tone(1, unit="1"), lra(), level=parse_level("sensation"))
    assert steady(fit(tone(1, unit="1"), lra(), level=parse_level("peak=0.5"))) == pytest.approx(44, abs=1)


@pytest.mark.parametrize(
    ("actuator", "loop", "registers"),
    [
        ("erm", "closed", [[1, 5], [0x1A, 0x36], [0x1C, 0xF5], [0x1D, 0x80]]),
        ("erm", "open", [[1, 5], [0x1A, 0x36], [0x1C, 0xF5], [0x1D, 0xA0]]),
        ("lra", "closed", [[1, 5], [0x1A, 0xB6], [0x1C, 0xF5], [0x1D, 0x80]]),
        ("lra", "open", [[1, 5], [0x1A, 0xB6], [0x1C, 0xF5], [0x1D, 0x81]]),
    ],
)
def test_the_registers_say_which_actuator_and_loop(actuator, loop, registers):
    assert setup_registers(Settings(actuator=actuator, loop=loop, frequency_hz=175)) == registers
