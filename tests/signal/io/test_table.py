"""Table."""

import numpy as np
import pytest

from tactogram.signal import Signal
from tactogram.signal.io import read_file, write_signal


def noise(axes=3, length=200, rate=333.3, unit="m/s^2", level=20.0, **kind):
    samples = level * np.random.default_rng(axes).normal(size=(axes, length))
    return Signal(samples, rate, unit, tuple(f"axis {i}" for i in range(axes)), **kind)


def test_csv_has_time_and_units_in_its_heading(tmp_path):
    write_signal(tmp_path / "a.csv", Signal([[1, 2], [3, 4], [5, 6]], 1000, "m/s^2"))
    _, heading, first, second = (tmp_path / "a.csv").read_text().splitlines()
    assert heading == "time [s],x [m/s^2],y [m/s^2],z [m/s^2]"
    assert (first, second) == ("0,1,3,5", "0.001,2,4,6")


def test_csv_without_its_first_line_still_means_the_same(tmp_path):
    signal = noise(3, rate=333.3)
    write_signal(tmp_path / "a.csv", signal)
    text = (tmp_path / "a.csv").read_text().partition("\n")[2]
    (tmp_path / "b.csv").write_text(text)
    back = read_file(tmp_path / "b.csv")
    np.testing.assert_array_equal(back.signal.samples, signal.samples)
    assert back.signal.rate == pytest.approx(333.3, rel=1e-9)
    assert (back.signal.unit, back.signal.axes) == (signal.unit, signal.axes)
    assert back.timing.even
