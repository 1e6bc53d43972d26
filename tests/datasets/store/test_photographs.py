"""Photographs of materials: stored once, split without leaks, decoded only when asked for."""

import hashlib
import json

import numpy as np
import pytest
from tests.datasets.store.sample_photographs import by_recording, examples, picture, recording, store_of

from tactogram.datasets import (
    add_recordings,
    create_store,
    open_store,
    split_photographs,
)
from tactogram.datasets.store import photographs as photograph_files
from tactogram.datasets.store.store import Store, problems
from tactogram.errors import DataError


def test_photographs_of_a_material_come_back(tmp_path):
    store = store_of(tmp_path, {"cork": 3, "tile": 0})
    keys = store.photographs_of("cork")
    assert len(keys) == 3
    assert store.photographs_of("tile") == store.photographs_of("none") == ()
    expected = {picture([n, *b"cork"]).pixels.tobytes() for n in range(3)}
    assert {store.photograph(key).pixels.tobytes() for key in keys} == expected
    assert all(store.photograph(key).mm_per_pixel == 0.1 for key in keys)
    assert all(store.photograph_size(key) == (96, 80) for key in keys)
    assert problems(store) == []


def test_a_recordings_own_image_is_one_of_its_materials_photographs(tmp_path):
    own = picture(7)
    store = store_of(tmp_path, {"cork": 2, "tile": 0}, images={"tile": own})
    assert len(store.photographs_of("cork")) == 2
    [key] = store.photographs_of("tile")
    np.testing.assert_array_equal(store.photograph(key).pixels, own.pixels)
    assert store.facts.images[0].rows == 3


def test_the_hash_says_what_is_shown_whatever_the_order(tmp_path):
    def store(name, shown):
        recordings = [recording("cork", 1), recording("tile", 1)]
        return create_store(tmp_path / name, recordings, name="t", licence="CC0-1.0", photographs=shown)

    one, two = picture(1), picture(2)
    hashes = [
        store(f"s{i}", shown).sha256
        for i, shown in enumerate(
            [
                [],
                [("cork", one)],
                [("tile", one)],
                [("cork", one), ("cork", two)],
                [("cork", two), ("cork", one), ("cork", one)],
            ]
        )
    ]
    assert hashes[3] == hashes[4]
    assert len(set(hashes)) == 4


def test_photographs_can_be_added_later_and_once(tmp_path):
    before = store_of(tmp_path, {"cork": 1})
    after = add_recordings(
        before, [], photographs=[("cork", picture(1)), ("felt", picture(2)), ("felt", picture(2))]
    )
    assert len(after.photographs_of("cork")) == 2
    assert len(after.photographs_of("felt")) == 1
    assert after.sha256 != before.sha256
    assert problems(after) == []
    again = add_recordings(after, [], photographs=[("cork", picture(1))])
    assert again.sha256 == after.sha256
    assert len(again.facts.images) == 2


def test_a_picture_of_two_materials_is_refused_and_nothing_is_left(tmp_path):
    shown = [("cork", picture(1)), ("tile", picture(1))]
    with pytest.raises(DataError, match=r"called 'tile' here and 'cork' there"):
        create_store(tmp_path / "s", [recording("cork", 1)], name="t", licence="CC0-1.0", photographs=shown)
    assert list(tmp_path.iterdir()) == []


def test_the_hash_of_a_store_without_photographs_is_that_of_its_recordings(tmp_path):
    store = store_of(tmp_path, {"cork": 0})
    ids = np.load(tmp_path / "s" / store.facts.ids)
    assert store.sha256 == hashlib.sha256(ids["id"].tobytes() + ids["facts"].tobytes()).hexdigest()


def test_a_photograph_moved_to_another_material_by_hand_is_noticed(tmp_path):
    store_of(tmp_path, {"cork": 1, "tile": 0})
    path = tmp_path / "s" / "dataset.json"
    values = json.loads(path.read_text())
    values["photographs"] = {"tile": values["photographs"]["cork"]}
    path.write_text(json.dumps(values))
    assert len(problems(open_store(tmp_path / "s"))) == 1


def test_only_so_many_photographs_are_kept_unpacked(tmp_path, monkeypatch):
    store = store_of(tmp_path, {"cork": 8})
    monkeypatch.setattr(photograph_files, "DECODED_BYTES", 3 * 96 * 80 * 3)
    keys = store.photographs_of("cork")
    for key in (*keys, keys[0]):
        store.photograph(key)
    assert len(store._photographs._decoded) == 3
    assert store.photograph(keys[0]) is store.photograph(keys[0])


def test_photographs_are_decoded_only_when_asked_for(tmp_path, monkeypatch):
    store = store_of(tmp_path, {"cork": 10})
    split = split_photographs(store, by_recording(store), seed=0)
    held = examples(store, split, "train")
    decoded = []
    real = Store.photograph
    monkeypatch.setattr(Store, "photograph", lambda self, key: decoded.append(key) or real(self, key))
    example = held[0]
    assert len(example.photographs) == 8
    assert decoded == []
    assert example.photographs[1:3][0].size == (96, 80)
    assert len(decoded) == 1
