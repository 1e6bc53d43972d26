"""The functions behind ``tactogram data``: plain results that are JSON."""

import json

import numpy as np
import pytest
import soundfile

from tactogram import plugins
from tactogram.cli import main
from tactogram.datasets import Recording, create_store, open_store
from tactogram.errors import DataError, ParameterError
from tactogram.signal import Signal
from tactogram.workflows.data.stores import add_signal, check_store, import_store, list_sets, store_info


@pytest.fixture
def store(tmp_path):
    def recordings():
        for seed, material in enumerate(("cork", "cork", "jeans")):
            samples = np.random.default_rng(seed).standard_normal(500)
            yield Recording(
                streams={"sound": Signal(samples, 1000.0, "1")},
                material=material,
                contactor="pen",
                source=str(seed),
            )

    return create_store(tmp_path / "s", recordings(), name="test", licence="CC0-1.0", simulated=True)


def test_every_set_is_listed():
    facts = json.loads(json.dumps(list_sets()))
    assert {"folder", "lmt108", "cluster", "biotac_slide", "vibviz", "hatt"} <= facts["import"].keys()
    assert facts["import"]["vibviz"]["licence"] == "CC-BY-4.0"
    assert {"stroking30", "stroking9"} <= facts["simulate"].keys()


def test_without_the_extras_own_recordings_are_left_and_the_list_names_one(monkeypatch, capsys):
    advice = "further importers come with an extra: pip install 'tactogram[benchmark]'"
    assert main(["data", "list"]) == 0
    assert advice not in capsys.readouterr().out
    monkeypatch.setattr(plugins, "_entry_points", lambda group, path: ())
    assert main(["data", "list"]) == 0
    kept = capsys.readouterr().out
    assert [line.split()[0] for line in kept.splitlines()] == ["import:", "folder", "further"]
    assert kept.endswith(f"{advice}\n")
    assert main(["data", "import", "lmt108", "x", "--out", "y"]) == 1
    refused = capsys.readouterr().err
    assert "importer must be one of folder, got 'lmt108'" in refused
    assert advice in refused


def test_a_store_says_what_it_holds(store):
    facts = json.loads(json.dumps(store_info(store.path)))
    assert facts["materials"] == {"cork": 2, "jeans": 1}
    assert facts["simulated"] is True
    assert (facts["contactors"], facts["sessions"], facts["images"]) == (1, 0, 0)
    sound = facts["streams"]["sound"]
    assert (sound["unit"], sound["rates"], sound["recordings"], sound["seconds"]) == ("1", [1000.0], 3, 1.5)


def test_a_check_says_yes_or_why_not(store):
    assert check_store(store.path)["ok"]
    shard = store.path / store.facts.shards[0].file
    content = bytearray(shard.read_bytes())
    content[-1000] ^= 4
    shard.write_bytes(content)
    facts = json.loads(json.dumps(check_store(store.path)))
    assert not facts["ok"]
    assert "sha256 differs" in facts["problems"][0]


def test_an_import_reports_its_progress(tmp_path):
    (tmp_path / "f" / "cork").mkdir(parents=True)
    soundfile.write(tmp_path / "f" / "cork" / "a.wav", np.linspace(-0.5, 0.5, 99), 1000)
    seen = []
    report = import_store(
        "folder",
        tmp_path / "f",
        tmp_path / "s",
        progress=lambda task, done, total, note="": seen.append((task, done, total)),
    )
    assert seen == [("reading", 1, 1)]
    assert json.loads(json.dumps(report))["recordings"] == 1


def test_a_recording_is_added_once(store, tmp_path):
    soundfile.write(tmp_path / "new.wav", np.random.default_rng(9).uniform(-1, 1, 300), 1000, subtype="FLOAT")
    facts = json.loads(
        json.dumps(add_signal(store.path, tmp_path / "new.wav", material="tile", speed_mm_s=100.0))
    )
    assert (facts["added"], facts["recordings"]) == (True, 4)
    info = open_store(store.path).info(facts["id"])
    assert (info.material, info.speed_mm_s, info.source) == ("tile", 100.0, "new.wav")
    again = add_signal(store.path, tmp_path / "new.wav", material="tile")
    assert (again["added"], again["recordings"], again["sha256"]) == (False, 4, facts["sha256"])
    with pytest.raises(DataError, match="the same samples as new.wav"):
        add_signal(store.path, tmp_path / "new.wav", material="cork")


def test_which_stream_must_be_said_where_there_are_several(tmp_path):
    both = {name: Signal(np.ones(5), 10.0, "N") for name in ("force", "pull")}
    store = create_store(tmp_path / "s", [Recording(streams=both)], name="test", licence="CC0-1.0")
    with pytest.raises(ParameterError, match="stream must be one of force, pull"):
        add_signal(store.path, tmp_path / "x.wav", material="cork")
