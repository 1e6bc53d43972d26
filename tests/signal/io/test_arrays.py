"""Arrays of NumPy."""

import io
import zipfile

import h5py
import numpy as np
import pytest
from tests.signal.io.sample_files import WAVE, XYZ, N, X, refusal

from tactogram.errors import DataError
from tactogram.signal.io import read_file, read_signal


def test_bad_arrays_are_refused(tmp_path):
    path = tmp_path / "a.npz"
    np.savez(path, x=np.array([object()], dtype=object))
    assert refusal(path).startswith("x.npy holds pickled objects")
    np.savez(path, x=np.array(["a"]))
    assert refusal(path).startswith("must hold numbers (axis, time) with at most 64 axes, got")
    np.savez(path, left=np.zeros(3), right=np.zeros(3))
    assert refusal(path, axes=["left", "w"]) == "no column 'w', there are left, right"
    np.savez(path, x=np.zeros((100, 65)))
    assert refusal(path, rate=10).endswith("got x is float64 of shape (100, 65)")
    np.savez(path, x=np.array([0, np.nan, 1]))
    assert refusal(path, rate=10) == "row 1, column 'x': expected a finite number, got nan"
    np.savez(path, x=np.zeros(3), t=np.array([0, 0.02, 0.01]))
    assert "time goes back by 0.01 s" in refusal(path)
    np.savez(path, x=np.zeros(0))
    assert refusal(path, rate=10).endswith("got no samples")


@pytest.mark.parametrize("values", [np.zeros(9, complex), np.array(["a"] * 9), np.zeros(9, "datetime64[s]")])
def test_a_rate_or_time_that_is_no_number_is_refused(tmp_path, values):
    path = tmp_path / "a.npz"
    np.savez(path, x=np.zeros(9), rate=values[0])
    assert refusal(path, axes=["x"]).startswith("no time column and no rate in the file")
    np.savez(path, x=np.zeros(9), time=values)
    assert refusal(path).startswith(("no time column and no rate in the file", "time stands still"))


def test_booleans_are_read_as_numbers(tmp_path):
    np.savez(tmp_path / "a.npz", x=np.array([True, False, True]))
    assert read_signal(tmp_path / "a.npz", rate=10).samples.tolist() == [[1, 0, 1]]


def test_an_array_that_claims_more_than_it_holds_is_refused(tmp_path):
    path = tmp_path / "a.npz"
    file = io.BytesIO()
    np.lib.format.write_array_header_1_0(file, {"descr": "<f8", "fortran_order": False, "shape": (10**12,)})
    with zipfile.ZipFile(path, "w") as archive:
        archive.writestr("x.npy", file.getvalue())
    assert refusal(path) == f"x.npy claims {8 * 10**12} bytes and holds {len(file.getvalue())}"


def test_npz_of_others(tmp_path):
    np.savez(tmp_path / "a.npz", pac=np.stack([X, X]), other=np.zeros(3), rate=2200.0)
    signal = read_signal(tmp_path / "a.npz", axes=["pac"])
    assert (signal.rate, len(signal.axes)) == (2200, 2)
    np.savez(tmp_path / "b.npz", t=np.arange(40) / 100, x=X, y=-X)
    signal = read_signal(tmp_path / "b.npz", axes=["x", "y"], unit="V")
    assert (signal.rate, signal.axes, signal.unit) == (100, ("x", "y"), "V")
    np.savez(tmp_path / "c.npz", X)
    assert len(read_signal(tmp_path / "c.npz", rate=10)) == 40


def test_stamps_of_an_npz_may_be_called_time_stamp(tmp_path):
    np.savez(tmp_path / "a.npz", time_stamp=np.arange(40) / 100, x=X)
    assert read_signal(tmp_path / "a.npz", unit="g").rate == pytest.approx(100)


def test_arrays_are_axes_by_their_names(tmp_path):
    np.savez(tmp_path / "a.npz", time_ms=np.arange(40.0), acc_x=X, acc_y=-X)
    file = read_file(tmp_path / "a.npz", unit="g")
    assert (file.signal.rate, file.signal.axes) == (pytest.approx(1000), ("x", "y"))
    assert [column.role for column in file.columns] == ["time", "x", "y"]
    np.savez(tmp_path / "b.npz", data=np.stack([X, 2 * X, 3 * X]), Fs=np.float64(500))
    file = read_file(tmp_path / "b.npz")
    assert (file.signal.rate, [column.role for column in file.columns]) == (
        500,
        ["x", "y", "z", "rate"],
    )


@pytest.mark.parametrize("suffix", [".h5", ".npz"])
def test_arrays_of_several_rates_are_streams(tmp_path, suffix):
    path = tmp_path / f"a{suffix}"
    arrays = {"force": WAVE, "fs": 100.0, "air/pressure": np.tile(WAVE, 10), "air/fs": 1000.0}
    if suffix == ".npz":
        np.savez(path, **arrays)
    else:
        with h5py.File(path, "w") as file:
            for name, values in arrays.items():
                file[name] = values
            file["force"].attrs["unit"] = "N"
            file["air/pressure"].attrs["unit"] = "Pa"
    file = read_file(path)
    assert file.signal.rate == 100
    assert {name: other.rate for name, other in file.others.items()} == {"pressure": 1000}


def test_several_arrays_that_may_be_the_signal_are_asked_about(tmp_path):
    np.savez(tmp_path / "a.npz", left=XYZ, right=XYZ, fs=500)
    with pytest.raises(DataError, match="which array. choose of left, right, e.g. `axes=left`"):
        read_signal(tmp_path / "a.npz")
    assert read_signal(tmp_path / "a.npz", axes=["right"]).axes == ("x", "y", "z")
    np.savez(tmp_path / "b.npz", one=WAVE, two=np.tile(WAVE, 2), fs=500)
    with pytest.raises(
        DataError, match="which columns, at rates of their own: two or one. choose, e.g. `axes=two`"
    ):
        read_signal(tmp_path / "b.npz")
    assert len(read_signal(tmp_path / "b.npz", axes=["two"])) == 2 * N


def test_what_is_no_column_is_named(tmp_path):
    np.savez(tmp_path / "a.npz", force=WAVE, fs=500, gain=2.0, cal=np.ones(4), frames=np.zeros((9, 9, 9)))
    [refused, single, *_] = read_file(tmp_path / "a.npz").notes
    assert refused == "left out: frames is float64 of shape (9, 9, 9)"
    assert single == "left out: gain, cal (single values)"
