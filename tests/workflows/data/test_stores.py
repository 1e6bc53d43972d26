"""Stores on an object store: an S3-like server (moto, in an environment of its own) on loopback."""

import json
import pickle
import urllib.request

import numpy as np
import pyarrow.parquet as pq
import pytest
from lightning_fabric.plugins.environments.lightning import find_free_network_port
from tests.object_store import object_store

from tactogram.cli import main
from tactogram.datasets import Recording, add_recordings, create_store, open_store
from tactogram.datasets.ratings.ratings import Ratings, Scale
from tactogram.datasets.store import remote as module, shards
from tactogram.datasets.store.remote import BlockReader, location
from tactogram.datasets.store.store import problems
from tactogram.datasets.store.writing import copy_store
from tactogram.errors import DataError, ParameterError
from tactogram.signal import Image, Signal
from tactogram.signal.io import write_signal
from tactogram.workflows.data.stores import add_signal, export_store, import_store
from tactogram.workflows.training.loaded_run import load_run
from tactogram.workflows.training.train import train


@pytest.fixture(scope="module", autouse=True)
def server():
    """Run the server, and yield its address."""
    with object_store() as address:
        yield address


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
        patch.setattr(shards, "GROUP_ROWS", 4)
        patch.setattr(shards, "SHARD_ROWS", 10)
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
    assert copy_store(held.path, "s3://bucket/held").path == "s3://bucket/held"  # is there already
    assert {path.name for path in tmp_path.iterdir()} == {"back"}


def test_a_window_is_read_without_the_rest_of_its_shard(held, remote, monkeypatch):
    monkeypatch.setattr(module, "BLOCK_BYTES", 64)
    asked = []
    fetched = BlockReader._fetched
    monkeypatch.setattr(
        BlockReader,
        "_fetched",
        lambda self, path, number: asked.append((path.path, number)) or fetched(self, path, number),
    )
    store = open_store("s3://bucket/held")
    id = next(info.id for info in store.index if info.speed_mm_s == 20)
    assert asked == []
    for _ in range(2):  # the second time from the blocks that were kept
        window = store.signal(id, "acceleration", start=100, stop=150)
        expected = held.read(id).streams["acceleration"].samples[:, 100:150]
        np.testing.assert_array_equal(window.samples, expected)
    assert 3 * 200 / 64 <= len(asked) == len(set(asked)) <= 3 * (200 / 64 + 2)


def test_it_becomes_a_data_set_of_the_hub(remote, tmp_path):
    facts = export_store("s3://bucket/held", out=tmp_path / "hub")
    assert (facts["recordings"], facts["photographs"]) == (40, 2)
    ids = pq.read_table(tmp_path / "hub" / "data")["id"].to_pylist()
    assert ids == [info.id for info in remote.index]


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


def shown(capsys, *arguments):
    """Return the one line in which a command fails."""
    assert main(list(map(str, arguments))) == 1
    lines = capsys.readouterr().err.splitlines()
    return [line for line in lines if not line.startswith("copying:")].pop()


def test_what_is_wrong_is_said_in_one_line(held, remote, tmp_path, capsys, monkeypatch, server):
    assert "s3://none/x is not a store" in shown(capsys, "data", "info", "s3://none/x")
    assert "s3://none/x/" in shown(capsys, "data", "copy", held.path, "s3://none/x")
    assert "s3://bucket/x is not a store" in shown(capsys, "data", "info", "s3://bucket/x")
    with pytest.raises(ParameterError, match="stores are not changed: `tactogram data copy` it to a folder"):
        add_recordings(remote, [])
    with pytest.raises(ParameterError, match="out must be a folder.*`tactogram data copy`"):
        import_store("folder", tmp_path, "s3://bucket/imported")
    for run in (
        lambda: load_run("s3://bucket/run"),
        lambda: train("replay", held.path, out="s3://bucket/run"),
    ):
        with pytest.raises(ParameterError, match="a run must be in a folder, got s3://bucket/run"):
            run()
    with pytest.raises(ParameterError, match="a URL must hold no credentials"):
        open_store("s3://key:secret@bucket/held")
    with pytest.raises(ParameterError, match="not a URL of a store"):
        open_store("nothing://bucket/held")
    other = create_store(tmp_path / "other", recordings(2), name="n", licence="-")
    assert "holds something else" in shown(capsys, "data", "copy", other.path, "s3://bucket/held")
    _require_credentials(server, "0")
    try:
        assert "ACCESS_DENIED" in shown(capsys, "data", "info", "s3://bucket/held")
    finally:
        _require_credentials(server, "Infinity")
    monkeypatch.setenv("AWS_ENDPOINT_URL", f"http://127.0.0.1:{find_free_network_port()}")
    assert "check the address, the network and the credentials" in shown(
        capsys, "data", "info", "s3://bucket/held"
    )


