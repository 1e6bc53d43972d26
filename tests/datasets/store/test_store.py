"""What the store promises: what went in comes out, once each, whatever way it is read."""

import pickle

import numpy as np
import pytest
from tests.datasets.store.sample_recordings import FACTS, assert_same, recording

from tactogram.datasets import Recording, create_store, open_store
from tactogram.datasets.store.store import problems
from tactogram.errors import DataError, ParameterError
from tactogram.signal import Image, Signal


def test_what_goes_in_comes_out(tmp_path):
    picture = Image(np.random.default_rng(0).integers(0, 256, (8, 9, 3), dtype=np.uint8), 0.25)
    full = recording(
        1,
        speed_mm_s=40,
        force_n=0.5,
        direction_deg=135.0,
        contactor="pen",
        session="2024-01",
        subject="s1",
        ratings={"rough": 6.0},
        labels={"recording": "1", "group": "G1"},
        history=("cut", "unit from the file"),
        simulated=True,
        image=picture,
    )
    friction = Recording(
        streams={"friction": Signal(np.ones(7), 10.0, "1", domain="displacement")}, source="friction.csv"
    )
    recordings = [full, recording(2, axes=("z",)), friction, recording(3, material="jeans", image=picture)]

    store = create_store(tmp_path / "s", recordings, **FACTS)

    assert [info.id for info in store.index] == [r.id for r in recordings]
    assert len(store) == len(store.index) == 4
    for expected in recordings:
        assert_same(store.read(expected.id), expected)
    np.testing.assert_array_equal(store.image(full.id).pixels, picture.pixels)
    assert store.image(full.id).mm_per_pixel == 0.25
    assert store.image(friction.id) is None
    assert store.simulated
    assert store.streams["friction"].domain == "displacement"
    assert problems(store) == []


def test_a_flipped_bit_is_found(tmp_path):
    store = create_store(tmp_path / "s", [recording(i) for i in range(3)], **FACTS)
    shard = store.path / store.facts.shards[0].file
    content = bytearray(shard.read_bytes())
    content[len(content) // 2] ^= 1
    shard.write_bytes(content)
    [found] = problems(open_store(store.path))
    assert shard.name in found
    assert "sha256 differs" in found


def test_a_missing_shard_is_found(tmp_path):
    store = create_store(tmp_path / "s", [recording(1)], **FACTS)
    (store.path / store.facts.shards[0].file).unlink()
    assert "missing" in problems(open_store(store.path))[0]
    with pytest.raises(DataError, match="missing; import the data again"):
        next(iter(open_store(store.path).index))


def test_unknown_names_are_refused(tmp_path):
    store = create_store(tmp_path / "s", [recording(1)], **FACTS)
    id = recording(1).id
    with pytest.raises(ParameterError, match="recording must be one of"):
        store.read("0" * 16)
    with pytest.raises(ParameterError, match="must be one of acceleration, force"):
        store.signal(id, "sound")
    with pytest.raises(ParameterError, match="samples must lie in 0 to 200"):
        store.signal(id, "acceleration", start=200)


def test_a_store_can_be_sent_to_another_process(tmp_path):
    store = create_store(tmp_path / "s", [recording(1)], **FACTS)
    assert pickle.loads(pickle.dumps(store)).sha256 == store.sha256  # noqa: S301
