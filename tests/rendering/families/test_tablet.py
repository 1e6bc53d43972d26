"""Strings that pull a finger: geometry, forces, tension."""

import numpy as np
import pytest
from hypothesis import given, settings, strategies as st
from scipy.optimize import linprog

from tactogram.errors import ParameterError, UnitError
from tactogram.rendering.displays.catalogue import MotionBlock, open_display
from tactogram.rendering.drive.fit import fit
from tactogram.rendering.families.tablet import (
    CORNERS,
    Settings,
    TabletStream,
    directions,
    drive,
    slackless,
)
from tactogram.rendering.level import parse_level
from tactogram.signal import Signal

T = np.arange(2000) / 1000


def vibration(unit="m/s^2"):
    x = np.sin(2 * np.pi * 40 * T)
    y = 0.5 * np.sin(2 * np.pi * 70 * T)
    z = 2.0 * np.sin(2 * np.pi * 110 * T)
    return Signal(np.stack([x, y, z]), 1000, unit)


def force(display, signal, level, **options):
    """Return the force on the finger, N, (x and y, time), and the tensions, from the family alone."""
    tensions, facts = drive(signal, display.settings, display=display, level=parse_level(level), **options)
    return directions(display.settings) @ tensions.samples, tensions.samples, facts


@settings(max_examples=30)
@given(st.floats(0.03, 0.97), st.floats(0.03, 0.97))
def test_a_balance_exists_wherever_the_finger_is(u, v):
    s = Settings(finger_mm=(200 * u, 150 * v))
    balance = slackless(s)
    np.testing.assert_allclose(directions(s) @ balance, 0, atol=1e-9)
    assert balance.min() > 0
    assert balance.sum() == pytest.approx(1)
    found = linprog(  # the least tension, as large as possible
        [0.0] * 4 + [-1.0],
        A_ub=np.column_stack([-np.eye(4), np.ones(4)]),
        b_ub=np.zeros(4),
        A_eq=np.vstack([np.column_stack([directions(s), np.zeros(2)]), [[1.0] * 4 + [0.0]]]),
        b_eq=[0.0, 0.0, 1.0],
    )
    assert balance.min() == pytest.approx(found.x[4], abs=1e-9)


@pytest.mark.parametrize("finger", [(100, 75), (40, 110), (180, 20)])
def test_the_strings_pull_with_the_wanted_force_and_never_go_slack(finger):
    display = open_display("string-tablet", changes={"tablet.finger_mm": list(finger), "limit": 50})
    plane = vibration().select("x", "y")
    pulled, tensions, facts = force(display, plane, "gain=0.5")
    np.testing.assert_allclose(pulled[:, 300:-300], 0.5 * plane.samples[:, 300:-300], atol=5e-3)
    assert tensions.min() >= display.settings.pretension_n - 1e-6
    assert facts["net_force_error_n"] < 1e-9


def test_one_axis_pulls_along_the_stroke():
    display = open_display("string-tablet", changes={"tablet.along": [1, 1]})
    pulled, _, _ = force(display, vibration().select("x"), "gain=0.1")
    np.testing.assert_allclose(pulled[0], pulled[1], atol=1e-6)
    assert np.hypot(*pulled)[300:-300].max() == pytest.approx(0.1, rel=2e-2)


@pytest.mark.parametrize(("axes", "hz"), [("x", 40), ("y", 70), ("z", 110)])
def test_which_axis_is_rendered_can_be_chosen(axes, hz):
    rendered = fit(vibration(), open_display("string-tablet"), level=parse_level("peak=0.5"), axes=axes)
    right = rendered.signal.axis("upper-right")[200:-200].astype(np.float64)
    spectrum = np.abs(np.fft.rfft((right - right.mean()) * np.hanning(len(right))))
    assert np.argmax(spectrum) * 1000 / len(right) == pytest.approx(hz, abs=1)


def test_by_default_three_axes_become_one_by_dft321():
    rendered = fit(vibration(), open_display("string-tablet"), level=parse_level("peak=0.5"))
    assert rendered.source.axes == ("dft321",)
    assert any("DFT321" in line for line in rendered.report.scaled)


def test_strings_cannot_render_z_and_say_how_much_that_is():
    rendered = fit(vibration(), open_display("string-tablet"), level=parse_level("peak=0.5"), axes="channels")
    share = 100 * 2**2 / (1 + 0.5**2 + 2**2)
    line = next(text for text in rendered.report.unreachable if text.startswith("axis z"))
    assert f"{share:.3g} %" in line


