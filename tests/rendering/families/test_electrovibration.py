"""Electrovibration: rendered files and the stream under a finger."""

import numpy as np
import pytest
from hypothesis import given, settings, strategies as st
from tests.rendering.drive.test_electrovibration import PHYSICAL, coefficient, felt, given_settings, line

from tactogram.errors import UnitError
from tactogram.rendering.displays.catalogue import open_display
from tactogram.rendering.drive.fit import fit
from tactogram.rendering.families.electrovibration import ElectrovibrationStream
from tactogram.rendering.level import Level
from tactogram.signal import Signal


def ridges(*, length_mm=100, rate=20, period_mm=1.0):
    k = np.arange(length_mm * rate) / rate
    return Signal(0.35 + 0.04 * np.sin(2 * np.pi * k / period_mm), rate, "1", domain="displacement")


@pytest.mark.real_data
def test_recorded_friction_is_rendered_and_what_is_missing_said(real_data):
    from tactogram_benchmark.importers import cdplab

    display = open_display("electrovibration")
    fabric = next(item for item in cdplab.find(real_data("cdplab_friction")) if "fabric" in item.name)
    friction_mm = cdplab.read(fabric)[0].streams["friction"].cut(0, 1200)
    drive = fit(friction_mm, display, level=PHYSICAL, speed_mm_s=100)
    assert np.abs(drive.signal.samples).max() == pytest.approx(141, rel=1e-3)
    assert drive.report.facts["increase_scaled_by"] == pytest.approx(0.186, abs=0.001)
    assert any("19 % of the wanted swing" in words for words in drive.report.unreachable)


def test_friction_of_the_bare_display_is_no_voltage_at_all():
    drive = fit(Signal(np.full(200, 0.3), 2000, "1"), open_display("electrovibration"), level=PHYSICAL)
    assert not drive.signal.samples.any()


def test_any_signal_can_be_played_at_a_share_of_the_limit():
    x = Signal(np.random.default_rng(0).standard_normal(2000), 2000, "m/s^2")
    drive = fit(x, open_display("electrovibration"), level=Level("peak", 0.5))
    assert np.abs(drive.signal.samples).max() == pytest.approx(70.5, rel=0.03)
    with pytest.raises(UnitError, match="any signal takes peak=SHARE"):
        fit(x, open_display("electrovibration"), level=PHYSICAL)
    with pytest.raises(UnitError, match="does not apply to friction"):
        fit(coefficient(50), open_display("electrovibration"), level=Level("sensation", 20))


def test_a_shipped_display_gives_the_friction_asked_for():
    display = open_display("electrovibration", changes={"fade_ms": 0})
    drive = fit(ridges(), display, level=PHYSICAL, speed_mm_s=100)
    x = felt(drive.signal, display.settings)[4800:-4800]
    assert line(x, 100, 48_000) == pytest.approx(0.04, rel=0.02)
    assert x.mean() == pytest.approx(0.35, abs=2e-3)


def streamed(stream, speed_mm_s, blocks, *, length=240, start=0.0):
    ends = start + speed_mm_s * length / stream.rate * np.arange(1, blocks + 1)
    return np.concatenate([stream.process([end], length) for end in ends])


def test_a_stream_gives_the_friction_under_the_finger():
    s = given_settings()
    stream = ElectrovibrationStream(ridges(), s, rate=48_000, level=PHYSICAL)
    x = felt(Signal(streamed(stream, 60, 100), 48_000, "V"), s)[4800:-1000]
    assert line(x, 60, 48_000) == pytest.approx(0.04, rel=0.05)


def test_a_lost_finger_takes_the_voltage_to_zero():
    s = given_settings(watchdog_s=0.02, release_s=0.01)
    stream = ElectrovibrationStream(ridges(), s, rate=48_000, level=PHYSICAL)
    assert np.abs(streamed(stream, 50, 20)).max() > 50
    held = np.concatenate([stream.process(None, 240) for _ in range(4)])
    assert np.abs(held).max() > 50
    gone = np.concatenate([stream.process([np.nan], 240) for _ in range(4)])
    assert not gone[-400:].any()
    back = streamed(stream, 50, 4, start=5)
    assert np.abs(back).max() > 50


def test_a_lifted_finger_is_held_and_a_stop_is_final():
    s = given_settings(output="envelope")
    stream = ElectrovibrationStream(ridges(), s, rate=8000, level=PHYSICAL)
    before = streamed(stream, 50, 20, length=40)[-1]
    lifted = np.concatenate([stream.process(None, 40, contact=False) for _ in range(40)])
    np.testing.assert_allclose(lifted, before, rtol=1e-5)
    last = stream.stop()
    assert last[-1] == 0
    assert np.all(np.diff(last) <= 0)
    assert not streamed(stream, 50, 3, length=40).any()


@settings(max_examples=12, deadline=None)
@given(
    places=st.lists(
        st.one_of(st.none(), st.floats(-1e4, 1e4), st.just(float("nan")), st.just(float("inf"))),
        min_size=1,
        max_size=12,
    ),
    contact=st.booleans(),
    slew=st.floats(1e4, 1e7),
)
def test_whatever_comes_the_stream_keeps_limit_and_slew(places, contact, slew):
    s = given_settings(output="envelope", slew_v_per_s=slew, over="clip", perceptual_gain=5, release_s=0.1)
    stream = ElectrovibrationStream(ridges(length_mm=5), s, rate=8000, level=PHYSICAL)
    out = np.concatenate([[0.0], *(stream.process(place, 40, contact=contact) for place in places)])
    assert np.isfinite(out).all()
    assert 0 <= out.min() <= out.max() <= s.peak_v
    assert np.abs(np.diff(out)).max() <= slew / 8000 + s.v_max / (0.1 * 8000) + 1e-3
