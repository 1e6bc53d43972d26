"""One shard per take becomes few: the same recordings, whatever happens meanwhile, whoever reads."""

import json
import os
import pickle
import shutil
import subprocess
import sys
from dataclasses import fields
from pathlib import Path

import numpy as np
import pyarrow.parquet as pq
import pytest

from tactogram.cli import main
from tactogram.datasets import Recording, RecordingInfo, add_ratings, add_recordings, create_store, open_store
from tactogram.datasets.ratings.ratings import SEVEN_POINT, Ratings
from tactogram.datasets.store import compacting, shard_writing
from tactogram.datasets.store import pending as unfinished
from tactogram.datasets.store.appending import append_recording, recover_store
from tactogram.datasets.store.compacting import compact
from tactogram.datasets.store.pending import host_name
from tactogram.datasets.store.store import problems
from tactogram.errors import DataError
from tactogram.signal import Image, Signal

FACTS = {"name": "takes", "licence": "CC0-1.0"}


def take(number, *, axes=("z",), **changes):
    rng = np.random.default_rng(number)
    streams = {"acceleration": Signal(rng.standard_normal((len(axes), 40 + number)), 1000.0, "m/s^2", axes)}
    if number % 3 == 2:
        streams["force"] = Signal(rng.standard_normal(9), 100.0, "N")
    return Recording(streams=streams, material=f"m{number % 2}", source=f"take {number}", **changes)


@pytest.fixture(name="taken")
def taken_fixture(tmp_path):
    """A store of some takes in as many shards of unlike columns, as a session leaves it; one with a photograph."""

    def make(count=6):
        picture = Image(np.random.default_rng(0).integers(0, 256, (4, 5, 3), dtype=np.uint8))
        takes = [
            take(0, image=picture),
            take(1, axes=("x", "y", "z"), session="a"),
            *map(take, range(2, count)),
        ]
        create_store(tmp_path / "s", takes[:1], **FACTS)
        for one in takes[1:]:
            add_recordings(open_store(tmp_path / "s"), [one])
        return open_store(tmp_path / "s"), takes

    return make


def assert_holds(store, takes):
    assert [info.id for info in store.index] == [one.id for one in takes]
    assert len(store) == len(takes)
    for one in takes:
        got = store.read(one.id)
        for field in fields(RecordingInfo):
            assert getattr(got, field.name) == getattr(one, field.name)
        assert set(got.streams) == set(one.streams)
        for name, signal in one.streams.items():
            assert got.streams[name].axes == signal.axes
            np.testing.assert_array_equal(got.streams[name].samples, signal.samples)


def files_of(store):
    return {shard.file for shard in store.facts.shards} | {store.facts.ids}


def test_many_takes_become_one_shard_and_stay_what_they_are(taken):
    store, takes = taken()
    found = compact(store.path)
    after = open_store(store.path)
    assert (found.recordings, found.shards_before, found.shards, found.rewritten) == (6, 6, 1, 6)
    assert found.bytes < found.bytes_before
    assert after.sha256 == store.sha256
    assert problems(after) == []
    assert_holds(after, takes)
    assert {p.name for p in store.path.iterdir()} == {
        "dataset.json",
        *files_of(after),
        *(image.file for image in after.facts.images),
    }
    table = pq.read_table(store.path / after.facts.shards[0].file)
    assert table["material"].to_pylist() == [one.material for one in takes]
    again = compact(store.path)
    assert (again.shards, again.rewritten) == (1, 0)


def test_full_shards_are_left_alone_and_the_order_is_kept(taken, monkeypatch):
    monkeypatch.setattr(shard_writing, "SHARD_ROWS", 4)
    monkeypatch.setattr(shard_writing, "GROUP_ROWS", 2)
    store, takes = taken(9)
    compact(store.path)
    first = open_store(store.path)
    assert [shard.rows for shard in first.facts.shards] == [4, 4, 1]
    more = [take(n) for n in range(20, 25)]
    for one in more:
        append_recording(store.path, one, **FACTS)
    found = compact(store.path)
    second = open_store(store.path)
    assert [shard.rows for shard in second.facts.shards] == [4, 4, 4, 2]
    assert second.facts.shards[:2] == first.facts.shards[:2]
    assert found.rewritten == 6
    assert_holds(second, [*takes, *more])
    assert problems(second) == []


def test_who_has_the_store_open_goes_on_reading_what_it_held(taken):
    store, takes = taken()
    idle, begun, sent = open_store(store.path), open_store(store.path), pickle.dumps(store)
    begun.signal(takes[2].id, "acceleration")
    walk = iter(begun.index)
    next(walk)
    compact(store.path)
    add_recordings(open_store(store.path), [take(30)])
    compact(store.path)
    for reader in (idle, begun):
        assert_holds(reader, takes)
        assert take(30).id not in reader
        assert reader.sha256 == store.sha256
        assert set(reader.photographs_by_material) == {"m0"}
    assert [info.id for info in walk] == [one.id for one in takes[1:]]
    assert_holds(pickle.loads(sent), [*takes, take(30)])  # noqa: S301 - another process opens it anew


def test_ratings_and_further_recordings_come_to_a_compacted_store(taken):
    store, takes = taken()
    compact(store.path)
    append_recording(store.path, take(40), **FACTS)
    rated = Ratings(("p1",), ("m0",), ("rough",), np.array([3.0]), SEVEN_POINT)
    after = add_ratings(open_store(store.path), rated)
    assert compact(store.path).shards == 1
    after = open_store(store.path)
    assert_holds(after, [*takes, take(40)])
    assert after.ratings is not None
    assert problems(after) == []


