"""Archives and compressed tables."""

import bz2
import gzip
import re
import zipfile

import numpy as np
import pytest
from tests.signal.io.sample_files import WAVE, T, Y, Z, refusal

from tactogram.errors import DataError
from tactogram.signal.io import read_file, read_signal


@pytest.mark.parametrize("suffix", [".npz", ".xlsx"])
def test_an_archive_that_would_fill_the_memory_is_refused_unread(tmp_path, suffix, monkeypatch):
    monkeypatch.setattr("tactogram.signal.io.archives.SMALL", 1000)
    path = tmp_path / f"a{suffix}"
    with zipfile.ZipFile(path, "w", zipfile.ZIP_DEFLATED) as archive:
        archive.writestr("x.npy", bytes(2**20))
    assert re.match(r"must unpack to at most \d MiB in 10000 parts, got 1 MiB in 1; cut it", refusal(path))


def test_a_compressed_table_that_would_fill_the_memory_is_refused(tmp_path, monkeypatch):
    monkeypatch.setattr("tactogram.signal.io.archives.SMALL", 2**20)
    for name, compress in {"a.csv.gz": gzip.compress, "a.csv.bz2": bz2.compress}.items():
        (tmp_path / name).write_bytes(compress(b"1,2\n" * 2**20))
        with pytest.raises(DataError, match="must unpack to at most 1 MiB"):
            read_signal(tmp_path / name)


def test_the_tables_in_a_zip_are_streams_of_one_recording(tmp_path):
    rows = "\n".join(f"{t:.3f},{x:.5f},{y:.5f},{z:.5f}" for t, x, y, z in zip(T, WAVE, Y, Z, strict=True))
    with zipfile.ZipFile(tmp_path / "take.zip", "w") as archive:
        archive.writestr("Accelerometer.csv", f"seconds_elapsed,z,y,x\n{rows}\n")
        archive.writestr(
            "Gyroscope.csv", f"Time (s),Gyroscope x (rad/s),Gyroscope y (rad/s),Gyroscope z (rad/s)\n{rows}\n"
        )
        archive.writestr("meta/device.csv", "property,value\ndeviceModel,one\n")
    found = read_file(tmp_path / "take.zip")
    assert (found.stream, found.signal.axes, found.signal.unit) == ("acceleration", ("x", "y", "z"), "1")
    np.testing.assert_allclose(found.signal.samples[2], WAVE, atol=1e-5)  # the first column is z
    assert {name: (each.axes, each.unit) for name, each in found.others.items()} == {
        "angular_rate": (("x", "y", "z"), "rad/s")
    }
    with zipfile.ZipFile(tmp_path / "none.zip", "w") as archive:
        archive.writestr("a.pdf", "no table")
    with pytest.raises(DataError, match="holds no .csv, .tsv or .txt"):
        read_file(tmp_path / "none.zip")
