"""Requested levels, and reduction to one axis."""

import numpy as np
import pytest

from tactogram.errors import ParameterError
from tactogram.rendering.drive.axes import combined
from tactogram.rendering.drive.report import FitReport, percent, signal_facts
from tactogram.rendering.level import Level, parse_level
from tactogram.signal import Signal
from tactogram.signal.filters import dft321


@pytest.mark.parametrize(
    ("text", "level"),
    [
        ("physical", Level("physical")),
        ("sensation", Level("sensation")),
        ("sensation=-3", Level("sensation", -3)),
        (" gain = 2.5 ", Level("gain", 2.5)),
        ("peak=0.8", Level("peak", 0.8)),
    ],
)
def test_a_level_is_read_and_written(text, level):
    assert parse_level(text) == level
    assert parse_level(str(level)) == level


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("loud", "level must be one of physical"),
        ("", "level must be one of physical"),
        ("gain", "write gain=2"),
        ("gain=0", "factor of 1e-12 to"),
        ("gain=x", "needs a number after ="),
        ("gain=", "needs a number after ="),
        ("gain=inf", "finite"),
        ("peak=1.5", "share in 0 to 1"),
        ("physical=2", "use gain=2"),
        ("sensation=nan", "finite"),
    ],
)
def test_a_level_that_is_none_is_refused(text, message):
    with pytest.raises(ParameterError, match=message):
        parse_level(text)


def three():
    return Signal(np.random.default_rng(0).normal(size=(3, 200)), 1000, "m/s^2")


def test_ways_of_making_one_axis_of_three():
    signal = three()
    np.testing.assert_array_equal(combined(signal, "y")[0].samples, signal.select("y").samples)
    np.testing.assert_array_equal(combined(signal, "dft321")[0].samples, dft321(signal).samples)
    np.testing.assert_allclose(combined(signal, "mean")[0].samples[0], signal.samples.mean(axis=0), atol=1e-6)
    assert combined(signal, "channels")[0] is signal
    assert combined(signal, "y")[1] == "axis y alone, x, z left out"


def test_two_axes_keep_their_energy():
    two = three().select("x", "y")
    one, words = combined(two, "dft321")
    assert np.sum(one.samples**2) == pytest.approx(np.sum(two.samples**2), rel=1e-3)
    assert "2 axes" in words


def test_what_cannot_be_combined_is_refused():
    with pytest.raises(ParameterError, match=r"of the signal's \(x, y, z\), got 'w'"):
        combined(three(), "w")
    four = Signal(np.zeros((4, 5)), 1000, "m/s^2", ("a", "b", "c", "d"))
    with pytest.raises(ParameterError, match="at most three axes"):
        combined(four, "dft321")


def test_a_report_with_something_that_is_no_json_is_a_defect():
    facts = signal_facts(three())
    report = FitReport("d", "linear", {"asked": "physical"}, facts, facts, facts={"x": float("nan")})
    with pytest.raises(ValueError, match="JSON compliant"):
        report.as_json()
    assert "clipped: nothing" in report.as_text()


@pytest.mark.parametrize(
    ("share", "words"),
    [(1.0, "100 %"), (0.999, "100 %"), (0.0423, "4.2 %"), (3.14e-4, "0.031 %"), (0.0, "0 %")],
)
def test_a_share_is_said_in_two_digits(share, words):
    assert percent(share) == words
