"""Tables of text."""

import re

import numpy as np
import pytest
from tests.signal.io.sample_files import noise, refusal

from tactogram.signal import Signal
from tactogram.signal.io import read_file, write_signal


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


ROWS = "time [s],x,y,z\n0.00,1,2,3\n0.01,1,2,3\n0.02,1,2,3\n0.03,1,2,3\n"


TABLES = {
    "ragged": (ROWS.replace("0.02,1,2,3", "0.02,1,2"), "row 4: expected 4 columns, got 3"),
    "ragged, more": (ROWS.replace("0.02,1,2,3", "0.02,1,2,3,4"), "row 4: expected 4 columns, got 5"),
    "empty cell without time": ("x,y\n1,2\n,2\n", "row 3, column 'x': expected a finite number, got nan"),
    "word": (ROWS.replace("0.01,1,", "0.01,one,"), "row 3, column 'x': expected a number, got 'one'"),
    "nan without time": ("x,y\n1,2\nnan,2\n", "row 3, column 'x': expected a finite number, got nan"),
    "too large": (
        ROWS.replace("0.02,1,2,", "0.02,1,1e99,"),
        "row 4, column 'y': expected a finite number, got 1e\\+99",
    ),
    "time goes back": (
        ROWS.replace("0.03,", "0.015,"),
        "rows 4 to 5: time goes back by 0.005 s; .*choose one of the 2 parts",
    ),
    "time ages apart": ("t [s],x\n-1e308,1\n0,2\n1e308,3\n", "is the unit of time right\\?|without samples"),
    "time in an instant": ("t [s],x\n0,1\n1e-320,2\n2e-320,3\n", "is the unit of time right\\?"),
    "a rate beyond all": (
        '# {"tactogram": 1, "rate": 1e300, "unit": "1", "axes": ["x"], "domain": "time", "full_scale": null, '
        '"metadata": {}}\ntime [s],x [1]\n0,1\n1,2\n',
        r"rate must be 1e-06 to 1e\+09, got 1e\+300",
    ),
    "a rate of hundreds of digits": (
        '# {"tactogram": 1, "rate": 1' + "0" * 400 + ', "unit": "1", "axes": ["x"]}\ntime [s],x [1]\n0,1\n',
        "description: rate: must be a valid number",
    ),
    "time stands": (
        ROWS.replace("0.01,", "0.00,").replace("0.02,", "0.00,").replace("0.03,", "0.00,"),
        "repeat|still",
    ),
    "no time": ("x,y,z\n1,2,3\n1,2,3\n", "no time column and no rate"),
    "time without unit": (
        "t,x\n0,1\n1,2\n2,3\n",
        "time column 't' without unit goes in steps of 1 .*`time=t .ms.`",
    ),
    "only time": ("t [s]\n0\n1\n", "no column of samples besides the time"),
    "only a heading": ("time [s],x\n", "no rows of numbers below the heading"),
    "only comments": ("# nothing\n", "no rows"),
    "twice the same": ("t [s],x,x\n0,1,2\n1,2,3\n", "different names, got x, x"),
    "decimal comma in csv": (
        "a,b\n0,0,1,5\n0,1,2,5\n",
        "row 2: expected 2 columns, got 4; write decimal points",
    ),
    "a wrong calendar stamp": (
        "time,x\n2026-05-04T10:00:00,1\n2026-05-04T10:00:01,2\n"
        + "2026-05-04T10:00:02,3\n" * 49
        + "2026-05-04T25:00:00,3\n",
        "row 53, column 'time': expected a time stamp, got '2026-05-04T25:00:00'",
    ),
    "calendar stamps of two kinds": (
        "time,x\n2026-05-04T10:00:00,1\n2026-05-04T10:00:01Z,2\n",
        "row 3, column 'time': expected a time stamp like the first",
    ),
    "Python's underscore": (
        ROWS.replace("0.02,1,", "0.02,1_0,"),
        "row 4, column 'x': expected a number, got '1_0'",
    ),
    "binary": (b"PK\3\4" + bytes(50), "not a text file: zero byte at byte 4"),
    "later version": ('# {"tactogram": 99}\nx\n1\n', "description must be of version 1, got 99"),
    "damaged description": (
        '# {"tactogram": 1, "rate": "x"}\nt,x\n1,2\n',
        "description: rate: must be a valid number",
    ),
}


@pytest.mark.parametrize("problem", TABLES)
def test_a_bad_table_is_refused(tmp_path, problem):
    text, line = TABLES[problem]
    path = tmp_path / "a.csv"
    path.write_bytes(text if isinstance(text, bytes) else text.encode())
    assert re.search(line, refusal(path))


def test_a_missing_column_is_refused(tmp_path):
    path = tmp_path / "a.csv"
    path.write_text(ROWS)
    assert refusal(path, axes=["x", "w"]) == "no column 'w', there are time [s], x, y, z"
    assert refusal(path, time="clock") == "no column 'clock', there are time [s], x, y, z"
    assert refusal(path, axes=("v", "w")).startswith("expected 2 axes (v, w), got 3 (x, y, z)")
