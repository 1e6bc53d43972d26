"""Stores on an object store: an S3-like server (moto, in an environment of its own) on loopback."""

import gc
import json
import os
import pickle
import socket
import subprocess
import sys
import time
import urllib.request
from pathlib import Path

import numpy as np
import pyarrow.fs as fs
import pytest
from lightning_fabric.plugins.environments.lightning import find_free_network_port

from tactogram.cli.command import main
from tactogram.datasets import Recording, add_recordings, create_store, open_store
from tactogram.datasets.ratings.ratings import Ratings, Scale
from tactogram.datasets.store import shard_writing
from tactogram.datasets.store.copying import copy_store
from tactogram.datasets.store.remote import RangeReader, location
from tactogram.datasets.store.store import problems
from tactogram.errors import DataError, ParameterError, RunError, StoppedError
from tactogram.signal import Image, Signal
from tactogram.workflows.data.stores import import_store
from tactogram.workflows.evaluation.mixing_ladder import mixing_ladder
from tactogram.workflows.training.loaded_run import load_run
from tactogram.workflows.training.train import train

SERVER = Path(sys.prefix) / "s3" / "bin" / "moto_server"  # by `make install`


@pytest.fixture(scope="module", autouse=True)
def server():
    """Run the server, name it in the environment, make a bucket, and yield the server's address."""
    port = find_free_network_port()
    process = subprocess.Popen(
        [SERVER, "-H", "127.0.0.1", "-p", str(port)], stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL
    )
    with pytest.MonkeyPatch.context() as patch:
        patch.setenv("AWS_ACCESS_KEY_ID", "testing")
        patch.setenv("AWS_SECRET_ACCESS_KEY", "testing")
        patch.setenv("AWS_REGION", "us-east-1")
        patch.setenv("AWS_EC2_METADATA_DISABLED", "true")
        patch.setenv("AWS_ENDPOINT_URL", f"http://127.0.0.1:{port}")
        until = time.monotonic() + 60
        while not _answers(port) and time.monotonic() < until and process.poll() is None:
            time.sleep(0.05)
        try:
            options = {"endpoint_override": f"127.0.0.1:{port}", "scheme": "http"}
            fs.S3FileSystem(allow_bucket_creation=True, **options).create_dir("bucket")
            yield f"http://127.0.0.1:{port}"
        finally:
            process.terminate()
            process.wait()


def _answers(port):
    with socket.socket() as tried:
        return tried.connect_ex(("127.0.0.1", port)) == 0


def recordings(count=40):
    for number in range(count):
        rng = np.random.default_rng(number)
        streams = {"acceleration": Signal(rng.standard_normal((3, 300 + number)), 1000.0, "m/s^2")}
        if number % 3:  # other columns begin another shard, and some rows lack the stream
            streams["force"] = Signal(rng.standard_normal(30), 100.0, "N")
        yield Recording(
            streams=streams,
            material=("cork", "tile")[number % 2],
            speed_mm_s=float(number),
            labels={"recording": str(number)},
            source=str(number),
            image=Image(rng.integers(0, 256, (4, 5, 3), dtype=np.uint8)) if number == 7 else None,
        )


@pytest.fixture(scope="module")
def held(tmp_path_factory):
    """A store of several shards and row groups, with photographs and ratings."""
    rated = Ratings(
        ("a", "b"), ("cork", "tile"), ("rough", "rough"), np.array([1.0, 4.0]), Scale("1 to 5", 1, 5)
    )
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(shard_writing, "GROUP_ROWS", 4)
        patch.setattr(shard_writing, "SHARD_ROWS", 10)
        return create_store(
            tmp_path_factory.mktemp("held") / "store", recordings(), name="n", licence="-", ratings=rated,
            photographs=[("cork", Image(np.zeros((3, 3, 3), np.uint8)))],
        )  # fmt: skip


@pytest.fixture(scope="module")
def remote(held):
    return copy_store(held.path, "s3://bucket/held")


def assert_same(one, other):
    assert one.sha256 == other.sha256
    assert list(one.index) == list(other.index)
    for info in other.index:
        a, b = one.read(info.id), other.read(info.id)
        assert a.streams.keys() == b.streams.keys()
        for name, signal in b.streams.items():
            assert (a.streams[name].rate, a.streams[name].axes) == (signal.rate, signal.axes)
            np.testing.assert_array_equal(a.streams[name].samples, signal.samples)
        assert (a.image is None) == (b.image is None)
    assert one.ratings.sha256 == other.ratings.sha256
    assert one.photographs_by_material == other.photographs_by_material


def test_a_copy_is_the_store_and_comes_back(held, remote, tmp_path):
    assert len(held.facts.shards) > 3
    assert_same(remote, held)
    assert problems(remote) == []
    back = copy_store("s3://bucket/held", tmp_path / "back")
    assert_same(back, held)
    assert problems(back) == []
    assert back.facts.catalogue is not None
    assert copy_store(held.path, "s3://bucket/held").path == "s3://bucket/held"  # is there already
    assert {path.name for path in tmp_path.iterdir()} == {"back"}


