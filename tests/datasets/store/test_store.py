"""What the store promises: what went in comes out, once each, whatever way it is read."""

import json
import os
import pickle
import tracemalloc
from dataclasses import fields, replace

import numpy as np
import pyarrow as pa
import pyarrow.parquet as pq
import pytest
from hypothesis import HealthCheck, given, settings, strategies as st

from tactogram.datasets import Recording, RecordingInfo, add_recordings, create_store, open_store
from tactogram.datasets.store import shards
from tactogram.datasets.store.store import problems
from tactogram.errors import DataError, ParameterError
from tactogram.signal import Image, Signal

FACTS = {"name": "test", "licence": "CC0-1.0"}


def recording(seed, *, material="cork", samples=200, axes=("x", "y", "z"), **changes):
    rng = np.random.default_rng(seed)
    acceleration = Signal(rng.standard_normal((len(axes), samples)), 1000.0, "m/s^2", axes)
    force = Signal(rng.standard_normal(samples // 10), 100.0, "N")
    values = {"source": f"{material}/{seed}.wav", "streams": {"acceleration": acceleration, "force": force}}
    return Recording(material=material, **(values | changes))


def assert_same(got, expected):
    for field in fields(RecordingInfo):
        assert getattr(got, field.name) == getattr(expected, field.name), field.name
    assert set(got.streams) == set(expected.streams)
    for name, signal in expected.streams.items():
        back = got.streams[name]
        assert (back.rate, back.unit, back.axes, back.domain) == (
            signal.rate,
            signal.unit,
            signal.axes,
            signal.domain,
        )
        np.testing.assert_array_equal(back.samples, signal.samples)


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


def test_a_photograph_that_many_share_is_stored_once(tmp_path):
    pixels = np.random.default_rng(0).integers(0, 256, (64, 64, 3), dtype=np.uint8)
    shared = (recording(i, image=Image(pixels.copy())) for i in range(20))
    store = create_store(tmp_path / "s", shared, **FACTS)
    store = add_recordings(store, [recording(99, image=Image(pixels))])
    [stored] = store.facts.images
    assert stored.rows == 1
    assert len({store.image_id(info.id) for info in store.index}) == 1


@settings(max_examples=25, deadline=None, suppress_health_check=[HealthCheck.function_scoped_fixture])
@given(
    lengths=st.lists(st.integers(1, 300), min_size=1, max_size=12),
    axes=st.lists(st.sampled_from([("x",), ("z",), ("x", "y"), ("z", "x")]), min_size=12, max_size=12),
    group_rows=st.integers(1, 5),
    shard_rows=st.integers(1, 7),
    data=st.data(),
)
def test_any_window_is_that_slice(tmp_path_factory, monkeypatch, lengths, axes, group_rows, shard_rows, data):
    monkeypatch.setattr(shards, "GROUP_ROWS", group_rows)
    monkeypatch.setattr(shards, "SHARD_ROWS", shard_rows)
    recordings = [
        Recording(streams={"a": Signal(np.random.default_rng(i).random((len(ax), n)), 10.0, "V", ax)})
        for i, (n, ax) in enumerate(zip(lengths, axes, strict=False))
    ]
    store = create_store(tmp_path_factory.mktemp("store") / "s", recordings, **FACTS)
    chosen = data.draw(st.sampled_from(recordings))
    start = data.draw(st.integers(0, len(chosen.streams["a"]) - 1))
    stop = data.draw(st.integers(start + 1, len(chosen.streams["a"])))
    got = store.signal(chosen.id, "a", start=start, stop=stop)
    assert got.axes == chosen.streams["a"].axes
    np.testing.assert_array_equal(got.samples, chosen.streams["a"].samples[:, start:stop])
    assert store.length(chosen.id, "a") == len(chosen.streams["a"])


def test_shards_are_plain_parquet(tmp_path):
    recordings = [recording(i, material=m, speed_mm_s=20.0 * i) for i, m in enumerate(["cork", "jeans"])]
    store = create_store(tmp_path / "s", recordings, **FACTS)
    [shard] = store.facts.shards
    table = pq.read_table(store.path / shard.file)
    assert table["material"].to_pylist() == ["cork", "jeans"]
    assert table["speed_mm_s"].to_pylist() == [0.0, 20.0]
    assert table["acceleration_rate"].to_pylist() == [1000.0, 1000.0]
    assert table.schema.field("acceleration_x").type == pa.list_(pa.float32())
    got = np.array(table["acceleration_y"][1].as_py(), np.float32)
    np.testing.assert_array_equal(got, recordings[1].streams["acceleration"].axis("y"))


def test_a_window_costs_memory_of_a_window(tmp_path):
    long = recording(0, samples=2_000_000, axes=("z",))
    store = create_store(tmp_path / "s", [long], **FACTS)
    store.length(long.id, "acceleration")
    tracemalloc.start()
    store.signal(long.id, "acceleration", start=1_000_000, stop=1_001_000)
    peak = tracemalloc.get_traced_memory()[1]
    tracemalloc.stop()
    assert peak < 200_000


def test_the_same_samples_are_one_recording_and_it_is_said(tmp_path):
    one = recording(1)
    again = replace(one, source="copy.wav")
    store = create_store(tmp_path / "s", [one, recording(2), again], **FACTS)
    assert len(store) == 2
    assert store.facts.duplicates == ({"id": one.id, "kept": "cork/1.wav", "dropped": "copy.wav"},)


def test_the_same_samples_under_two_names_are_refused(tmp_path):
    with pytest.raises(DataError, match=r"copy.wav: the same samples as cork/1.wav"):
        create_store(
            tmp_path / "s",
            [recording(1), replace(recording(1), material="jeans", source="copy.wav")],
            **FACTS,
        )
    assert list(tmp_path.iterdir()) == []


def test_the_hash_is_of_the_content_not_of_its_order(tmp_path, monkeypatch):
    recordings = [recording(i) for i in range(5)]
    first = create_store(tmp_path / "a", recordings, **FACTS)
    monkeypatch.setattr(shards, "SHARD_ROWS", 2)
    second = create_store(tmp_path / "b", recordings[::-1], **FACTS)
    other = create_store(tmp_path / "c", [replace(recordings[0], material="x"), *recordings[1:]], **FACTS)
    assert first.sha256 == second.sha256 != other.sha256


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


def test_nothing_is_left_when_a_recording_fails(tmp_path):
    def failing():
        yield recording(1)
        raise DataError("broken.wav: no samples")

    with pytest.raises(DataError, match="broken"):
        create_store(tmp_path / "s", failing(), **FACTS)
    assert list(tmp_path.iterdir()) == []


def test_other_units_are_refused(tmp_path):
    volts = Recording(streams={"acceleration": Signal(np.ones(3), 10.0, "V")}, source="v.wav")
    with pytest.raises(DataError, match=r"v.wav: stream 'acceleration' must be in m/s\^2"):
        create_store(tmp_path / "s", [recording(1), volts], **FACTS)


def test_an_empty_store_is_refused(tmp_path):
    with pytest.raises(DataError, match="no recordings"):
        create_store(tmp_path / "s", [], **FACTS)
    assert list(tmp_path.iterdir()) == []


def test_columns_of_one_name_are_refused(tmp_path):
    clash = Recording(
        streams={
            "a": Signal(np.ones((1, 3)), 10.0, "V", ("b_c",)),
            "a_b": Signal(np.ones((1, 3)), 10.0, "V", ("c",)),
        }
    )
    with pytest.raises(ParameterError, match="two columns would be called 'a_b_c'"):
        create_store(tmp_path / "s", [clash], **FACTS)


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
    with pytest.raises(DataError, match="'licence'"):
        open_store(store.path)


def test_a_flipped_bit_is_found(tmp_path):
    store = create_store(tmp_path / "s", [recording(i) for i in range(3)], **FACTS)
    shard = store.path / store.facts.shards[0].file
    content = bytearray(shard.read_bytes())
    content[len(content) // 2] ^= 1
    shard.write_bytes(content)
    [found] = problems(open_store(store.path))
    assert shard.name in found
    assert "sha256 differs" in found


def test_a_cut_shard_is_refused_when_read(tmp_path):
    store = create_store(tmp_path / "s", [recording(1)], **FACTS)
    shard = store.path / store.facts.shards[0].file
    shard.write_bytes(shard.read_bytes()[:-100])
    with pytest.raises(DataError, match=r"must be .* bytes, got"):
        open_store(store.path).read(recording(1).id)


def test_a_missing_shard_is_found(tmp_path):
    store = create_store(tmp_path / "s", [recording(1)], **FACTS)
    (store.path / store.facts.shards[0].file).unlink()
    assert "missing" in problems(open_store(store.path))[0]
    with pytest.raises(DataError, match="not readable"):
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


def test_an_existing_folder_is_not_touched(tmp_path):
    (tmp_path / "s").mkdir()
    (tmp_path / "s" / "mine.txt").write_text("x")
    with pytest.raises(DataError, match="must not exist"):
        create_store(tmp_path / "s", [recording(1)], **FACTS)
    assert os.listdir(tmp_path / "s") == ["mine.txt"]


def test_a_store_can_be_sent_to_another_process(tmp_path):
    store = create_store(tmp_path / "s", [recording(1)], **FACTS)
    assert pickle.loads(pickle.dumps(store)).sha256 == store.sha256  # noqa: S301