def _require_credentials(server, after):
    head = {"Content-Type": "text/plain"}
    request = urllib.request.Request(f"{server}/moto-api/reset-auth", after.encode(), head, method="POST")
    urllib.request.urlopen(request).close()


def write(place, content):
    with place.system.open_output_stream(place.path) as out:
        out.write(bytes(content))


def test_damage_is_found_by_its_hash(held, capsys, tmp_path):
    copy_store(held.path, "s3://bucket/damaged")
    place = location("s3://bucket/damaged")
    shard = place / held.facts.shards[1].file
    content = bytearray(shard.read_bytes())
    content[-2000] ^= 1
    write(shard, content)
    assert main(["data", "check", "s3://bucket/damaged", "--json"]) == 1
    assert (
        "changed since it was written (sha256 differs)" in json.loads(capsys.readouterr().out)["problems"][0]
    )
    with pytest.raises(DataError, match="wrong hash: changed since it was written"):
        copy_store("s3://bucket/damaged", tmp_path / "copy")
    assert not list(tmp_path.iterdir())


@pytest.mark.parametrize("damage", [b"", b"\x93NUMPY\x01\x00", lambda raw: raw[:-3] + b"\x07" + raw[-2:]])
def test_a_damaged_list_of_ids_is_made_anew_from_the_shards(held, capsys, tmp_path, caplog, damage):
    url = f"s3://bucket/{tmp_path.name}"
    copy_store(held.path, url)
    ids = location(url) / held.facts.ids
    write(ids, damage(ids.read_bytes()) if callable(damage) else damage)
    opened = open_store(url)
    assert "the shards are read instead" in caplog.text
    assert [opened.place(info.id) for info in held.index] == list(range(len(held)))
    assert main(["data", "check", url, "--json"]) == 1
    assert "is not the list of ids" in json.loads(capsys.readouterr().out)["problems"][0]


def test_what_is_added_stays_simulated(texture, tmp_path):
    real = Recording(streams={"acceleration": texture("cork", 1)}, material="cork")
    create_store(tmp_path / "store", [real], name="real", licence="made in a test")
    write_signal(tmp_path / "made.wav", texture("foam", 2), metadata={"simulated": "true"})
    assert not open_store(tmp_path / "store").simulated
    with pytest.raises(ParameterError, match="speed_mm_s must be a finite number"):
        add_signal(tmp_path / "store", tmp_path / "made.wav", material="foam", speed_mm_s=np.nan)
    with pytest.raises(ParameterError, match="force_n must be greater than or equal to 0, got -3"):
        add_signal(tmp_path / "store", tmp_path / "made.wav", material="foam", force_n=-3.0)
    added = add_signal(tmp_path / "store", tmp_path / "made.wav", material="foam")
    bigger = open_store(tmp_path / "store")
    assert bigger.info(added["id"]).simulated
    assert bigger.simulated


def test_a_store_that_fails_its_check_exits_1(recordings, tmp_path, capsys):
    create_store(tmp_path / "store", recordings(count=1), name="x", licence="made in a test")
    assert main(["data", "check", str(tmp_path / "store")]) == 0
    shard = next((tmp_path / "store").glob("shard-*.parquet"))
    shard.write_bytes(shard.read_bytes()[:-1] + b"\0")
    assert main(["data", "check", str(tmp_path / "store"), "--json"]) == 1
    said = capsys.readouterr()
    assert "Traceback" not in said.err
