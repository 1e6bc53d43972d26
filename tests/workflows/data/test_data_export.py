"""Stores in the layouts of the Hub's data sets and of LeRobot: every sample is there, and what readers look for."""

import io
import json

import numpy as np
import pandas
import pyarrow.parquet as pq
import pytest
from huggingface_hub import DatasetCard
from PIL import Image as Pillow

from tactogram.cli import main
from tactogram.datasets import Recording, create_store, open_store
from tactogram.errors import ParameterError, RunError
from tactogram.signal import Image, Signal
from tactogram.workflows.data.export import export_store

FPS = 40


def multi_rate(number, *, force=True):
    """A simulated recording of acceleration at 1000 Hz and force at 30 Hz."""
    random = np.random.default_rng(number)
    seconds = 1 + 0.25 * number
    streams = {"acceleration": Signal(random.standard_normal((3, round(1000 * seconds))), 1000.0, "m/s^2")}
    if force:
        streams["force"] = Signal(random.random((1, round(30 * seconds))), 30.0, "N", ("z",))
    return Recording(
        streams=streams,
        image=Image(random.integers(0, 256, (8, 8, 3), np.uint8)) if number == 0 else None,
        material=("cork", "felt")[number % 2],
        speed_mm_s=100.0 + number,
        force_n=1.0,
        ratings={"rough": 5.0},
        labels={"take": str(number)},
        simulated=True,
    )


def stored(folder, recordings):
    create_store(folder, recordings, name="two rates", licence="CC-BY-4.0", simulated=True)
    return folder


@pytest.fixture(scope="module")
def two_rates(tmp_path_factory):
    return stored(tmp_path_factory.mktemp("data") / "store", [multi_rate(k) for k in range(3)])


@pytest.fixture(scope="module")
def lerobot(two_rates, tmp_path_factory):
    folder = tmp_path_factory.mktemp("out") / "lerobot"
    export_store(two_rates, to="lerobot", out=folder, fps=FPS)
    return folder


def meta(folder, name):
    return json.loads((folder / "meta" / f"{name}.json").read_text(encoding="utf-8"))


# -- the Hub's data sets -------------------------------------------------------------------------------------


def test_every_recording_is_a_row_of_one_schema(two_rates, tmp_path):
    store = open_store(stored(tmp_path / "store", [multi_rate(0), multi_rate(1, force=False)]))
    facts = export_store(store.path, to="hub", out=tmp_path / "hub")
    assert facts["recordings"] == 2
    files = sorted((tmp_path / "hub" / "data").glob("train-*.parquet"))
    tables = [pq.read_table(file) for file in files]
    assert all(table.schema == tables[0].schema for table in tables)
    rows = {row["id"]: row for table in tables for row in table.to_pylist()}
    for info in store.index:
        row = rows[info.id]
        np.testing.assert_array_equal(
            np.array(row["acceleration_y"], np.float32), store.signal(info.id, "acceleration").samples[1]
        )
        assert (row["force_z"] is None) == ("force" not in store.streams_of(info.id))
        assert row["ratings"] == [{"word": "rough", "score": 5.0}]
        assert row["labels"] == [{"name": "take", "value": info.labels["take"]}]


def test_photographs_are_pictures_with_their_materials(two_rates, tmp_path):
    export_store(two_rates, to="hub", out=tmp_path / "hub")
    table = pq.read_table(tmp_path / "hub" / "photographs" / "train.parquet")
    features = json.loads(table.schema.metadata[b"huggingface"])["info"]["features"]
    (row,) = table.to_pylist()
    assert features["image"] == {"_type": "Image"}
    assert row["materials"] == ["cork"]
    pixels = np.asarray(Pillow.open(io.BytesIO(row["image"]["bytes"])))
    np.testing.assert_array_equal(pixels, open_store(two_rates).photograph(row["key"]).pixels)


def test_the_card_names_files_licence_and_units(two_rates, tmp_path):
    export_store(two_rates, to="hub", out=tmp_path / "hub")
    card = DatasetCard.load(tmp_path / "hub" / "README.md")
    assert card.data.license == "cc-by-4.0"
    assert "simulated-data" in card.data.tags
    assert [each["config_name"] for each in card.data.configs] == ["default", "photographs"]
    for config in card.data.configs:
        for part in config["data_files"]:
            assert list((tmp_path / "hub").glob(part["path"]))
    assert "| force | N | time | z |" in card.text


# -- LeRobot -------------------------------------------------------------------------------------------------


def test_every_required_entry_is_there(lerobot):
    """Those that the reference implementation (lerobot, data set version 3.0) writes and reads."""
    info = meta(lerobot, "info")
    assert info["codebase_version"] == "v3.0"
    assert set(info) == {
        *("codebase_version", "robot_type", "total_episodes", "total_frames", "total_tasks", "chunks_size"),
        *(
            "data_files_size_in_mb",
            "video_files_size_in_mb",
            "fps",
            "splits",
            "data_path",
            "video_path",
            "features",
        ),
    }
    assert info["data_path"] == "data/chunk-{chunk_index:03d}/file-{file_index:03d}.parquet"
    assert info["splits"] == {"train": "0:3"}
    for name in ("timestamp", "frame_index", "episode_index", "index", "task_index"):
        kind = "float32" if name == "timestamp" else "int64"
        assert info["features"][name] == {"dtype": kind, "shape": [1], "names": None}
    for feature in info["features"].values():
        assert {"dtype", "shape", "names"} <= set(feature)
    assert not any("/" in name for name in info["features"])
    episodes = pq.read_table(lerobot / "meta" / "episodes" / "chunk-000" / "file-000.parquet")
    required = {"episode_index", "tasks", "length", "data/chunk_index", "data/file_index"}
    required |= {"dataset_from_index", "dataset_to_index"}
    required |= {"meta/episodes/chunk_index", "meta/episodes/file_index"}
    required |= {f"stats/{f}/{s}" for f in info["features"] for s in ("min", "max", "mean", "std", "count")}
    assert required == set(episodes.column_names)
    assert set(meta(lerobot, "stats")) == set(info["features"])