class Killed(BaseException):
    """The process is gone."""


def test_killed_at_any_step_nothing_is_lost(taken, monkeypatch, tmp_path):
    """Every change of a file may be the last: from then on the process changes nothing more, cleaning up included."""
    store, takes = taken(count=2)
    left = [10**6]

    def mortal(change):
        def step(path, *args, **kwargs):
            reads = change is opened and (args[:1] or (kwargs.get("mode", "r"),))[0] in ("r", "rb")
            left[0] -= not reads
            if left[0] < 0:
                raise Killed
            return change(path, *args, **kwargs)

        return step

    opened = Path.open
    for name in ("replace", "unlink", "touch", "open"):
        monkeypatch.setattr(Path, name, mortal(getattr(Path, name)))
    monkeypatch.setattr(os, "fsync", mortal(os.fsync))
    monkeypatch.setattr(compacting, "plain_parquet", mortal(compacting.plain_parquet))
    for kill in range(100):
        folder = tmp_path / f"killed-{kill}"
        shutil.copytree(store.path, folder)
        left[0] = kill
        try:
            compact(folder)
            break
        except Killed:
            left[0] = 10**6
        assert problems(open_store(folder)) == []
        after, _ = recover_store(folder)
        assert_holds(after, takes)
        assert after.sha256 == store.sha256
        names = {file.file for file in (*after.facts.shards, *after.facts.images)} | {
            "dataset.json",
            after.facts.ids,
        }
        assert names == {path.name for path in folder.iterdir()}
    assert kill > 20


def test_what_is_added_meanwhile_is_not_lost(taken, monkeypatch):
    store, takes = taken()
    check = compacting._check

    def slow(*args):
        append_recording(store.path, take(50), **FACTS)
        check(*args)

    monkeypatch.setattr(compacting, "_check", slow)
    with pytest.raises(DataError, match="changed by another process; nothing was changed here"):
        compact(store.path)
    after = open_store(store.path)
    assert_holds(after, [*takes, take(50)])
    assert len(list(store.path.glob("shard-*"))) == 7


def test_neither_replaces_while_the_other_is_at_work(taken, monkeypatch):
    store, takes = taken(count=3)
    note = store.path / "adding-elsewhere-7.txt"
    note.write_text("shard-x\n")
    with pytest.raises(DataError, match="something is being added to it \\(adding-elsewhere-7.txt\\)"):
        compact(store.path)
    assert files_of(open_store(store.path)) == files_of(store)
    note.unlink()
    monkeypatch.setattr(unfinished, "REPLACED_S", 0.0)
    with unfinished.replacing(store.path), pytest.raises(DataError, match="shards are being replaced"):
        add_recordings(store, [take(60)])
    assert_holds(add_recordings(store, [take(60)]), [*takes, take(60)])


@pytest.mark.parametrize("what", ["samples", "material"])
def test_a_damaged_shard_stops_it_and_nothing_changes(what, taken):
    """A damaged label, too: nothing but the hash of the old file shows it, and the new file has another."""
    store, takes = taken()
    path = store.path / store.facts.shards[4].file
    held = bytearray(path.read_bytes())
    samples = takes[4].streams["acceleration"].samples.tobytes()
    held[held.find({"samples": samples[:16], "material": b"m0"}[what])] ^= 1
    path.write_bytes(held)
    before = sorted(p.name for p in store.path.iterdir())
    with pytest.raises(DataError, match=r"shard-00004.*sha256 differs\); nothing was changed"):
        compact(store.path)
    assert sorted(p.name for p in store.path.iterdir()) == before


@pytest.mark.parametrize("wrong", [lambda shards: shards.pop(), lambda shards: shards[1].update(rows=2)])
def test_a_list_of_shards_that_is_not_the_stores_is_refused(wrong, taken):
    store, takes = taken(3)
    facts = json.loads((store.path / "dataset.json").read_text())
    wrong(facts["shards"])
    (store.path / "dataset.json").write_text(json.dumps(facts))
    with pytest.raises(DataError, match="is not the list of ids"):
        compact(store.path)
    if len(facts["shards"]) == 3:
        with pytest.raises(DataError, match="must have 2 rows, got 1"):
            open_store(store.path).info(takes[1].id)


def test_the_verb_prints_sizes_before_and_after(taken, capsys):
    store, _ = taken(2)
    assert main(["data", "compact", str(store.path)]) == 0
    out = capsys.readouterr().out
    assert "shards_before" in out
    assert store.sha256 in out
    assert main(["data", "check", str(store.path)]) == 0


def test_what_a_killed_process_noted_goes_when_the_next_one_adds(taken):
    store, takes = taken(count=2)
    gone = subprocess.run([sys.executable, "-c", "import os; print(os.getpid())"], stdout=-1, check=True)
    left = {
        f"adding-{host_name()}-{int(gone.stdout)}.txt": "shard-left.parquet\n",
        f"adding-{host_name()}-{os.getpid()}.txt": "shard-own.parquet\n",
        "adding-elsewhere-7.txt": "shard-theirs.parquet\n",
    }
    for name, shard in left.items():
        (store.path / name).write_text(shard)
        (store.path / shard.strip()).touch()
    assert_holds(append_recording(store.path, take(60), **FACTS), [*takes, take(60)])
    kept = {path.name for path in store.path.iterdir()}
    assert "shard-left.parquet" not in kept
    assert not any(name.endswith(f"-{int(gone.stdout)}.txt") for name in kept)
    assert {"shard-own.parquet", "shard-theirs.parquet", "adding-elsewhere-7.txt"} <= kept
