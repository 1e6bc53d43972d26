"""Predictors of ratings, and generators by words, judged."""

import json

import pytest
from made_up_ratings import rated_store, vibration

from tactogram.errors import LeakError
from tactogram.workflows.evaluation.evaluate import evaluate
from tactogram.workflows.evaluation.ratings import MODEL, evaluate_reproduction, predicted_ratings


def test_evaluate_judges_a_predictor_on_items_kept_apart(rater_run, rated, tmp_path):
    found = evaluate(rater_run)
    assert found["per_word"]["rough"]["mae"] < found["per_word"]["rough"]["constant_mae"]
    assert "4 rated items held out" in found["data"]["split"]
    other = evaluate(rater_run, data=rated_store(tmp_path / "other", seed=1))
    assert "20 rated items of another data set" in other["data"]["split"]
    with pytest.raises(LeakError, match="were trained on"):
        evaluate(rater_run, data=rated)


def test_a_rater_model_tells_the_errors_of_generated_signals(rater_run, tmp_path):
    given = {
        f"{kind}/p{n}": vibration(level, n) for kind, level in (("sensor", 1.0), ("A", 0.1)) for n in range(3)
    }
    said = predicted_ratings(rater_run, given)
    assert said.raters == (MODEL,)
    targets = {f"p{n}": [4.0, 4.0] for n in range(3)}
    found = evaluate_reproduction(
        said, targets, conditions=("sensor", "A"), told_by="a rater model", out=tmp_path / "f.png"
    )
    assert found["conditions"]["A"]["mae"] < found["conditions"]["sensor"]["mae"]
    assert (tmp_path / "f.png").is_file()
    assert json.loads((tmp_path / "f.json").read_text())["told_by"] == "a rater model"