def test_too_large_a_force_is_made_smaller_or_refused():
    display = open_display("string-tablet")
    _, tensions, facts = force(display, vibration().select("x"), "gain=100")
    assert tensions.max() == pytest.approx(display.limit, rel=1e-6)
    assert facts["limiting"] < 0.1
    strict = open_display("string-tablet", changes={"tablet.over": "refuse"})
    with pytest.raises(ParameterError, match="more than the limit of 3 N"):
        force(strict, vibration().select("x"), "gain=100")


def test_a_peak_uses_that_share_of_what_the_strings_can():
    display = open_display("string-tablet")
    full, _, _ = force(display, vibration().select("x"), "peak=1")
    half, _, _ = force(display, vibration().select("x"), "peak=0.5")
    np.testing.assert_allclose(half, 0.5 * full, atol=1e-6)


def test_an_acceleration_is_no_force_unless_the_mass_is_known():
    with pytest.raises(UnitError, match="moved_mass_kg, which string-tablet does not state"):
        fit(vibration(), open_display("string-tablet"), level=parse_level("physical"))
    display = open_display("string-tablet", changes={"tablet.moved_mass_kg": 0.02})
    pulled, _, _ = force(display, vibration().select("x"), "physical")
    assert pulled[0, 300:-300].max() == pytest.approx(0.02, rel=2e-2)
    newtons, _, _ = force(open_display("string-tablet"), vibration("N").select("y"), "physical")
    assert newtons[0, 300:-300].max() == pytest.approx(0.5, rel=2e-2)


def test_a_wrong_geometry_is_refused():
    with pytest.raises(ParameterError, match="finger_mm must lie inside"):
        open_display("string-tablet", changes={"tablet.finger_mm": [300, 20]})
    with pytest.raises(ParameterError, match="must be a direction"):
        open_display("string-tablet", changes={"tablet.along": [0, 0]})
    with pytest.raises(ParameterError, match="channels must be upper-left"):
        fit(
            vibration(),
            open_display("string-tablet", changes={"channels": ["x", "y"]}),
            level=parse_level("peak=1"),
        )
    with pytest.raises(ParameterError, match="leaves no room"):
        fit(
            vibration(),
            open_display("string-tablet", changes={"tablet.pretension_n": 5.0}),
            level=parse_level("peak=1"),
        )


def test_the_channels_are_the_corners_in_any_order():
    turned = open_display("string-tablet", changes={"channels": list(reversed(CORNERS))})
    usual = open_display("string-tablet")
    a, b = (fit(vibration(), d, level=parse_level("peak=0.5")).signal for d in (usual, turned))
    for name in CORNERS:
        np.testing.assert_array_equal(a.axis(name), b.axis(name))


def test_a_stream_pulls_with_the_wanted_force_wherever_the_finger_is():
    """A file of the same vibration pulls as strongly; no string goes slack on the way from edge to edge."""
    display = open_display("string-tablet", changes={"limit": 50})
    tone = vibration().select("x")
    _, facts = drive(tone, display.settings, display=display, level=parse_level("gain=0.5"))
    stream, motion, along = TabletStream(display, tone.unit, facts), MotionBlock(5), []
    motion.count = 5
    for begin in range(0, 2000, 5):
        t = T[begin : begin + 5]
        motion.x_mm[:] = 90 * np.sin(2 * np.pi * t)
        motion.y_mm[:] = 120 * np.cos(2 * np.pi * t)  # leaves the rectangle
        tensions = stream.process(tone.samples[:, begin : begin + 5], motion)
        finger = np.stack([100 + motion.x_mm, np.clip(75 + motion.y_mm, 3, 147)])
        pulled = np.einsum("ast,st->at", directions(display.settings, finger), tensions)
        assert display.settings.pretension_n - 1e-9 <= tensions.min() <= tensions.max() <= display.limit
        np.testing.assert_allclose(pulled[1], 0, atol=1e-9)
        along.append(pulled[0])
    # The causal edges of the band delay the tone and change it by at most 0.5 dB.
    assert np.concatenate(along)[1000:].std() == pytest.approx(0.5 / np.sqrt(2), rel=0.06)
    assert stream.limited == 0
