import json

import numpy as np
import pytest

from tactogram.errors import ParameterError
from tactogram.evaluation.report import write_report
from tactogram.signal.io import read_metadata, read_signal
from tactogram.workflows.evaluation.mixing_ladder import mix_ladder, mixing_ladder, recorded
from tactogram.workflows.training.loaded_run import load_run
from tactogram.workflows.training.train import train

SMALL = {"steps": 3, "signals": 3, "seconds": 1.0}


@pytest.fixture(scope="module")
def voice(store, tmp_path_factory):
    out = tmp_path_factory.mktemp("runs") / "ar"
    return load_run(train("ar_texture", store, recipe="tiny", out=out).folder)


@pytest.fixture(scope="module")
def mixes(voice):
    return mix_ladder(voice, "cork", "tile", seed=1, **SMALL)


def test_a_ladder_is_written_whole(voice, tmp_path):
    found = mixing_ladder(voice, "cork", "tile", out=tmp_path / "ladder", seed=4, **SMALL)
    assert found == json.loads((tmp_path / "ladder" / "ladder.json").read_text())
    assert {file.name for file in (tmp_path / "ladder").iterdir()} == {
        "ladder.json",
        "ladder.png",
        "00-tile-0.wav",
        "01-tile-0.5.wav",
        "02-tile-1.wav",
    }
    position = found["ladder"]["position"]["overall"]
    assert position[0] == pytest.approx(0, abs=0.1)
    assert position[2] == pytest.approx(1, abs=0.1)
    assert 0.1 < position[1] < 0.9
    assert found["ladder"]["monotone"]["overall"] is True
    assert found["simulated"] is True
    assert "moves one way" in found["in_words"]
    middle = tmp_path / "ladder" / "01-tile-0.5.wav"
    assert read_signal(middle).seconds == 1.0
    assert read_metadata(middle)["material"] == {"tile": 0.5, "cork": 0.5}
    assert read_metadata(middle)["simulated"] is True


def test_the_same_seed_makes_the_same_ladder_and_another_does_not(voice, mixes):
    same, other = (mix_ladder(voice, "cork", "tile", seed=seed, **SMALL) for seed in (1, 2))
    np.testing.assert_array_equal(mixes.ladder.position, same.ladder.position)
    np.testing.assert_array_equal(mixes.shown[1].samples, same.shown[1].samples)
    assert not np.array_equal(mixes.ladder.position, other.ladder.position)


def test_what_was_made_is_used_again_only_if_the_same_is_asked(voice, tmp_path, monkeypatch):
    monkeypatch.setattr("tactogram.evaluation.report.save_figure", lambda path, figure: path)
    options = {**SMALL, "out": tmp_path, "reuse": True}
    first = mixing_ladder(voice, "cork", "tile", **options)
    before = (tmp_path / "ladder.json").stat().st_mtime_ns
    assert mixing_ladder(voice, "cork", "tile", **options) == first
    assert (tmp_path / "ladder.json").stat().st_mtime_ns == before
    again = mixing_ladder(voice, "cork", "tile", seed=9, **options)
    assert again["seed"] == 9
    (tmp_path / "ladder.json").write_text("{")
    assert mixing_ladder(voice, "cork", "tile", seed=9, **options) == again


def test_adding_keeps_the_start_at_one(voice):
    """Saga et al., Sec. V: "“Tile” between 0.0 and 1.0, and “Place Mat 03” to 1"."""
    mixes = mix_ladder(voice, "cork", "tile", mode="add", **SMALL)
    assert mixes.start_weights.tolist() == [1, 1, 1]
    assert mixes.caption(1) == "0.5 tile, 1 cork"
    # The model shares weights out: as much of both is half way, not the end.
    assert mixes.ladder.position[-1, -1] < 0.9


def test_recordings_are_those_that_were_kept_apart(voice, mixes):
    kept = recorded(voice, "tile")
    assert len(kept) == 2
    assert kept[0].axes == ("x", "y", "z")
    against = mixes.against_recordings
    # What is generated from a material lies near its recordings.
    np.testing.assert_allclose(against.position[[0, -1], -1], [0, 1], atol=0.3)


def test_the_section_has_a_figure_a_table_and_a_sound_per_step(mixes, tmp_path):
    page = write_report(
        tmp_path / "r.html", title="t", summary="s", sections=[mixes.section()], simulated=True
    ).read_text()
    assert page.count("<audio") == 3
    assert "From cork to tile" in page
    assert "half way at" in page


@pytest.mark.parametrize(
    ("start", "end", "change", "message"),
    [
        ("cork", "cork", {}, "a ladder needs two materials, got 'cork' twice"),
        ("cork", "glass", {}, "material must be one of cork, foam, tile, wool, got 'glass'"),
        ("cork", "tile", {"mode": "times"}, "mode must be 'sum' or 'add', got 'times'"),
        ("cork", "tile", {"steps": 1}, "steps must be greater than or equal to 2, got 1"),
        ("cork", "tile", {"signals": 1}, "signals must be greater than or equal to 2, got 1"),
        ("cork", "tile", {"seconds": 0.1}, "signals must last at least 0.5 s"),
    ],
)
def test_what_makes_no_ladder_is_refused_and_nothing_written(voice, tmp_path, start, end, change, message):
    with pytest.raises(ParameterError, match=message):
        mixing_ladder(voice, start, end, out=tmp_path / "x", **{**SMALL, **change})
    assert not (tmp_path / "x").exists()


def test_a_classifier_makes_no_ladder(run):
    with pytest.raises(ParameterError, match="stroke_cnn does not generate"):
        mixing_ladder(run.folder, "cork", "tile")
