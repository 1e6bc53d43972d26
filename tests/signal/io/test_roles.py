"""Which columns are axes."""

import numpy as np
import pytest
from tests.signal.io.sample_files import written

from tactogram.signal.io import read_file, read_signal


def test_columns_are_chosen_by_name(tmp_path):
    text = "t [s],label,force [N],speed [mm/s]\n" + "\n".join(f"{i / 100},wood,{i},{2 * i}" for i in range(9))
    path = written(tmp_path, text)
    for name in ("force", "force [N]"):
        assert read_signal(path, axes=[name]).unit == "N"
    speed = read_signal(path, axes=["speed"])
    assert (speed.unit, speed.axes) == ("m/s", ("speed",))
    np.testing.assert_allclose(speed.samples[0], 2e-3 * np.arange(9))


def test_columns_that_name_no_axis_keep_their_names(tmp_path):
    for heading in ("t [s],left,right,back", "t [s],xx,yy,zz"):
        text = "\n".join([heading, *(f"{k / 100},{k % 3},{k % 5},{k % 7}" for k in range(9))])
        assert read_signal(written(tmp_path, text), unit="1").axes == tuple(heading.split(",")[1:])


def test_chosen_columns_are_axes_by_their_names(tmp_path):
    text = "\n".join(["t [s],acc_x,acc_y", *(f"{k / 100},1,{k}" for k in range(9))])
    for choice in ({"axes": ("acc_y",)}, {"axes": ("y",)}):
        assert read_signal(written(tmp_path, text), unit="g", **choice).axes == ("y",)


@pytest.mark.parametrize("cell", ["ok", ""])
def test_a_column_without_numbers_is_left_out_and_said(tmp_path, cell):
    text = "t [s],x [g],note\n" + "".join(f"{k / 100},{k},{cell}\n" for k in range(9))
    file = read_file(written(tmp_path, text))
    assert file.signal.axes == ("x",)
    assert [column.role for column in file.columns] == ["time", "x", "ignored"]


def test_columns_are_reported_as_they_were_selected_and_renamed(tmp_path):
    path = written(tmp_path, "t [s],a [g],b [g]\n" + "".join(f"{k / 100},1,{k}\n" for k in range(9)))
    assert [column.role for column in read_file(path, axes=("b",)).columns] == ["time", "ignored", "b"]
    assert [column.role for column in read_file(path, axes=("x", "y")).columns] == ["time", "x", "y"]
