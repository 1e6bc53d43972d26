"""A classifier from outside that has nothing but the defaults."""

import sys

import pytest

from tactogram.errors import ParameterError, RunError
from tactogram.workflows.evaluation.crossval import crossval
from tactogram.workflows.evaluation.evaluate import evaluate
from tactogram.workflows.recognition.classify import classify
from tactogram.workflows.recognition.search import search
from tactogram.workflows.training.hub_folder import export_run, import_run
from tactogram.workflows.training.loaded_run import load_run
from tactogram.workflows.training.train import train
from tactogram_capture.live.classifier import LiveClassifier

FACTS = """
title = "The nearest mean of lag-1 autocorrelation"
authors = ["Me"]
year = 2026
task = "classification"
gives = "probabilities"
"""
CODE = """
import numpy as np

from tactogram.model import Model, ModelConfig


class Config(ModelConfig):
    pass


def lag_one(signal):
    x = signal.samples - signal.samples.mean(1, keepdims=True)
    return float((x[:, 1:] * x[:, :-1]).sum() / (x**2).sum())


class NearestMean(Model):
    saved = ("materials", "means")
    means = []

    def step(self, stage, batch):
        members = self.kind.by_material(batch).values()
        self.means = [float(np.mean([lag_one(m.signal) for m in some])) for some in members]
        return {"materials": float(len(self.means))}

    def probabilities(self, signal):
        p = np.exp(-20 * np.abs(lag_one(signal) - np.array(self.means)))
        return p / p.sum()


build = NearestMean
"""


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    folder = tmp_path_factory.mktemp("mine") / "nearest_mean"
    (folder / "recipes").mkdir(parents=True)
    (folder / "model.toml").write_text(FACTS)
    (folder / "__init__.py").write_text(CODE)
    (folder / "recipes" / "quick.toml").write_text(
        'model = "nearest_mean"\n[prepare]\nband = [15.0, 150.0]\n'
    )
    yield folder
    sys.modules.pop("nearest_mean", None)


@pytest.fixture(scope="module")
def loaded(folder, store, tmp_path_factory):
    out = tmp_path_factory.mktemp("runs") / "nearest"
    train("nearest_mean", store, out=out, accelerator="cpu", model_folders=[folder.parent])
    return load_run(out)


def test_its_folder_is_remembered_but_not_from_another_machine(folder, loaded, tmp_path):
    assert loaded.facts.folder == folder.resolve()
    export_run(loaded.run.folder, tmp_path / "run.zip")
    import_run(tmp_path / "run.zip", tmp_path / "there")
    with pytest.raises(
        ParameterError, match="got 'nearest_mean'; name the folder of another with `model_folders`"
    ):
        load_run(tmp_path / "there")
    assert load_run(tmp_path / "there", model_folders=[folder]).facts.folder == folder.resolve()


def test_a_folder_that_is_gone_or_relative_is_not_looked_in(loaded, monkeypatch, folder):
    for named in ("/nowhere/at/all", folder.parent.name):
        monkeypatch.chdir(folder.parents[1])
        monkeypatch.setattr(type(loaded.run), "data", {**loaded.run.data, "model_folders": [named]})
        with pytest.raises(ParameterError, match="model must be one of"):
            load_run(loaded.run.folder)
        monkeypatch.undo()


def test_it_is_evaluated_by_whole_recordings(loaded):
    figures = evaluate(loaded)
    assert figures["windows"] == figures["recordings"] == 8
    assert figures["recording_accuracy"] >= 0.75
    assert figures["confusion_windows"] == figures["confusion_recordings"]
    assert "none_of_these" not in figures


def test_it_is_cross_validated(folder, store, tmp_path):
    figures = crossval("nearest_mean", store, folds=2, out=tmp_path, model_folders=[folder], processes=1)
    assert figures["recordings"] == figures["windows"] == 40
    assert figures["recording_accuracy"] > 0.8


def test_more_folds_than_recordings_divide_recordings_without_a_gap(folder, store, tmp_path):
    options = {"folds": 20, "only_folds": 1, "model_folders": [folder], "processes": 1}
    figures = crossval("nearest_mean", store, out=tmp_path, **options)
    assert figures["split"].startswith("20 contiguous blocks of each recording; each block counts")


def test_it_classifies_and_cannot_be_searched(loaded, texture):
    found = classify(loaded, texture("cork", 99))
    assert found["material"] == "cork"
    assert found["none_of_these"] is None
    assert sum(found["probabilities"].values()) == pytest.approx(1)
    with pytest.raises(RunError, match="has no search index"):
        search(loaded, texture("cork", 99))


def test_live_it_needs_a_window(loaded, texture):
    with pytest.raises(ParameterError, match="does not state the length of its input"):
        LiveClassifier(loaded)
    heard = LiveClassifier(loaded, window_s=1.0)(texture("tile", 98))
    assert max(heard.probabilities, key=heard.probabilities.get) == "tile"
    assert heard.none_of_these is None
