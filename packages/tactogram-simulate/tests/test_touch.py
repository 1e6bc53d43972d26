"""A finger on plates and on an ultrasonic display."""

import numpy as np
import pytest

from tactogram.errors import ParameterError
from tactogram.signal import Signal
from tactogram_simulate.materials import Plate
from tactogram_simulate.surfaces import PATCH_MM, Grating, Surface
from tactogram_simulate.touch import (
    CARRIER_HZ,
    HALF,
    HORN_FRICTION,
    LUBRICATED,
    QUALITY,
    display_touched,
    plate_touched,
)

T = np.arange(10_000) / 10_000


def drive(samples):
    return Signal(np.asarray(samples, np.float32), 10_000.0, "1", ("drive",))


def sine(hz, level=1.0):
    return drive(level * np.sin(2 * np.pi * hz * T))


def test_the_transducer_passes_the_envelope_up_to_its_corner():
    corner = CARRIER_HZ / (2 * QUALITY)
    assert corner == 141.0
    slow, at_corner = (display_touched(sine(hz, 0.02)).drag.std() for hz in (5, 141))
    assert at_corner / slow == pytest.approx(0.5**0.5, rel=0.02)


def test_vibration_takes_friction_away():
    """At half of the envelope, as a weak signal leaves it: mu = mu0 (1 - a e^2 / (e^2 + h^2))."""
    expected = HORN_FRICTION * (1 - LUBRICATED * 0.25 / (0.25 + HALF**2))
    assert display_touched(sine(200, 0.01)).friction == pytest.approx(expected, rel=1e-3)
    assert display_touched(sine(5, 1.0)).friction > 1.2 * expected


def test_a_display_has_no_relief():
    touched = display_touched(sine(20))
    assert (touched.relief_mm, touched.steepness) == (0.0, 0.0)


def test_what_is_beyond_full_scale_is_cut_off():
    over = 3 * np.sin(2 * np.pi * 50 * T)
    np.testing.assert_array_equal(
        display_touched(drive(over)).drag, display_touched(drive(np.clip(over, -1, 1))).drag
    )


@pytest.mark.parametrize(
    "wrong",
    [
        Signal(np.zeros((1, 10_000)), 10_000.0, "V", ("drive",)),
        Signal(np.zeros((2, 10_000)), 10_000.0, "1", ("a", "b")),
        Signal(np.zeros((1, 500)), 10_000.0, "1", ("drive",)),
    ],
)
def test_a_drive_that_no_display_takes_is_refused(wrong):
    with pytest.raises(ParameterError, match="drive"):
        display_touched(wrong)


def test_relief_and_steepness_are_those_of_the_formula():
    wave = Plate(Surface("wave 01", (Grating(2.0, 0.2),), 0.4), "a cosine of 2 mm", 0.1)
    touched = plate_touched(wave)
    k = round(PATCH_MM / 2.0) / PATCH_MM
    assert touched.relief_mm == pytest.approx(0.1 / 2**0.5, rel=1e-3)
    assert touched.steepness == pytest.approx(0.1 / 2**0.5 * 2 * np.pi * k, rel=1e-3)
    assert touched.friction == pytest.approx(0.4, rel=0.1)
