"""Generators of images judged by what they differ by and a rater."""

import json
import shutil

import pytest

from tactogram.cli import main
from tactogram.errors import ParameterError
from tactogram.workflows.evaluation.crossval import crossval
from tactogram.workflows.evaluation.evaluate import evaluate
from tactogram.workflows.evaluation.mixing_ladder import mixing_ladder
from tactogram.workflows.training.loaded_run import load_run


def test_a_generator_of_images_is_judged_by_what_they_differ_by_and_a_rater(
    image_run, image_rater, tmp_path, capsys
):
    run = tmp_path / "run"
    shutil.copytree(image_run, run)
    assert main(["evaluate", str(run)]) == 0
    said = capsys.readouterr().out
    assert "collapsed: one image for all labels and noises" in said
    assert "give --rater RUN" in said
    assert main(["evaluate", str(run), "--rater", str(image_rater), "--json"]) == 0
    found = json.loads(capsys.readouterr().out)
    model = load_run(run).model
    assert found["spread"]["noise_spread"] == pytest.approx(model.image_spread().by_noise, rel=1e-5)
    assert found["told_by"] == "a rater model of simulated raters"
    assert abs(found["following"]["slope"]) < 0.1, "after 4 updates it cannot look at its label"
    assert "trained on" in found["data"]["split"], "fewer than 3 were kept for testing"
    assert (run / "evaluation.json").is_file()
    assert "simulated" in (run / "report.html").read_text(encoding="utf-8")


def test_what_does_not_judge_images_is_refused_in_a_line(image_run, image_rater):
    with pytest.raises(ParameterError, match="evaluated on the ratings of its own data; omit `data`"):
        evaluate(image_run, data=load_run(image_run).run.data["path"])
    with pytest.raises(ParameterError, match="unknown is for models that classify materials"):
        evaluate(image_run, unknown=True)
    with pytest.raises(ParameterError, match="tactile_image_cgan is not a predictor of scores"):
        evaluate(image_run, rater=image_run)
    with pytest.raises(ParameterError, match="rater scores generators conditioned on words; rater is none"):
        evaluate(image_rater, rater=image_rater)
    with pytest.raises(ParameterError, match="crossval is for classifiers and predictors of ratings"):
        crossval("tactile_image_cgan", image_run)
    with pytest.raises(
        ParameterError, match="mixes are of materials; tactile_image_cgan is conditioned on words"
    ):
        mixing_ladder(image_run, "a", "b", out=image_run.parent / "ladder")
