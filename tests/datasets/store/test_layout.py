"""What a store's folder must hold."""

import json
from dataclasses import replace

import pytest
from tests.datasets.store.sample_recordings import FACTS, recording

from tactogram.datasets import create_store, open_store
from tactogram.datasets.store import shards
from tactogram.errors import DataError


def test_the_hash_is_of_the_content_not_of_its_order(tmp_path, monkeypatch):
    recordings = [recording(i) for i in range(5)]
    first = create_store(tmp_path / "a", recordings, **FACTS)
    monkeypatch.setattr(shards, "SHARD_ROWS", 2)
    second = create_store(tmp_path / "b", recordings[::-1], **FACTS)
    other = create_store(tmp_path / "c", [replace(recordings[0], material="x"), *recordings[1:]], **FACTS)
    assert first.sha256 == second.sha256 != other.sha256


@pytest.mark.parametrize("version", [0, 2, "1", None])
def test_another_version_is_refused_in_one_line(tmp_path, version):
    store = create_store(tmp_path / "s", [recording(1)], **FACTS)
    facts = store.path / "dataset.json"
    facts.write_text(json.dumps(json.loads(facts.read_text()) | {"version": version}))
    with pytest.raises(DataError, match="format version must be 1") as caught:
        open_store(store.path)
    assert "\n" not in str(caught.value)


@pytest.mark.parametrize(
    ("text", "says"),
    [
        ("", "not a JSON document"),
        ("[]", "not a store"),
        ('{"format": "x"}', "not a store"),
        (None, "data import"),
    ],
)
def test_what_is_no_store_is_refused(tmp_path, text, says):
    if text is not None:
        (tmp_path / "dataset.json").write_text(text)
    with pytest.raises(DataError, match=says):
        open_store(tmp_path)


def test_a_lacking_key_is_named(tmp_path):
    store = create_store(tmp_path / "s", [recording(1)], **FACTS)
    facts = store.path / "dataset.json"
    values = json.loads(facts.read_text())
    del values["licence"]
    facts.write_text(json.dumps(values))
    with pytest.raises(DataError, match="licence: is missing"):
        open_store(store.path)
