"""MAT files of MATLAB and LVM files of LabVIEW."""

import zlib

import numpy as np
import pytest
from scipy.io import savemat

from tactogram.errors import DataError
from tactogram.signal.io import read_columns, read_file, read_signal
from tactogram.signal.io.content import TableLayout

X = np.sin(np.arange(40))

HEAD = """LabVIEW Measurement\t
Writer_Version\t2
Separator\tTab
Decimal_Separator\t,
Multi_Headings\tNo
X_Columns\t{columns}
Time_Pref\tAbsolute
Date\t2026/05/04
***End_of_Header***\t
\t
Channels\t2\t\t
Samples\t40\t40\t
Y_Unit_Label\tVolts\tVolts\t
X_Dimension\tTime\tTime\t
X0\t0,0000000000000000E+0\t0,0000000000000000E+0\t
Delta_X\t{delta}\t{delta}\t
***End_of_Header***\t\t
"""


def written(
    tmp_path, columns="One", delta="5,000000E-4", heading="X_Value\tleft\tright\tComment", step=0.0005
):
    rows = [f"{step * k if columns == 'One' else ''}\t{x}\t{-x}\t" for k, x in enumerate(X)]
    if columns == "Multi":
        rows = [f"{step * k}\t{x}\t{step * k}\t{-x}\t" for k, x in enumerate(X)]
    text = HEAD.format(columns=columns, delta=delta) + "\n".join([heading, *rows]).replace(".", ",")
    (tmp_path / "a.lvm").write_text(text)
    return tmp_path / "a.lvm"


@pytest.mark.parametrize("columns", ["One", "No", "Multi"])
def test_lvm_with_any_time_columns(tmp_path, columns):
    heading = {"Multi": "X_Value\tleft\tX_Value\tright\tComment"}.get(
        columns, "X_Value\tleft\tright\tComment"
    )
    signal = read_signal(written(tmp_path, columns, heading=heading))
    assert (signal.rate, signal.unit, signal.axes) == (pytest.approx(2000, rel=1e-12), "V", ("left", "right"))
    np.testing.assert_allclose(signal.samples, [X, -X], atol=1e-6)


def test_time_stamps_of_an_lvm_decide_against_its_header(tmp_path):
    file = read_file(written(tmp_path, step=0.001))
    assert file.signal.rate == pytest.approx(1000)
    assert (file.columns[0].heading, file.columns[0].role) == ("X_Value [s]", "time")


def test_measurements_of_the_same_channels_are_parts_of_one_table(tmp_path):
    path = written(tmp_path)
    again = path.read_text().partition("***End_of_Header***\t\n")[2]
    path.write_text(path.read_text() + "\n\n" + again.replace("\t0,", "\t1,"))
    with pytest.raises(DataError, match="rows 58 to 69: time goes back by 0.0195 s.*`part=1`"):
        read_signal(path)
    assert len(read_signal(path, part=2)) == 40


def test_channels_of_an_lvm_without_times_may_have_rates_of_their_own(tmp_path):
    text = written(tmp_path, columns="No").read_text()
    text = text.replace("Delta_X\t5,000000E-4\t5", "Delta_X\t5,000000E-4\t1").replace(
        "Volts\tVolts", "Volts\tNewton"
    )
    (tmp_path / "a.lvm").write_text(text)
    file = read_file(tmp_path / "a.lvm")
    assert (file.stream, file.signal.rate, file.others["voltage"].rate) == ("force", 10000, 2000)


def test_an_lvm_with_a_layout(tmp_path):
    headings = ("X_Value [s]", "left [V]", "right [V]")
    assert tuple(use.heading for use in read_columns(written(tmp_path))) == headings
    layout = TableLayout(columns=headings, axes={"x": "right [V]"}, unit="g", time="X_Value [s]")
    signal = read_signal(tmp_path / "a.lvm", layouts=[layout])
    np.testing.assert_allclose(signal.samples, [-9.80665 * X], rtol=1e-6, atol=1e-6)


@pytest.mark.parametrize(
    ("change", "says"),
    [
        (lambda text: "LabView 7\n" + text, "must begin with 'LabVIEW Measurement', got 'LabView 7'"),
        (lambda text: text.partition("Channels")[0], "has no channels"),
        (lambda text: text.partition("\n0,0")[0], "no rows below the heading"),
        (
            lambda text: text.replace("\n0,001\t", "\n0,001\tx"),
            "row 21, column 'left .V.': expected a number, got 'x0.909",
        ),
        (lambda text: text + "\nChannels\t2\n***End_of_Header***\n", "row 59: no rows below this header"),
    ],
)
def test_a_bad_lvm_is_refused(tmp_path, change, says):
    path = written(tmp_path)
    path.write_text(change(path.read_text()))
    with pytest.raises(DataError, match=says):
        read_signal(path)


MAT = {
    "time and axes": {"t": np.arange(40.0) / 500, "ax": X, "ay": 2 * X, "az": 3 * X},
    "matrix of columns and rate": {
        "acc": np.outer(X, [1, 2, 3]),
        "Fs": 500.0,
        "note": "cork",
        "gain": [1.0, 2],
    },
    "matrix of rows and step": {"acc": np.outer([1, 2, 3], X), "dt": 0.002},
    "structure": {"run": {"time_ms": 2.0 * np.arange(40), "data": np.outer(X, [1, 2, 3]), "odd": np.ones(7)}},
}


