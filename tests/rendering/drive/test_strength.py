"""Strength of a vibration over time: that of the sine of equal power, as a share of full drive."""

import numpy as np
import pytest

from tactogram.errors import ParameterError, UnitError
from tactogram.rendering.displays.catalogue import display_of
from tactogram.rendering.drive.strength import StrengthSettings, correlation, strength
from tactogram.rendering.level import parse_level
from tactogram.signal import Signal
from tactogram.signal.perception import detection_threshold

DISPLAY = display_of(
    {
        "name": "lra",
        "title": "an LRA",
        "family": "linear",
        "rate": 1000,
        "channels": ["a"],
        "unit": "1",
        "limit": 1,
    }
)
SETTINGS = StrengthSettings(frequency_hz=175.0, output_at_full=10.0)
MIDDLE = slice(100, -100)


def sine(amplitude, hertz=175.0, unit="m/s^2", rate=4000):
    t = np.arange(rate) / rate
    return Signal(amplitude * np.sin(2 * np.pi * hertz * t), rate, unit)


def shares(signal, level, **changes):
    settings = SETTINGS.model_copy(update=changes)
    return strength(signal, settings, display=DISPLAY, level=parse_level(level))


def test_a_sine_is_as_strong_as_its_amplitude_at_the_displays_rate():
    found = shares(sine(4.0), "physical")
    assert found.share.shape == (1000,)
    assert found.share[MIDDLE] == pytest.approx(0.4, rel=0.02)
    assert found.scaled == ["10 m/s^2 of the signal are full drive"]
    assert found.limiting == 1


def test_a_displacement_is_as_strong_as_its_acceleration():
    metres = 4.0 / (2 * np.pi * 175) ** 2
    assert shares(sine(metres, unit="m"), "physical").share[MIDDLE] == pytest.approx(0.4, rel=0.02)


def test_a_gain_is_in_acceleration_or_in_parts_of_full_drive():
    newton = sine(2.0, unit="N")
    assert shares(newton, "gain=1").share[MIDDLE] == pytest.approx(0.2, rel=0.02)
    assert shares(newton, "gain=0.25", output_at_full=None).share[MIDDLE] == pytest.approx(0.5, rel=0.02)


def test_a_peak_is_that_share_at_the_strongest_moment():
    assert shares(sine(2.0, unit="N"), "peak=0.8").share.max() == pytest.approx(0.8)
    assert not shares(sine(0.0), "peak=0.8").share.any()


def test_another_frequency_is_felt_as_strongly_at_the_displays_own():
    found = shares(sine(0.5, hertz=80.0), "sensation").share[MIDDLE]
    ratio = float(detection_threshold(175.0, "m/s^2") / detection_threshold(80.0, "m/s^2"))
    assert found == pytest.approx(0.05 * ratio, rel=0.05)


def test_more_than_full_drive_is_scaled_clipped_or_refused():
    loud = sine(20.0)
    found = shares(loud, "physical")
    assert found.share.max() <= 1
    assert found.limiting == pytest.approx(0.5, rel=0.05)
    assert "over the limit of 1" in found.scaled[1]
    assert (shares(loud, "physical", over="clip").share[MIDDLE] == 1).all()
    with pytest.raises(ParameterError, match="over the limit of 1"):
        shares(loud, "physical", over="refuse")


@pytest.mark.parametrize(
    ("unit", "changes", "known"), [("N", {}, "is known"), ("m/s^2", {"output_at_full": None}, "is not known")]
)
def test_a_level_without_a_physical_meaning_is_refused(unit, changes, known):
    with pytest.raises(UnitError, match=f"that of lra {known}: use gain=FACTOR or peak=SHARE"):
        shares(sine(1.0, unit=unit), "physical", **changes)


def test_a_constant_strength_has_no_correlation():
    rising = np.linspace(0, 1, 50)
    assert correlation(rising, 2 * rising + 1) == pytest.approx(1)
    assert correlation(rising, -rising) == pytest.approx(-1)
    assert correlation(rising, np.ones(50)) is None
    assert correlation(rising[:1], rising[:1]) is None
