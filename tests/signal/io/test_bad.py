"""Broken input: one line that names the file and the place, whatever the format."""

import re
import struct

import numpy as np
import pytest
import soundfile
from hypothesis import given, settings, strategies as st
from tests.signal.io.refused import refusal

from tactogram.errors import DataError
from tactogram.signal import Signal
from tactogram.signal.io import WRITABLE, read_file, read_metadata, read_signal, write_signal

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
        "description is damaged",
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
    "damaged description": ('# {"tactogram": 1, "rate": "x"}\nt,x\n1,2\n', "description is damaged"),
}


def wav(tmp_path, channels=1, subtype="FLOAT", name="a.wav"):
    path = tmp_path / name
    soundfile.write(path, np.zeros((100, channels)), 1000, subtype)
    return path


@pytest.mark.parametrize("problem", TABLES)
def test_a_bad_table_is_refused(tmp_path, problem):
    text, line = TABLES[problem]
    path = tmp_path / "a.csv"
    path.write_bytes(text if isinstance(text, bytes) else text.encode())
    assert re.search(line, refusal(path))


@pytest.mark.parametrize("suffix", [*WRITABLE, ".txt"])
def test_an_empty_file_is_refused(tmp_path, suffix):
    path = tmp_path / f"a{suffix}"
    path.touch()
    assert refusal(path) == "empty file"


@pytest.mark.parametrize("suffix", [".wav", ".flac", ".npz", ".xlsx"])
def test_a_text_under_another_name_is_refused(tmp_path, suffix):
    path = tmp_path / f"a{suffix}"
    path.write_text("hello, this is a text and nothing else\n" * 20)
    line = refusal(path)
    assert "not a" in line
    if suffix in (".wav", ".flac"):
        assert "at byte 0, got b'hell" in line


@pytest.mark.parametrize("suffix", [".wav", ".flac", ".npz", ".xlsx"])
@pytest.mark.parametrize("share", [0.02, 0.3, 0.9, 0.99])
def test_a_truncated_file_is_refused(tmp_path, suffix, share):
    whole = tmp_path / f"whole{suffix}"
    write_signal(whole, Signal(np.random.default_rng(0).normal(size=(3, 5000)), 1000, "N"))
    path = tmp_path / f"a{suffix}"
    raw = whole.read_bytes()
    path.write_bytes(raw[: int(share * len(raw))])
    assert refusal(path)


def test_a_rate_of_zero_is_refused(tmp_path):
    path = wav(tmp_path, subtype="PCM_16")
    raw = bytearray(path.read_bytes())
    raw[24:28] = struct.pack("<I", 0)
    path.write_bytes(raw)
    assert refusal(path) == "rate must be > 0 Hz, got 0 at byte 24"
    np.savez(tmp_path / "a.npz", x=np.zeros(9), rate=0.0)
    assert refusal(tmp_path / "a.npz", axes=["x"]) == "rate must be > 0 and finite, got 0"
    (tmp_path / "a.csv").write_text("1\n2\n")
    assert refusal(tmp_path / "a.csv", rate=0) == "rate must be greater than 0, got 0"


def test_a_missing_column_is_refused(tmp_path):
    path = tmp_path / "a.csv"
    path.write_text(ROWS)
    assert refusal(path, axes=["x", "w"]) == "no column 'w', there are time [s], x, y, z"
    assert refusal(path, time="clock") == "no column 'clock', there are time [s], x, y, z"
    assert refusal(path, axes=("v", "w")).startswith("expected 2 axes (v, w), got 3 (x, y, z)")


def test_no_file_is_no_file(tmp_path):
    for function in (read_signal, read_file, read_metadata):
        with pytest.raises(DataError, match="no such file"):
            function(tmp_path / "a.wav")
        (tmp_path / "b.wav").mkdir(exist_ok=True)
        with pytest.raises(DataError, match="is a folder"):
            function(tmp_path / "b.wav")


@pytest.mark.parametrize("suffix", WRITABLE)
@given(data=st.data())
@settings(deadline=None, max_examples=40)
def test_damage_anywhere_is_one_line_or_harmless(tmp_path_factory, suffix, data):
    path = tmp_path_factory.mktemp("damaged") / f"a{suffix}"
    write_signal(path, Signal(np.random.default_rng(0).normal(size=(2, 30)), 500, "N", ("a", "b")))
    raw = bytearray(path.read_bytes())
    # A share of the file, in 1e-5: a worksheet's length depends on the time of day in it.
    share = st.integers(0, 99_999)
    for _ in range(data.draw(st.integers(1, 4))):
        raw[data.draw(share) * len(raw) // 100_000] = data.draw(st.integers(0, 255))
    path.write_bytes(raw[: 1 + data.draw(share) * len(raw) // 100_000])
    for function in (read_file, read_metadata):
        try:
            function(path)
        except DataError as error:
            assert "\n" not in str(error)  # noqa: PT017