@pytest.mark.parametrize("name", MAT)
@pytest.mark.parametrize("packed", [True, False])
def test_mat_variables_are_known_by_their_names(tmp_path, name, packed):
    content = dict(MAT[name])
    content.pop("gain", None)
    savemat(tmp_path / "a.mat", content, do_compression=packed)
    signal = read_signal(tmp_path / "a.mat", unit="g")
    assert (signal.rate, signal.axes) == (pytest.approx(500), ("x", "y", "z"))
    np.testing.assert_allclose(signal.samples, 9.80665 * np.outer([1, 2, 3], X), rtol=1e-5, atol=1e-5)


def test_of_several_variables_without_units_one_is_read_and_the_others_are_named(tmp_path):
    savemat(tmp_path / "a.mat", {"force": X, "speed": 2 * X, "fs": 100.0})
    file = read_file(tmp_path / "a.mat")
    assert (file.stream, file.signal.rate) == ("force", 100)
    assert "speed (velocity without unit)" in file.notes[0]
    layout = TableLayout(columns=("force", "speed", "fs"), axes={"push": "force"}, unit="N")
    file = read_file(tmp_path / "a.mat", layouts=[layout])
    assert (file.signal.rate, file.signal.unit, file.signal.axes) == (100, "N", ("push",))
    assert [column.role for column in file.columns] == ["push", "ignored", "rate"]


def bomb():
    """Return a MAT file of 10 KiB whose only variable claims 4 GiB."""
    body = zlib.compress(np.array([14, 2**32 - 16], "<u4").tobytes() + bytes(10**6))
    tag = np.array([15, len(body)], "<u4").tobytes()
    return b"MATLAB 5.0 MAT-file".ljust(124) + b"\0\1IM" + tag + body


@pytest.mark.parametrize(
    ("raw", "says"),
    [
        (b"", "empty file"),
        (b"MATLAB 7.3 MAT-file, Platform: x", "truncated or not an HDF5 file"),
        (b"no such thing" * 20, "truncated or not a MAT file"),
        (b"MATLAB 5.0 MAT-file".ljust(124) + b"\0\1IM" + bytes(20), "truncated or not a MAT file|no numeric"),
        (bomb(), "must unpack to at most 256 MiB, got 4096 MiB"),
    ],
)
def test_a_bad_mat_file_is_refused(tmp_path, raw, says):
    (tmp_path / "a.mat").write_bytes(raw)
    with pytest.raises(DataError, match=says):
        read_signal(tmp_path / "a.mat")


def test_a_mat_file_without_numbers_says_how_to_save_it(tmp_path):
    savemat(tmp_path / "a.mat", {"note": "cork", "rate": 100.0})
    with pytest.raises(DataError, match="no numeric variable; tables and timetables are objects"):
        read_signal(tmp_path / "a.mat")


MATRICES = {
    "(time, 4)": lambda t: {"data": np.stack([1000 * t, X, 2 * X, X + 3], axis=1)},
    "(4, time)": lambda t: {"data": np.stack([1000 * t, X, 2 * X, X + 3])},
}


@pytest.mark.parametrize("shape", MATRICES)
@pytest.mark.parametrize("write", [np.savez, lambda path, **arrays: savemat(path, arrays)])
def test_a_mapping_names_the_columns_of_a_matrix(tmp_path, shape, write):
    path = tmp_path / ("a.npz" if write is np.savez else "a.mat")
    write(path, **MATRICES[shape](np.arange(40) / 500))
    names = ("data:1", "data:2", "data:3", "data:4")
    assert next((use.heading, use.role) for use in read_columns(path)) == ("data:1", "time")
    values = {"columns": names, "axes": {"y": "data:2", "x": "data:3"}, "unit": "g"}
    file = read_file(path, layouts=[TableLayout(**values, time="data:1", time_unit="ms")])
    assert (file.signal.rate, file.signal.axes) == (pytest.approx(500), ("y", "x"))
    np.testing.assert_allclose(file.signal.samples, 9.80665 * np.stack([X, 2 * X]), atol=1e-4)
    assert [use.role for use in file.columns] == ["time", "y", "x", "ignored"]


@pytest.mark.parametrize("beside", [{"Fs": 500.0}, {"fs": np.array([[500]])}, {"t": np.arange(40) / 500}])
def test_a_matrix_beside_its_rate_or_times(tmp_path, beside):
    savemat(tmp_path / "a.mat", {"data": np.stack([X, 2 * X, 3 * X, X], axis=1)} | beside)
    file = read_file(tmp_path / "a.mat")
    assert (file.signal.rate, file.signal.axes) == (pytest.approx(500), ("1", "2", "3", "4"))
    layout = TableLayout(columns=[use.heading for use in file.columns], axes={"force": "data:4"}, unit="N")
    if "t" in beside:
        layout = layout.model_copy(update={"time": "t"})
    file = read_file(tmp_path / "a.mat", layouts=[layout])
    assert (file.signal.rate, file.signal.axes, file.signal.unit) == (pytest.approx(500), ("force",), "N")
