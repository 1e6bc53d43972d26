"""Work whose result could not be written is refused before it begins."""

import os
from importlib import import_module
from inspect import Parameter
from pathlib import Path

import pytest

from tactogram.cli import main
from tactogram.cli.catalogue import verb_places
from tactogram.cli.verbs import flags_of
from tactogram.errors import ParameterError
from tactogram.parameters import parameters
from tactogram.workflows.data.convert import convert
from tactogram.workflows.evaluation import classifier_crossval, mixing_ladder as mixing
from tactogram.workflows.evaluation.crossval import crossval
from tactogram.workflows.evaluation.evaluate import evaluate
from tactogram.workflows.training import execution, loaded_run
from tactogram.workflows.training.train import train
from tactogram_benchmark.experiments.catalogue import reproduce

NOWHERE = Path(__file__) / "made"
"""Beneath a file: not even root writes there."""


def verbs_with_out():
    """Yield the words of every verb with --out, with something for all else that it requires."""
    for words, place in verb_places().items():
        verb = import_module(place.module).VERBS[words]
        if (flags := flags_of(verb)).get("out") == "--out":
            needed = [one.name for one in parameters(verb.load()) if one.default is Parameter.empty]
            options = [
                [flags[name]] if flags[name].startswith("--") else [] for name in needed if name != "out"
            ]
            yield [*words.split(), *(word for option in options for word in (*option, "nothing"))]


@pytest.mark.parametrize("words", list(verbs_with_out()), ids=lambda words: "-".join(words[:2]))
def test_a_verb_refuses_what_it_could_not_write_before_all_else(words, capsys):
    assert main([*words, "--out", str(NOWHERE)]) == 1
    said = capsys.readouterr().err
    assert said == f"tactogram: {NOWHERE}: cannot be written ({os.strerror(20)}); give another place\n"


@pytest.mark.parametrize(
    "words", [["demo"], ["study", "run", "two-area"], ["study", "analyse", str(Path(__file__).parent)]]
)
def test_a_file_where_a_folder_is_needed_is_refused(words, tmp_path, capsys):
    (tmp_path / "file").write_text("mine")
    assert main([*words, "--out", str(tmp_path / "file")]) == 1
    assert "file: is a file; a folder is needed here" in capsys.readouterr().err
    assert (tmp_path / "file").read_text() == "mine"


def test_a_training_does_not_prepare_what_it_could_not_keep(store, monkeypatch):
    monkeypatch.setattr(execution, "training_material", lambda *_: pytest.fail("recordings were prepared"))
    with pytest.raises(ParameterError, match="cannot be written"):
        train("stroke_cnn", store, recipe="tiny", out=NOWHERE, accelerator="cpu")


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


def test_nothing_is_judged_mixed_or_converted_for_a_folder_that_cannot_be_written(
    run, store, tmp_path, monkeypatch
):
    monkeypatch.setattr(
        "tactogram.workflows.evaluation.run_evaluation.evaluate_run",
        lambda *_, **__: pytest.fail("judged all the same"),
    )
    monkeypatch.setattr(mixing, "mix_ladder", lambda *_, **__: pytest.fail("mixed all the same"))
    loaded = loaded_run.load_run(run.folder)
    with pytest.raises(ParameterError, match="cannot be written"):
        mixing.mixing_ladder(loaded, "cork", "tile", out=NOWHERE)
    unwritable = loaded_run.LoadedRun(
        type(run)(NOWHERE), loaded.facts, loaded.recipe, loaded.any_kind, loaded.model
    )
    with pytest.raises(ParameterError, match="cannot be written"):
        evaluate(unwritable)
    (tmp_path / "a.csv").write_text("x\n1\n2\n")
    with pytest.raises(ParameterError, match="cannot be written"):
        convert(tmp_path, NOWHERE, format="wav", rate=100.0)
