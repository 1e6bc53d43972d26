"""MAT files of MATLAB."""

import zlib

import numpy as np
import pytest
from scipy.io import savemat
from tests.signal.io.sample_files import X

from tactogram.errors import DataError
from tactogram.signal.io import read_columns, read_file, read_signal
from tactogram.signal.io.content import TableLayout

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
