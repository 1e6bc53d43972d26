"""Search for surfaces."""

import pytest

from tactogram.datasets import create_store
from tactogram.errors import ParameterError
from tactogram.signal.io import write_signal
from tactogram.workflows.data.stores import add_signal
from tactogram.workflows.recognition.classify import classify
from tactogram.workflows.recognition.search import search
from tactogram.workflows.training.loaded_run import load_run
from tactogram.workflows.training.surface_index import SurfaceIndex


def test_search_embeds_only_what_is_new(run, store, texture, recordings, tmp_path, monkeypatch):
    copy = tmp_path / "store"
    create_store(copy, recordings(count=2), name="textures", licence="made in a test", simulated=True)
    signal = texture("foam", 321)
    (run.folder / "search-embedded.npz").unlink(missing_ok=True)  # of other tests' searches
    loaded = load_run(run.folder)
    embedded = []
    embed = loaded.model.embed
    monkeypatch.setattr(loaded.model, "embed", lambda s: embedded.append(1) or embed(s))
    before = search(loaded, signal, data=copy)
    first = len(embedded)
    write_signal(tmp_path / "new.wav", signal)
    added = add_signal(copy, tmp_path / "new.wav", material="felt")
    found = search(loaded, signal, data=copy)
    assert first >= 8 + 1
    assert len(embedded) - first == 2  # what is searched for, and what was added
    assert found["nearest"][0] == {
        "id": added["id"],
        "material": "felt",
        "distance": pytest.approx(0, abs=1e-5),
    }
    assert found["threshold"] == SurfaceIndex.load(run).threshold
    assert before["nearest"][0]["material"] != "felt"
    (run.folder / "search-embedded.npz").write_bytes(b"PK\x03\x04 broken")
    assert search(loaded, signal, data=copy)["nearest"][0]["id"] == added["id"]
    (run.folder / "search-embedded.npz").unlink()


def test_search_wants_a_count(run, texture):
    with pytest.raises(ParameterError, match="count must be at least 1"):
        search(run.folder, texture("foam", 1), count=0)


def test_it_names_and_finds_what_it_was_trained_on(run, texture):
    for material in ("cork", "foam", "tile"):
        said = classify(run.folder, texture(material, 77))
        assert said["material"] == material
        assert sum(said["probabilities"].values()) == pytest.approx(1)
        assert search(run.folder, texture(material, 77))["nearest"][0]["material"] == material


def test_search_in_another_store(run, store, texture):
    found = search(run.folder, texture("wool", 5), data=store, count=3)
    assert found["nearest"][0]["material"] == "wool"
    assert len(found["nearest"]) == 3
    again = search(run.folder, texture("wool", 5), data=store, count=3)
    assert again == found
