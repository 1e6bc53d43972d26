"""Data sets of HDF5."""

import h5py
import numpy as np
import pytest
from tests.signal.io.sample_files import N, Y, hdf5

from tactogram.errors import DataError
from tactogram.signal.io import read_file, read_signal


def test_columns_of_an_hdf5_matrix_are_named_by_its_attributes(tmp_path):
    hdf5(tmp_path / "a.h5", columns=["force", "speed", "note"], unit=["N", "mm/s", "1"])
    file = read_file(tmp_path / "a.h5")
    assert (file.stream, file.signal.unit, file.signal.rate) == ("force", "N", 500)
    np.testing.assert_allclose(file.others["velocity"].samples[0], 1e-3 * Y, atol=1e-6)


def test_links_of_hdf5_to_other_files_are_not_followed(tmp_path):
    hdf5(tmp_path / "secret.h5")
    with h5py.File(tmp_path / "a.h5", "w") as file:
        file["stolen"] = h5py.ExternalLink("secret.h5", "run/acc")
        layout = h5py.VirtualLayout((N, 3), float)
        layout[:] = h5py.VirtualSource(tmp_path / "secret.h5", "run/acc", (N, 3))
        file.create_virtual_dataset("virtual", layout)
    with pytest.raises(DataError, match="no numbers"):
        read_signal(tmp_path / "a.h5")