def test_opening_and_searching_reads_no_shard_and_a_window_one_range_per_axis(remote, monkeypatch):
    asked = []
    opened, read = fs.S3FileSystem.open_input_file, RangeReader.read

    def noted(self, path, key, start, length):
        asked.append((path.path.rpartition("/")[2], length))
        return read(self, path, key, start, length)

    monkeypatch.setattr(RangeReader, "read", noted)
    monkeypatch.setattr(
        type(location("s3://bucket/held")),
        "open",
        lambda self: asked.append(self.path) or opened(self.system, self.path),
    )
    store = open_store("s3://bucket/held")
    id = next(info.id for info in store.index if info.speed_mm_s == 20)
    assert store.length(id, "acceleration") == 320
    assert all("shard-" not in str(each) for each in asked)
    asked.clear()
    window = store.signal(id, "acceleration", start=100, stop=150)
    assert [length for _, length in (each for each in asked if isinstance(each, tuple))] == [200, 200, 200]
    np.testing.assert_array_equal(window.samples, remote.read(id).streams["acceleration"].samples[:, 100:150])


def test_reading_in_order_reads_ahead():
    content = np.random.default_rng(0).bytes(2**19)

    class File:
        def __init__(self):
            self.asked = []

        def read_at(self, length, start):
            self.asked.append(length)
            return content[start : start + length]

    path, file, reader = location("s3://bucket/none"), File(), RangeReader()
    reader._files[path.path] = file
    for start in range(0, 2**18, 1000):
        assert reader.read(path, "x", start, 1000) == content[start : start + 1000]
    assert len(file.asked) < 8
    file.asked.clear()
    for start in (400_000, 10, 300_000):  # at random: nothing more than asked
        assert reader.read(path, "y", start, 100) == content[start : start + 100]
    assert file.asked == [100, 100, 100]
    assert reader.read(path, "y", 2**19 - 10, 100) == content[-10:]  # as a file that is cut short


def test_another_process_opens_it_by_its_url(remote):
    assert pickle.loads(pickle.dumps(remote)).path == "s3://bucket/held"  # noqa: S301


def test_a_training_reads_it_and_the_run_names_its_url(store, tiny, tmp_path):
    copy_store(store, "s3://bucket/textures")
    options = {"recipe": "tiny", "changes": {**tiny, "config.steps": 3}, "accelerator": "cpu"}
    runs = [
        train("stroke_cnn", data, out=tmp_path / name, **options)
        for name, data in {"remote": "s3://bucket/textures", "local": store}.items()
    ]
    assert runs[0].data["path"] == "s3://bucket/textures"
    assert runs[0].data["run_id"] == runs[1].data["run_id"]
    assert runs[0].metrics() == runs[1].metrics()


def test_a_run_goes_on_there_after_a_kill_and_is_used_from_there(store, tiny, tmp_path, capsys):
    url, changes = "s3://bucket/runs/first", {**tiny, "config.steps": 4, "training.checkpoint_every": 1}
    options = {"recipe": "tiny", "changes": changes, "accelerator": "cpu"}
    whole = train("stroke_cnn", store, out=tmp_path / "whole", **options)
    begun = location(url)
    with pytest.raises(StoppedError, match=f"--resume {url}"):
        train("stroke_cnn", store, out=url, stop=lambda: len(begun.files()) > 0, **options)
    assert "checkpoint.safetensors" in begun.files()
    with pytest.raises(RunError, match=f"{url}: contains a run, which has begun"):
        train("stroke_cnn", store, out=url, **options)
    assert main(["train", "--resume", url]) == 0
    assert f"run: {url}\n" in capsys.readouterr().out
    assert "checkpoint.safetensors" not in begun.files()

    again = load_run(url)
    assert again.run.name == "first"
    assert again.run.metrics() == whole.metrics()
    weights = "model.safetensors"
    assert (again.run.folder / weights).read_bytes() == (whole.folder / weights).read_bytes()
    copy = again.run.folder
    assert pickle.loads(pickle.dumps(again.run)).place == url  # noqa: S301
    del again
    gc.collect()
    assert not copy.exists()

    assert main(["evaluate", url]) == 0
    assert {"evaluation.json", "report.html"} <= begun.files().keys()
    assert main(["train", "--resume", "s3://bucket/nowhere"]) == 1
    assert capsys.readouterr().err.endswith(
        "s3://bucket/nowhere: not a run: expected a folder that `tactogram train` made, got none\n"
    )


