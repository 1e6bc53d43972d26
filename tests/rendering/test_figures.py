"""Figures of a drive."""

import numpy as np
import pytest

from tactogram.rendering.displays.catalogue import open_display
from tactogram.rendering.drive.fit import fit
from tactogram.rendering.figures import drive_figure
from tactogram.rendering.level import parse_level
from tactogram.signal import Signal


def texture():
    return Signal(np.random.default_rng(0).normal(size=(3, 400)), 1000, "m/s^2")


@pytest.mark.parametrize("name", ["voice-coil", "string-tablet", "phone"])
def test_a_drive_is_drawn_with_its_limits_and_its_report(name):
    display = open_display(name)
    drive = fit(texture(), display, level=parse_level("peak=0.5"))
    figure = drive_figure(drive, display)
    sent = next(axes for axes in figure.axes if axes.get_ylabel().startswith("drive"))
    lines = [line.get_ydata() for line in sent.lines]
    assert {display.limit, display.floor} <= {float(y[0]) for y in lines if len(y) == 2}
    drawn = [y for y in lines if len(y) == len(drive.signal)]
    np.testing.assert_array_equal(drawn, drive.signal.samples)
    words = "\n".join(text.get_text() for part in figure.subfigs for text in part.texts)
    assert "DFT321 of 3 axes" in words
    assert "own level is lost" in words


def test_a_long_drive_is_drawn_as_its_range():
    display = open_display("ultrasonic")
    drive = fit(texture(), display, level=parse_level("peak=0.5"))
    figure = drive_figure(drive, display)
    sent = next(axes for axes in figure.axes if axes.get_ylabel().startswith("drive"))
    (shape,) = sent.collections
    top = max(path.vertices[:, 1].max() for path in shape.get_paths())
    assert top == pytest.approx(drive.signal.samples.max(), rel=0.01)
