"""Predictors of ratings: trained, cross-validated by item and by rater, judged, and used on files."""

import json

import numpy as np
import pytest
from made_up_ratings import WORDS, vibration

from tactogram.cli import main
from tactogram.errors import ParameterError
from tactogram.signal.io import write_signal
from tactogram.workflows.evaluation.crossval import crossval
from tactogram.workflows.generation.generate import generate
from tactogram.workflows.training.train import train


def test_crossval_by_item_is_better_than_a_constant_where_there_is_something_to_learn(rated, tmp_path):
    found = crossval("rater", rated, recipe="tiny", processes=1, folds=4, repeats=2, out=tmp_path)
    rough = found["per_word"]["rough"]
    assert rough["mae"] < 0.6 * rough["constant_mae"]
    assert rough["rank_correlation"] > 0.7
    assert rough["split_half_mae"] < rough["one_rater_mae"]
    assert found["data"]["simulated"]
    assert json.loads((tmp_path / "crossval.json").read_text())["mean"]["mae"] == found["mean"]["mae"]
    assert (tmp_path / "words.png").is_file()


def test_what_processes_would_be_sent_changes_no_figure(rated, tmp_path, pickled_tasks):
    options = {"recipe": "tiny", "folds": 2, "repeats": 1}
    here = crossval("rater", rated, out=tmp_path / "here", processes=1, **options)
    there = crossval("rater", rated, out=tmp_path / "there", processes=2, **options)
    assert pickled_tasks
    assert there | {"report": ""} == here | {"report": ""}


@pytest.mark.slow
def test_processes_change_no_figure(rated, tmp_path):
    options = {"recipe": "tiny", "folds": 2, "repeats": 2}
    here = crossval("rater", rated, out=tmp_path / "here", processes=1, **options)
    there = crossval("rater", rated, out=tmp_path / "there", processes=2, **options)
    assert there | {"report": ""} == here | {"report": ""}


def test_crossval_by_rater_is_judged_by_people_who_were_not_trained_on(rated, tmp_path):
    """Held against two people's mean and not six, it cannot come closer than their noise."""
    by_item = crossval(
        "rater", rated, recipe="tiny", processes=1, folds=3, repeats=1, by="item", out=tmp_path / "i"
    )
    both = crossval(
        "rater", rated, recipe="tiny", processes=1, folds=3, repeats=1, by="both", out=tmp_path / "b"
    )
    by_rater = crossval(
        "rater", rated, recipe="tiny", processes=1, folds=3, repeats=1, by="rater", out=tmp_path / "r"
    )
    noise = 0.7 * np.sqrt(2 / np.pi / 2)
    assert by_rater["per_word"]["sticky"]["mae"] == pytest.approx(noise, rel=0.4)
    assert both["per_word"]["sticky"]["mae"] > by_item["per_word"]["sticky"]["mae"]
    assert "raters that were not trained on" in by_rater["split"]


def test_crossval_refuses_what_makes_no_sense(rated, tmp_path):
    with pytest.raises(ParameterError, match="must be item, rater or both"):
        crossval("rater", rated, by="session", out=tmp_path)
    with pytest.raises(ParameterError, match="7 folds need as many raters, got 6"):
        crossval("rater", rated, by="rater", folds=7, out=tmp_path)
    with pytest.raises(ParameterError, match="is for classifiers; of a predictor give `folds`"):
        crossval("rater", rated, only_folds=1, out=tmp_path)


def test_score_and_crossval_are_verbs(rater_run, rated, tmp_path, capsys):
    write_signal(tmp_path / "a.npz", vibration(0.5, 3))
    assert main(["score", str(rater_run), str(tmp_path / "a.npz"), "--json"]) == 0
    [found] = json.loads(capsys.readouterr().out)["files"].values()
    assert set(found["scores"]) == set(WORDS)
    assert main(["score", str(rater_run), str(tmp_path / "a.npz")]) == 0
    assert "predicted by a rater model of simulated raters, scale 1 to 7" in capsys.readouterr().out
    arguments = [
        "crossval",
        "rater",
        "--data",
        str(rated),
        "--recipe",
        "tiny",
        "--folds",
        "2",
        "--repeats",
        "1",
        "--processes",
        "1",
    ]
    assert main([*arguments, "--by", "material", "--out", str(tmp_path / "cv")]) == 0
    assert "simulated raters" in capsys.readouterr().out
    assert main(["score", str(rater_run), str(tmp_path / "nothing.wav")]) == 1


def test_rated_vibrations_of_no_material_train_a_generator_that_follows_words(rated, tmp_path):
    out = tmp_path / "run"
    train("texture_flow", rated, recipe="tiny", label="item", split="all", out=out, accelerator="cpu")
    smooth, rough = (
        next(generate(out, {"words": {"rough": score}}, seconds=2)).samples.std() for score in (2.0, 6.0)
    )
    assert rough > 5 * smooth
