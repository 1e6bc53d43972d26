"""Cross-validations that are refused."""

import pytest

from tactogram.errors import ParameterError
from tactogram.workflows.evaluation import classifier_crossval
from tactogram.workflows.evaluation.crossval import crossval
from tactogram.workflows.training import execution
from tactogram.workflows.training.train import train
from tactogram_benchmark.experiments.catalogue import reproduce


def test_the_default_folder_is_looked_at_too(store, tmp_path, monkeypatch):
    (tmp_path / "runs").touch()
    monkeypatch.chdir(tmp_path)
    for module, name, begin in (
        (execution, "training_material", train),
        (classifier_crossval, "run_training", crossval),
    ):
        monkeypatch.setattr(module, name, lambda *_, **__: pytest.fail("trained all the same"))
        with pytest.raises(ParameterError, match="cannot be written"):
            begin("stroke_cnn", store, recipe="tiny", accelerator="cpu")
    with pytest.raises(ParameterError, match="cannot be written"):
        reproduce("stroke_cnn_table2")


def test_folds_that_test_nothing_are_refused(store, tmp_path):
    for options, message in (
        ({"split": "all"}, "keeps nothing for testing"),
        ({"only_folds": 0}, "only_folds must be greater than or equal to 1"),
        ({"only_folds": -1}, "only_folds must be greater than or equal to 1"),
    ):
        with pytest.raises(ParameterError, match=message):
            crossval("stroke_cnn", store, recipe="tiny", folds=2, out=tmp_path / "out", **options)
    assert not (tmp_path / "out").exists()