def test_a_mix_of_a_run_there_is_sent_there(store):
    url = "s3://bucket/runs/mixed"
    train("ar_texture", store, out=url, recipe="tiny", accelerator="cpu")
    found = mixing_ladder(url, "cork", "tile", steps=3, signals=3, seconds=1.0)
    assert found["figure"].startswith(f"{url}/mixing/")
    shown = {file.removeprefix(f"{url}/") for file in (found["figure"], *found["sounds"])}
    assert shown <= location(url).files().keys()


def test_an_import_goes_there(tmp_path, server):
    for name in ("cork", "tile"):
        (tmp_path / "files" / name).mkdir(parents=True)
        np.savetxt(
            tmp_path / "files" / name / "1.csv",
            np.random.default_rng(ord(name[0])).random((50, 1)),
            header="z",
        )
    options = {"rate": 100.0, "unit": "m/s^2"}
    report = import_store("folder", tmp_path / "files", "s3://bucket/imported", options=options, workers=1)
    assert report["out"] == "s3://bucket/imported"
    assert len(open_store(f"s3://bucket/imported?endpoint_override={server}&region=us-east-1")) == 2


def shown(capsys, *arguments):
    """Return the one line in which a command fails."""
    assert main(list(map(str, arguments))) == 1
    lines = capsys.readouterr().err.splitlines()
    return [line for line in lines if not line.startswith("copying:")].pop()


def test_what_is_wrong_is_said_in_one_line(held, remote, tmp_path, capsys, monkeypatch, server):
    assert "there is no such bucket (none)" in shown(capsys, "data", "info", "s3://none/x")
    assert "there is no such bucket" in shown(capsys, "data", "copy", held.path, "s3://none/x")
    assert "s3://bucket/x is not a store" in shown(capsys, "data", "info", "s3://bucket/x")
    with pytest.raises(ParameterError, match="stores are not changed: `tactogram data copy` it to a folder"):
        add_recordings(remote, [])
    with pytest.raises(ParameterError, match="a URL must hold no credentials"):
        open_store("s3://key:secret@bucket/held")
    with pytest.raises(ParameterError, match="not a URL of a store"):
        open_store("nothing://bucket/held")
    other = create_store(tmp_path / "other", recordings(2), name="n", licence="-")
    assert "holds something else" in shown(capsys, "data", "copy", other.path, "s3://bucket/held")
    _require_credentials(server, "0")
    try:
        assert "s3://bucket/held/dataset.json: access is denied: give credentials" in shown(
            capsys, "data", "info", "s3://bucket/held"
        )
    finally:
        _require_credentials(server, "Infinity")
    monkeypatch.setenv("AWS_ENDPOINT_URL", f"http://127.0.0.1:{find_free_network_port()}")
    assert "the server is unreachable: check the network" in shown(capsys, "data", "info", "s3://bucket/held")


def _require_credentials(server, after):
    head = {"Content-Type": "text/plain"}
    request = urllib.request.Request(f"{server}/moto-api/reset-auth", after.encode(), head, method="POST")
    urllib.request.urlopen(request).close()


def test_damage_is_found_by_its_hash(held, capsys, tmp_path):
    copy_store(held.path, "s3://bucket/damaged")
    place = location("s3://bucket/damaged")
    shard = place / held.facts.shards[1].file
    content = bytearray(shard.read_bytes())
    content[-2000] ^= 1
    with shard.writing() as out:
        out.write(bytes(content))
    assert main(["data", "check", "s3://bucket/damaged", "--json"]) == 1
    assert (
        "changed since it was written (sha256 differs)" in json.loads(capsys.readouterr().out)["problems"][0]
    )
    with pytest.raises(DataError, match="wrong hash: changed since it was written"):
        copy_store("s3://bucket/damaged", tmp_path / "copy")
    assert not list(tmp_path.iterdir())
    ids = place / held.facts.ids
    content = bytearray(ids.read_bytes())
    content[-30] ^= 1
    with ids.writing() as out:
        out.write(bytes(content))
    with pytest.raises(DataError, match=r"ids-.*npy: wrong hash: not the list of ids that was written"):
        open_store("s3://bucket/damaged")


def test_adding_drops_the_catalogue(held, tmp_path):
    copied = copy_store(held.path, tmp_path / "copy")
    assert copied.facts.catalogue is not None
    added = add_recordings(copied, list(recordings(42))[40:])
    assert added.facts.catalogue is None
    assert not list((tmp_path / "copy").glob("catalogue-*"))
    assert (len(added), problems(added)) == (42, [])


def test_a_shard_of_a_catalogue_is_compared_in_size(held):
    copy_store(held.path, "s3://bucket/short")
    place = location("s3://bucket/short")
    stored = open_store("s3://bucket/short").facts.catalogue
    with (place / stored.file).writing() as out:
        out.write(b"PAR1")
    store = open_store("s3://bucket/short")
    with pytest.raises(DataError, match=f"must be {stored.bytes} bytes, got 4; import the data again"):
        list(store.index)
    assert os.fspath(held.path)
