"""Stores made and added to."""

import os
from concurrent.futures import ThreadPoolExecutor

import numpy as np
import pytest
from tests.datasets.store.sample_recordings import FACTS, assert_same, recording

from tactogram.datasets import Ratings, add_ratings, add_recordings, create_store, open_store
from tactogram.datasets.store.store import problems
from tactogram.datasets.store.writing import insert_recording
from tactogram.errors import DataError
from tactogram.signal.io.atomic import host_name


def test_recordings_can_be_added(tmp_path):
    first = [recording(i) for i in range(3)]
    store = create_store(tmp_path / "s", first, **FACTS)
    more = [recording(7, material="jeans"), first[0], recording(8, axes=("w",))]
    bigger = add_recordings(store, more)
    assert len(store) == 3
    assert [i.id for i in bigger.index] == [r.id for r in (*first, more[0], more[2])]
    for expected in (*first, more[0], more[2]):
        assert_same(bigger.read(expected.id), expected)
    assert len(bigger.facts.duplicates) == 1
    assert bigger.sha256 == create_store(tmp_path / "t", (*first, *more), **FACTS).sha256
    assert problems(bigger) == []


def test_adding_to_what_another_changed_is_refused(tmp_path):
    store = create_store(tmp_path / "s", [recording(1)], **FACTS)
    add_recordings(store, [recording(2)])
    before = sorted(os.listdir(store.path))
    with pytest.raises(DataError, match="changed by another process"):
        add_recordings(store, [recording(3)])
    assert sorted(os.listdir(store.path)) == before
    assert problems(open_store(store.path)) == []


def test_what_several_add_at_once_is_all_there(tmp_path):
    store = create_store(tmp_path / "s", [recording(0)], **FACTS)
    added = [recording(i) for i in range(1, 9)] * 2
    with ThreadPoolExecutor(4) as pool:
        done = list(pool.map(lambda each: insert_recording(store.path, each)[1], added))
    assert sum(done) == 8
    bigger = open_store(store.path)
    assert {info.id for info in bigger.index} == {store.index[0].id, *(each.id for each in added)}
    assert problems(bigger) == []


def test_what_fails_after_the_store_was_replaced_leaves_the_new_one(tmp_path, monkeypatch):
    store = create_store(tmp_path / "s", [recording(0)], **FACTS)

    def fails(*_):
        raise OSError("Input/output error")

    monkeypatch.setattr("tactogram.datasets.store.writer.to_disk", fails)
    with pytest.raises(OSError, match="Input/output"):
        insert_recording(store.path, recording(1))
    assert len(open_store(store.path)) == 2
    assert problems(open_store(store.path)) == []


def ratings(score):
    return Ratings(("a", "b"), ("cork", "cork"), ("rough", "rough"), np.array([1.0, score]))


@pytest.mark.parametrize("add", [insert_recording, None])
@pytest.mark.parametrize("kind", ["ids", "ratings"])
def test_a_folder_in_the_place_of_a_file_that_is_replaced_leaves_the_new_store(tmp_path, kind, add, caplog):
    store = create_store(tmp_path / "s", [recording(0, material="cork")], **FACTS, ratings=ratings(2.0))
    file = store.folder / {"ids": store.facts.ids, "ratings": store.facts.ratings.file}[kind]
    file.unlink()
    file.mkdir()
    store = open_store(store.path)
    if add:
        add(store.path, recording(1))
    add_ratings(open_store(store.path), ratings(5.0), replace=True)
    after = open_store(store.path)
    assert after.ratings.sha256 == ratings(5.0).sha256
    assert len(after) == 1 + bool(add)
    assert problems(after) == []
    assert ("the shards are read instead" in caplog.text) == (kind == "ids")
    assert not list(store.folder.glob("adding-*"))


def test_ratings_that_cannot_be_stored_leave_the_list_of_ids(tmp_path, monkeypatch):
    store = create_store(tmp_path / "s", [recording(0, material="cork")], **FACTS, ratings=ratings(2.0))
    before = sorted(os.listdir(store.path))
    with monkeypatch.context() as patch:
        patch.setattr("tactogram.datasets.store.layout.StoreInfo.text", lambda _: 1 / 0)
        with pytest.raises(ZeroDivisionError):
            add_ratings(store, ratings(2.0), replace=True)
    assert sorted(os.listdir(store.path)) == before
    assert problems(open_store(store.path)) == []


def test_what_a_killed_process_was_writing_is_removed(tmp_path):
    store = create_store(tmp_path / "s", [recording(0, material="cork")], **FACTS)
    part = f".ratings-00000-{host_name()[:16]}-99999999-00000000.part.parquet"
    (store.folder / part).touch()
    add_ratings(store, ratings(2.0))
    assert not (store.folder / part).exists()


def test_an_existing_folder_is_not_touched(tmp_path):
    (tmp_path / "s").mkdir()
    (tmp_path / "s" / "mine.txt").write_text("x")
    with pytest.raises(DataError, match="must not exist"):
        create_store(tmp_path / "s", [recording(1)], **FACTS)
    assert os.listdir(tmp_path / "s") == ["mine.txt"]
