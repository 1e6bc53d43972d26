"""Factors of a level, the reduction of a drive beyond its limits, and a constant that is taken away."""

import numpy as np
import pytest

from tactogram.errors import ParameterError, UnitError
from tactogram.rendering.displays.catalogue import display_of
from tactogram.rendering.drive.level_scaling import (
    factor_of,
    kinematic_power,
    within_limits,
    without_constant,
)
from tactogram.rendering.level import parse_level
from tactogram.signal import Signal

BASE = {
    "name": "coil", "title": "a coil", "family": "linear", "rate": 4000, "channels": ["a"], "unit": "V", "limit": 10,
}  # fmt: skip
KNOWN = display_of(BASE | {"response": {"kind": "flat", "unit": "m/s^2", "gain": 1}})


def sine(amplitude, unit="m/s^2", hertz=200.0):
    t = np.arange(4000) / 4000
    return Signal(amplitude * np.sin(2 * np.pi * hertz * t), 4000, unit)


def factors(level, *, display=KNOWN, signal=None, peak=2.0, output=None):
    signal = sine(1.0) if signal is None else signal
    wanted = signal if output is None else output
    return factor_of(parse_level(level), display=display, signal=signal, output=wanted, peak=peak)


def test_a_motion_is_differentiated_as_often_as_its_unit_says():
    assert [kinematic_power(unit, KNOWN) for unit in ("m", "m/s", "m/s^2", "N")] == [2, 1, 0, 0]


def test_each_kind_of_level_has_its_factor():
    assert factors("physical")[:2] == (1, 1)
    assert factors("gain=3")[:2] == (3, 3)
    assert factors("peak=0.5")[:2] == (2.5, 2.5)  # half of 10 V, of which a factor of 1 would take 2 V
    assert factors("peak=0.5", peak=0.0)[0] == 1


def test_a_sensation_level_is_made_up_for_in_db():
    same, wanted, _ = factors("sensation", output=sine(0.1))
    assert (same, wanted) == pytest.approx((10, 1), rel=1e-3)
    quiet, other, _ = factors("sensation=20")
    louder, _, _ = factors("sensation=26")
    assert quiet == other
    assert louder / quiet == pytest.approx(10 ** (6 / 20), rel=1e-6)
    silent = sine(0.0)
    assert factors("sensation", signal=silent) == (1, 1, "nothing: the signal is silent")


@pytest.mark.parametrize("level", ["physical", "sensation", "sensation=3"])
def test_a_level_without_a_physical_meaning_is_refused(level):
    with pytest.raises(
        UnitError, match=r"the signal is in N, the output of coil is in m/s\^2: measure its response"
    ):
        factors(level, signal=sine(1.0, "N"))
    with pytest.raises(UnitError, match="the output of coil is not known"):
        factors(level, display=display_of(BASE))


def limited(drive, low, high, over, clip_share=0.0):
    scaled, clipped = [], []
    made, factor = within_limits(
        np.array(drive), low, high, unit="V", over=over, clip_share=clip_share, scaled=scaled, clipped=clipped
    )
    return made.tolist(), factor, scaled, clipped


def test_a_drive_within_its_limits_is_left_alone():
    assert limited([-1.0, 0.5, 1.0], -1, 1, "refuse") == ([-1, 0.5, 1], 1, [], [])


def test_what_exceeds_a_limit_is_scaled_clipped_or_refused():
    made, factor, scaled, clipped = limited([-4.0, 0.5, 2.0, 1.0], -2, 1, "scale")
    assert (made, factor) == ([-2, 0.25, 1, 0.5], 0.5)
    assert scaled == ["times 0.5 (-6.0 dB): 50 % of the drive was over the limit of 1 V"]
    assert clipped == []
    made, factor, scaled, clipped = limited([-4.0, 0.5, 2.0, 1.0], -2, 1, "clip")
    assert (made, factor, scaled) == ([-2, 0.5, 1, 1], 1, [])
    assert clipped == ["50 % of the samples at 1 V, the largest by 6.0 dB"]
    with pytest.raises(ParameterError, match=r"50 % of the drive is over the limit of 1 V \(largest 2 V\)"):
        limited([-4.0, 0.5, 2.0, 1.0], -2, 1, "refuse")


def test_few_samples_may_be_clipped_and_the_rest_stays():
    drive = [3.0, *[0.5] * 99]
    made, factor, scaled, clipped = limited(drive, 0, 1, "refuse", clip_share=0.01)
    assert (made[:2], factor, scaled) == ([1, 0.5], 1, [])
    assert clipped == ["1 % of the samples at 1 V, the largest by 9.5 dB"]


def test_a_constant_of_a_motion_is_taken_away_and_said_where_it_matters():
    moved = sine(1.0).with_samples(sine(1.0).samples + 9.81)
    still, words = without_constant(moved)
    np.testing.assert_allclose(still.samples, sine(1.0).samples, atol=1e-5)
    assert words == "a constant of up to 9.81 m/s^2 removed: gravity or an offset, no vibration"
    little = sine(1.0).with_samples(sine(1.0).samples + 0.01)
    found, words = without_constant(little)
    assert words is None
    assert abs(found.samples.mean()) < 1e-6
    assert without_constant(little, least=0.1)[0] is little
    force = sine(1.0, "N")
    assert without_constant(force) == (force, None)
