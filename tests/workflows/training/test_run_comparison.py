"""Runs side by side."""

import json

import pytest

from tactogram.cli import main
from tactogram.errors import ParameterError, RunError
from tactogram.workflows.evaluation.evaluate import evaluate
from tactogram.workflows.training.run_comparison import compare_runs
from tactogram.workflows.training.train import train


@pytest.fixture(scope="module")
def lab(store, tmp_path_factory):
    """Give a folder with three runs on one store, two of them evaluated."""
    folder = tmp_path_factory.mktemp("lab")
    for name, model, changes in (
        ("wide", "stroke_cnn", {"config.steps": 4}),
        ("fast", "stroke_cnn", {"config.steps": 3, "config.learning_rate": 0.01}),
        ("texture", "ar_texture", {}),
    ):
        train(model, store, recipe="tiny", out=folder / name, changes=changes)
    for name in ("wide", "fast"):
        evaluate(folder / name)
    return folder


def test_only_the_settings_that_differ_are_listed(lab):
    found = compare_runs([lab / "wide", lab / "fast"])
    assert found["settings"] == {"config.steps": [4, 3], "config.learning_rate": [0.001, 0.01]}
    assert found["facts"]["trained on"] == ["textures"] * 2
    evaluations = [json.loads((lab / name / "evaluation.json").read_text()) for name in ("wide", "fast")]
    assert found["results"]["recording_accuracy"] == [e["recording_accuracy"] for e in evaluations]
    assert found["notes"] == []


def test_other_models_share_few_settings(lab):
    found = compare_runs([lab / "wide", lab / "texture"])
    assert found["facts"]["model"] == ["stroke_cnn", "ar_texture"]
    assert not any("learning_rate" in name for name in found["settings"])
    assert found["results"]["recording_accuracy"][1] is None
    assert found["notes"] == ["a run without figures was not evaluated: tactogram evaluate RUN"]


def test_figures_on_other_recordings_do_not_compare(lab, tmp_path):
    evaluation = json.loads((lab / "fast" / "evaluation.json").read_text())
    copied = tmp_path / "copied"
    copied.mkdir()
    for file in (lab / "fast").glob("*.*"):
        (copied / file.name).write_bytes(file.read_bytes())
    evaluation["data"]["sha256"] = "0"
    (copied / "evaluation.json").write_text(json.dumps(evaluation))
    assert "do not compare" in compare_runs([lab / "wide", copied])["notes"][0]


def test_the_verb_prints_columns(lab, capsys, monkeypatch):
    monkeypatch.chdir(lab)
    assert main(["compare", "wide", "fast"]) == 0
    lines = capsys.readouterr().out.splitlines()
    assert lines[0].split() == ["wide", "fast"]
    assert "config.steps 4 3" in [" ".join(line.split()) for line in lines]
    assert main(["compare", "wide"]) == 1
    assert "needs two runs or more, got 1" in capsys.readouterr().err


def test_what_is_no_run_is_refused(lab, tmp_path):
    with pytest.raises(RunError, match="not a run"):
        compare_runs([lab / "wide", tmp_path])
    with pytest.raises(ParameterError, match="two runs or more, got 0"):
        compare_runs([])