def test_columns_have_the_shapes_and_types_of_the_features(lerobot):
    info = meta(lerobot, "info")
    table = pq.read_table(lerobot / info["data_path"].format(chunk_index=0, file_index=0))
    assert set(table.column_names) == set(info["features"])
    for name, feature in info["features"].items():
        values = np.array(table[name].to_pylist())
        shape = () if feature["shape"] == [1] else tuple(feature["shape"])
        assert values.shape == (info["total_frames"], *shape)
        kind = table.schema.field(name).type
        while hasattr(kind, "value_type"):
            kind = kind.value_type
        assert str(kind) == {"float32": "float"}.get(feature["dtype"], feature["dtype"])


def test_indices_count_frames_episodes_and_tasks(lerobot):
    info = meta(lerobot, "info")
    table = pq.read_table(lerobot / info["data_path"].format(chunk_index=0, file_index=0))
    episodes = pq.read_table(lerobot / "meta" / "episodes" / "chunk-000" / "file-000.parquet").to_pylist()
    tasks = pandas.read_parquet(lerobot / "meta" / "tasks.parquet")
    np.testing.assert_array_equal(table["index"].to_numpy(), np.arange(info["total_frames"]))
    assert episodes[-1]["dataset_to_index"] == info["total_frames"]
    for episode in episodes:
        part = table.slice(episode["dataset_from_index"], episode["length"])
        assert set(part["episode_index"].to_pylist()) == {episode["episode_index"]}
        np.testing.assert_allclose(
            part["timestamp"].to_numpy() * FPS, np.arange(episode["length"]), atol=1e-3
        )
        assert tasks.iloc[part["task_index"][0].as_py()].name == episode["tasks"][0]


def test_a_frame_has_the_samples_from_its_time_on(two_rates, lerobot):
    store, info = open_store(two_rates), meta(lerobot, "info")
    table = pq.read_table(lerobot / info["data_path"].format(chunk_index=0, file_index=0)).to_pylist()
    assert info["features"]["observation.acceleration"]["shape"] == [3, 25]
    assert info["features"]["observation.force"]["shape"] == [1]  # slower than the frames
    assert info["features"]["observation.acceleration"]["info"]["rate_hz"] == 1000.0
    for episode, recording in enumerate(store.index):
        acceleration = store.signal(recording.id, "acceleration").samples
        force = store.signal(recording.id, "force").samples[0]
        rows = [row for row in table if row["episode_index"] == episode]
        assert len(rows) == int(acceleration.shape[1] / 1000 * FPS)
        joined = np.concatenate([row["observation.acceleration"] for row in rows], axis=1)
        np.testing.assert_array_equal(joined.astype(np.float32), acceleration[:, : joined.shape[1]])
        for row in rows:
            newest = int(np.floor(row["frame_index"] / FPS * 30 + 1e-9))
            assert np.float32(row["observation.force"]) == force[newest]
            assert row["action"] == [recording.speed_mm_s, 1.0]


def test_statistics_are_those_of_all_frames(lerobot):
    info, stats = meta(lerobot, "info"), meta(lerobot, "stats")
    table = pq.read_table(lerobot / info["data_path"].format(chunk_index=0, file_index=0))
    for name in ("observation.acceleration", "observation.force", "action"):
        values = np.array(table[name].to_pylist(), np.float64).reshape(
            len(table), *info["features"][name]["shape"]
        )
        for key, expected in (
            ("mean", values.mean(0)),
            ("std", values.std(0)),
            ("min", values.min(0)),
            ("max", values.max(0)),
        ):
            np.testing.assert_allclose(stats[name][key], expected, rtol=1e-9, atol=1e-12)
        assert stats[name]["count"] == [len(table)]


def test_streams_that_are_not_alike_are_left_out(tmp_path):
    path = stored(tmp_path / "store", [multi_rate(0), multi_rate(1, force=False)])
    facts = export_store(path, to="lerobot", out=tmp_path / "lerobot")
    assert facts["streams"] == ["acceleration"]
    assert facts["left_out"] == {"force": "1 recordings lack it"}


# -- both ----------------------------------------------------------------------------------------------------


def test_pushed_to_a_server_every_file_is_there(two_rates, tmp_path, hub, capsys):
    out = tmp_path / "lerobot"
    words = ["data", "export", str(two_rates), "--to", "lerobot", "--out", str(out), "--push", "lab/cork"]
    assert main(words) == 0
    assert f"{hub.url}/lab/cork" in capsys.readouterr().out
    files = {path.relative_to(out).as_posix(): path.read_bytes() for path in out.rglob("*") if path.is_file()}
    assert hub.repositories["datasets/lab/cork"] == files


def test_what_cannot_be_is_refused(two_rates, tmp_path):
    with pytest.raises(ParameterError, match="fps must be omitted with to='hub'"):
        export_store(two_rates, to="hub", out=tmp_path / "hub", fps=50)
    short = Signal(np.zeros((1, 500)), 1000.0, "m/s^2", ("z",))
    path = stored(tmp_path / "short", [Recording(streams={"acceleration": short})])
    with pytest.raises(ParameterError, match="shorter than a frame of 1/1 s"):
        export_store(path, to="lerobot", out=tmp_path / "lerobot", fps=1)
    (tmp_path / "there").mkdir()
    with pytest.raises(RunError, match="exists already"):
        export_store(two_rates, to="hub", out=tmp_path / "there")
    assert not (tmp_path / "lerobot").exists()
