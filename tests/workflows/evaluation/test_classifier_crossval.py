"""Cross-validation of a classifier: folds by recording, or blocks."""

import pytest

import tactogram.workflows.evaluation.classifier_crossval as crossval_module
from tactogram.datasets import add_recordings, create_store, open_store
from tactogram.errors import ParameterError
from tactogram.training.loop import run_training
from tactogram.workflows.evaluation.crossval import crossval


def test_folds_are_by_recording_and_cover_everything(store, tmp_path, tiny):
    options = {"folds": 2, "recipe": "tiny", "changes": tiny, "accelerator": "cpu"}
    figures = crossval("stroke_cnn", store, out=tmp_path / "cv", processes=1, **options)
    assert figures["recordings"] == 40
    assert figures["split"] == "2 folds by recording"
    assert len(figures["per_fold"]) == 2
    assert figures["recording_accuracy"] > 0.7
    assert {f.name for f in (tmp_path / "cv").iterdir()} == {"crossval.json", "confusion.png", "report.html"}


def test_a_cross_validation_that_was_stopped_goes_on_after_its_finished_folds(
    store, tmp_path, tiny, monkeypatch
):
    few = {"changes": tiny | {"config.steps": 5}, "where": {"contactor": "pen", "speed_mm_s": "200"}}
    options = {"folds": 3, "recipe": "tiny", "accelerator": "cpu", "processes": 1, **few}
    whole = crossval("stroke_cnn", store, out=tmp_path / "whole", **options)
    trained = []

    def training(*args, task, **more):
        trained.append(task)
        if len(trained) == 2:
            raise KeyboardInterrupt
        run_training(*args, task=task, **more)

    monkeypatch.setattr(crossval_module, "run_training", training)
    with pytest.raises(KeyboardInterrupt):
        crossval("stroke_cnn", store, out=tmp_path / "cv", **options)
    again = crossval("stroke_cnn", store, out=tmp_path / "cv", **options)
    assert trained == ["fold 1/3 ", "fold 2/3 ", "fold 2/3 ", "fold 3/3 "]
    assert again | {"report": ""} == whole | {"report": ""}
    assert not (tmp_path / "cv" / "folds").exists()


def test_fewer_recordings_than_folds_are_cut_into_blocks(tmp_path, recordings, tiny):
    create_store(tmp_path / "s", recordings(("cork", "tile"), 2), name="s", licence="-", simulated=True)
    options = {"recipe": "tiny", "changes": tiny, "accelerator": "cpu", "out": tmp_path / "cv"}
    figures = crossval("stroke_cnn", tmp_path / "s", folds=5, only_folds=1, **options)
    assert figures["split"].startswith("5 contiguous blocks of each recording, 0.097 s (one window) left out")
    assert figures["split"].endswith("only 1 of the 5 folds were run")
    with pytest.raises(ParameterError, match="50 blocks of a recording .* cork has 2 of the 50 recordings"):
        crossval("stroke_cnn", tmp_path / "s", folds=50, **options)
    add_recordings(open_store(tmp_path / "s"), recordings(("wool",), 1))
    with pytest.raises(
        ParameterError, match="; wool has 1 of .* need: record more of it, or exclude it with `where`"
    ):
        crossval("stroke_cnn", tmp_path / "s", folds=50, **options)


def test_last_recordings_test(store, tmp_path, tiny):
    figures = crossval(
        "stroke_cnn",
        store,
        split="last=3",
        label="material+contactor",
        where={"speed_mm_s": "100"},
        recipe="tiny",
        changes=tiny,
        out=tmp_path / "cv",
        accelerator="cpu",
    )
    assert figures["recordings"] == 12
    assert "cork-finger" in figures["materials"]
