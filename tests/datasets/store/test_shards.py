"""Shards: plain Parquet, of which any window is read."""

import json
import tracemalloc

import numpy as np
import pyarrow as pa
import pyarrow.parquet as pq
import pytest
from hypothesis import HealthCheck, given, settings, strategies as st
from tests.datasets.store.sample_recordings import FACTS, recording

from tactogram.datasets import Recording, create_store, open_store
from tactogram.datasets.store import shards
from tactogram.errors import DataError, ParameterError
from tactogram.signal import Signal


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


def test_columns_of_one_name_are_refused(tmp_path):
    clash = Recording(
        streams={
            "a": Signal(np.ones((1, 3)), 10.0, "V", ("b_c",)),
            "a_b": Signal(np.ones((1, 3)), 10.0, "V", ("c",)),
        }
    )
    with pytest.raises(ParameterError, match="two columns would be called 'a_b_c'"):
        create_store(tmp_path / "s", [clash], **FACTS)


def test_a_cut_shard_is_refused_when_read(tmp_path):
    store = create_store(tmp_path / "s", [recording(1)], **FACTS)
    shard = store.path / store.facts.shards[0].file
    shard.write_bytes(shard.read_bytes()[:-100])
    with pytest.raises(DataError, match=r"must be .* bytes, got"):
        open_store(store.path).read(recording(1).id)


def test_a_damaged_shard_is_refused_in_one_line_or_read(tmp_path):
    """Flip bits anywhere in a shard: what reads it names the file, whatever its library stumbles over."""
    store = create_store(tmp_path / "s", [recording(n, samples=20) for n in range(4)], **FACTS)
    path = store.path / store.facts.shards[0].file
    whole, rng, said = path.read_bytes(), np.random.default_rng(0), []
    for _ in range(60):
        content = bytearray(whole)
        for place in len(whole) - 1 - rng.integers(0, len(whole), rng.integers(1, 4)):
            content[place] ^= 1 << rng.integers(8)
        path.write_bytes(content)
        try:
            for info in open_store(store.path).index:
                open_store(store.path).signal(info.id, "acceleration")
        except (DataError, ParameterError) as error:
            said.append(str(error))
    assert sum(str(path) in line for line in said) > 10
    assert not any("\n" in line for line in said)


def test_streams_and_shards_must_agree(tmp_path):
    store = create_store(tmp_path / "s", [recording(1)], **FACTS)
    facts = store.path / "dataset.json"
    values = json.loads(facts.read_text())
    values["streams"]["acceleration"]["axes"] = ["x"]
    facts.write_text(json.dumps(values))
    with pytest.raises(DataError, match=r"shard-00000.parquet: lacks the column acceleration_y"):
        open_store(store.path).signal(recording(1).id, "acceleration")
