"""Runs in the layout of the Hugging Face Hub: what is in the folder, and the way to a server and back."""

import json
import shutil

import numpy as np
import pytest
from huggingface_hub import ModelCard

from tactogram.errors import RunError
from tactogram.workflows.evaluation.evaluate import evaluate
from tactogram.workflows.training.export import export, import_from
from tactogram.workflows.training.loaded_run import load_run


@pytest.fixture(scope="module")
def evaluated(run, tmp_path_factory):
    folder = tmp_path_factory.mktemp("runs") / "felt_cork"
    shutil.copytree(run.folder, folder)
    evaluate(folder)
    return folder


@pytest.fixture(scope="module")
def folder(evaluated, tmp_path_factory):
    out = tmp_path_factory.mktemp("hub") / "felt_cork"
    export(evaluated, to="hub", out=out)
    return out


def test_card_configuration_and_results_are_what_the_hub_reads(evaluated, folder):
    evaluation = json.loads((evaluated / "evaluation.json").read_text(encoding="utf-8"))
    card = ModelCard.load(folder / "README.md")
    results = {result.metric_name: result for result in card.data.eval_results}
    assert card.data.library_name == "tactogram"
    assert "simulated-data" in card.data.tags
    assert results["recording_accuracy"].metric_value == evaluation["recording_accuracy"]
    assert results["recording_accuracy"].dataset_revision == evaluation["data"]["sha256"]
    config = json.loads((folder / "config.json").read_text(encoding="utf-8"))
    assert config["model_type"] == "stroke_cnn"


def test_nothing_says_where_it_was_made(evaluated, folder):
    for path in folder.rglob("*"):
        if path.suffix in (".json", ".md", ".toml", ".yaml", ".csv"):
            assert str(evaluated.parent) not in path.read_text(encoding="utf-8")
            assert "/tmp" not in path.read_text(encoding="utf-8")


def test_the_folder_is_the_run_again(evaluated, folder, texture, tmp_path):
    import_from(folder, out=tmp_path / "again")
    ours, theirs = (load_run(each).classifier for each in (evaluated, tmp_path / "again"))
    signal = texture("cork", 99)
    np.testing.assert_array_equal(ours.probabilities(signal), theirs.probabilities(signal))


def test_a_folder_that_is_no_run_is_refused(folder, tmp_path):
    with pytest.raises(RunError, match="not a run in the layout of the Hub: it has no recipe.toml"):
        import_from(tmp_path, out=tmp_path / "run")
    broken = tmp_path / "broken"
    shutil.copytree(folder, broken)
    (broken / "recipe.toml").write_text("model = 3\n", encoding="utf-8")
    with pytest.raises(RunError, match="not a run of this package"):
        import_from(broken, out=tmp_path / "run")
    assert not (tmp_path / "run").exists()
