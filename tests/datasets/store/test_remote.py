"""Addresses of stores on an object store, and their files read by blocks (on a file system in memory)."""

from pathlib import Path

import pyarrow as pa
import pyarrow.fs as fs
import pytest

from tactogram.datasets.store import remote as module
from tactogram.datasets.store.remote import BlockReader, RemotePath, arrow_place, is_remote, local, location
from tactogram.errors import DataError, ParameterError


@pytest.fixture
def folder():
    system, path = fs.FileSystem.from_uri("mock:///bucket")
    system.create_dir(path)
    with system.open_output_stream(f"{path}/a.bin") as file:
        file.write(bytes(range(100)))
    return RemotePath(system, path, "mock:///bucket", "?region=here")


def test_urls_are_remote_and_paths_are_not():
    assert [is_remote(path) for path in ("s3://a/b", "S3://a", "a/b", "c:/b", Path("s3://a"))] == [
        True,
        True,
        False,
        False,
        False,
    ]
    assert location("a/b") == local(Path("a/b")) == Path("a/b")
    assert arrow_place(Path("a/b"))[1] == str(Path("a/b"))


def test_an_address_keeps_its_options_behind_what_is_below_it():
    found = location("mock:///bucket/s/")
    assert (found.path.rpartition("/")[2], str(found)) == ("s", "mock:///bucket/s")
    below = RemotePath(found.system, "bucket", "s3://bucket", "?region=here") / "s" / "dataset.json"
    assert (below.path, str(below)) == ("bucket/s/dataset.json", "s3://bucket/s/dataset.json?region=here")
    assert is_remote(below)
    assert location(below) is below


@pytest.mark.parametrize(
    ("url", "says"),
    [
        ("s3://key:secret@bucket/s", "must hold no credentials"),
        ("nowhere://a/b", "nowhere://a/b: not a URL of a store"),
    ],
)
def test_what_is_no_address_is_refused(url, says):
    with pytest.raises(ParameterError, match=says) as caught:
        location(url)
    assert "secret" not in str(caught.value)


def test_a_remote_store_is_not_changed(folder):
    with pytest.raises(ParameterError, match="where stores are not changed"):
        local(folder)


def test_files_are_found_and_read(folder):
    file = folder / "a.bin"
    assert (file.is_file(), file.size(), file.read_bytes()) == (True, 100, bytes(range(100)))
    assert not folder.is_file()
    assert not (folder / "b.bin").is_file()
    with pytest.raises(FileNotFoundError):
        (folder / "b.bin").size()


def test_errors_name_the_url_and_what_to_check(folder):
    says = r"^mock:///bucket\?region=here: no route; check the address"
    with pytest.raises(DataError, match=says), module.errors(folder):
        raise pa.ArrowException("no route")


def test_blocks_are_fetched_once_and_joined(folder, monkeypatch):
    monkeypatch.setattr(module, "BLOCK_BYTES", 16)
    fetched, real = [], BlockReader._fetched

    def counted(self, path, number):
        fetched.append(number)
        return real(self, path, number)

    monkeypatch.setattr(BlockReader, "_fetched", counted)
    reader, file = BlockReader(), folder / "a.bin"
    assert reader.read(file, 10, 30) == bytes(range(10, 40))
    assert reader.read(file, 32, 16) == bytes(range(32, 48))
    assert reader.read(file, 90, 15) == bytes(range(90, 100))
    assert fetched == [0, 1, 2, 5, 6]
