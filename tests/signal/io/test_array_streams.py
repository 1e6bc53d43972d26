"""Array streams."""

import h5py
import numpy as np
import pytest

from tactogram.errors import DataError
from tactogram.signal.io import read_file, read_signal

N = 200


X, Y, Z = np.sin(0.3 * np.arange(N)), np.cos(0.2 * np.arange(N)), 1 + 0.1 * np.sin(np.arange(N))


XYZ = np.stack([X, Y, Z])


@pytest.mark.parametrize("suffix", [".h5", ".npz"])
def test_arrays_of_several_rates_are_streams(tmp_path, suffix):
    path = tmp_path / f"a{suffix}"
    arrays = {"force": X, "fs": 100.0, "air/pressure": np.tile(X, 10), "air/fs": 1000.0}
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
    np.savez(tmp_path / "b.npz", one=X, two=np.tile(X, 2), fs=500)
    with pytest.raises(
        DataError, match="which columns, at rates of their own: two or one. choose, e.g. `axes=two`"
    ):
        read_signal(tmp_path / "b.npz")
    assert len(read_signal(tmp_path / "b.npz", axes=["two"])) == 2 * N


def test_what_is_no_column_is_named(tmp_path):
    np.savez(tmp_path / "a.npz", force=X, fs=500, gain=2.0, cal=np.ones(4), frames=np.zeros((9, 9, 9)))
    [refused, single, *_] = read_file(tmp_path / "a.npz").notes
    assert refused == "left out: frames is float64 of shape (9, 9, 9)"
    assert single == "left out: gain, cal (single values)"
