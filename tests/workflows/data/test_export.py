"""Stores as data sets of the Hub: every sample is there, and what readers look for."""

import io
import json

import numpy as np
import pyarrow.parquet as pq
import pytest
from huggingface_hub import DatasetCard
from PIL import Image as Pillow

from tactogram.cli import main
from tactogram.datasets import Recording, create_store, open_store
from tactogram.errors import ParameterError, RunError
from tactogram.signal import Image, Signal
from tactogram.workflows.data.stores import export_store


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


def test_every_recording_is_a_row_of_one_schema(two_rates, tmp_path):
    store = open_store(stored(tmp_path / "store", [multi_rate(0), multi_rate(1, force=False)]))
    facts = export_store(store.path, out=tmp_path / "hub")
    assert facts["recordings"] == 2
    files = sorted((tmp_path / "hub" / "data").glob("*.parquet"))
    tables = [pq.read_table(file) for file in files]
    assert all(table.schema == tables[0].schema for table in tables)
    rows = {row["id"]: row for table in tables for row in table.to_pylist()}
    for info in store.index:
        row = rows[info.id]
        np.testing.assert_array_equal(
            np.array(row["acceleration_y"], np.float32), store.signal(info.id, "acceleration").samples[1]
        )
        assert (row["force_z"] is None) == ("force" not in store.streams_of(info.id))
        assert row["ratings"] == [{"key": "rough", "value": 5.0}]
        assert row["labels"] == [{"key": "take", "value": info.labels["take"]}]


def test_photographs_are_pictures_with_their_materials(two_rates, tmp_path):
    export_store(two_rates, out=tmp_path / "hub")
    table = pq.read_table(tmp_path / "hub" / "photographs" / "part-0.parquet")
    features = json.loads(table.schema.metadata[b"huggingface"])["info"]["features"]
    (row,) = table.to_pylist()
    assert features["image"] == {"_type": "Image"}
    assert row["materials"] == ["cork"]
    pixels = np.asarray(Pillow.open(io.BytesIO(row["image"]["bytes"])))
    np.testing.assert_array_equal(pixels, open_store(two_rates).photograph(row["key"]).pixels)


def test_the_card_names_files_licence_and_units(two_rates, tmp_path):
    export_store(two_rates, out=tmp_path / "hub")
    card = DatasetCard.load(tmp_path / "hub" / "README.md")
    assert card.data.license == "cc-by-4.0"
    assert "simulated-data" in card.data.tags
    assert [each["config_name"] for each in card.data.configs] == ["default", "photographs"]
    for config in card.data.configs:
        for part in config["data_files"]:
            assert list((tmp_path / "hub").glob(part["path"]))
    assert "| force | N | time | z |" in card.text


def test_pushed_to_a_server_every_file_is_there(two_rates, tmp_path, hub, capsys):
    out = tmp_path / "hub"
    words = ["data", "export", str(two_rates), "--out", str(out), "--push", "lab/cork"]
    assert main(words) == 0
    assert f"{hub.url}/lab/cork" in capsys.readouterr().out
    files = {path.relative_to(out).as_posix(): path.read_bytes() for path in out.rglob("*") if path.is_file()}
    assert hub.repositories["datasets/lab/cork"] == files


def test_what_cannot_be_is_refused(two_rates, tmp_path):
    picture = Image(np.zeros((2, 2, 3), np.uint8))
    create_store(tmp_path / "pictures", [], name="p", licence="-", photographs=[("cork", picture)])
    with pytest.raises(ParameterError, match="has no recordings"):
        export_store(tmp_path / "pictures", out=tmp_path / "hub")
    (tmp_path / "there").mkdir()
    with pytest.raises(RunError, match="exists already"):
        export_store(two_rates, out=tmp_path / "there")
    assert not (tmp_path / "hub").exists()
