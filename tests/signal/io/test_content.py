"""What a file states, and what is added to it."""

import numpy as np
import pytest
from tests.signal.io.sample_files import refusal, wav, written

from tactogram.signal import Signal
from tactogram.signal.io import read_file, read_signal, write_signal
from tactogram.signal.io.content import TableLayout


def test_a_layout_swaps_axes_and_sets_units(tmp_path):
    path = written(tmp_path, "clock,x,y\n" + "".join(f"{2 * k},1,{k}\n" for k in range(9)))
    values = {"columns": ("clock", "x", "y"), "time": "clock", "time_unit": "ms", "unit": "mV"}
    layout = TableLayout(**values, axes={"x": "y", "y": "x"})
    file = read_file(path, layouts=[TableLayout(columns=("other",)), layout])
    assert (file.signal.rate, file.signal.unit, file.signal.axes) == (pytest.approx(500), "V", ("x", "y"))
    np.testing.assert_allclose(file.signal.samples[0], 1e-3 * np.arange(9), rtol=1e-6)
    assert file.layout == layout


def test_stereo_where_one_axis_is_expected_is_refused(tmp_path):
    line = refusal(wav(tmp_path, channels=2), axes=("z",))
    assert line.startswith("expected 1 axis (z), got 2 (1, 2)")


def test_what_contradicts_the_file_is_refused(tmp_path):
    path = tmp_path / "a.wav"
    write_signal(path, Signal(np.ones(9), 333.3, "N"), subtype="PCM_16")
    assert refusal(path, unit="m/s^2").startswith("the file is in N, expected m/s^2")
    assert refusal(path, rate=1000).startswith("the file is at 333.3 Hz, expected 1000")
    assert refusal(path, full_scale=17).startswith("full scale is 1")
    assert refusal(wav(tmp_path, name="b.wav"), rate=500).startswith("the file is at 1000 Hz, expected 500")
    assert read_signal(path, unit="N", rate=333.3).unit == "N"


def test_a_table_whose_columns_were_changed_is_refused(tmp_path):
    path = tmp_path / "a.csv"
    write_signal(path, Signal(np.ones((3, 9)), 100, "N"))
    path.write_text(path.read_text().replace("y [N]", "w [N]"))
    assert refusal(path).startswith("described with axes x, y, z, its columns are x, w, z")
