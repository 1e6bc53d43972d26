"""The command: help, usage errors, one line for what is wrong, and nothing done that could not be written."""

import os
import subprocess
import sys
from contextvars import Context
from importlib import import_module
from inspect import Parameter
from pathlib import Path

import pytest

from tactogram.cli import main
from tactogram.cli.catalogue import verb_places
from tactogram.cli.verbs import flags_of
from tactogram.parameters import parameters
from tactogram.signal.io.atomic import sole_writer


def test_help_names_every_verb(capsys):
    assert main(["--help"]) == 0
    said = capsys.readouterr().out
    for verb in (
        "demo",
        "doctor",
        "data",
        "models",
        "train",
        "crossval",
        "evaluate",
        "generate",
        "classify",
        "search",
    ):
        assert f"\n  {verb} " in said


@pytest.mark.parametrize(
    "arguments", [["nothing"], ["train"], ["train", "stroke_cnn"], ["generate", "r", "--mix", "a=1"]]
)
def test_a_usage_error_exits_2(arguments, capsys):
    try:
        status = main(arguments)
    except SystemExit as stopped:
        status = stopped.code
    assert status == 2


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (
            ["train", "nothing", "--data", "STORE"],
            "model must be one of ar_texture, frictgan, nearest_photo, pix2pix",
        ),
        (["train", "nothing", "--data", "STORE"], "got 'nothing'; name the folder of another with --models"),
        (
            ["train", "stroke_cnn", "--data", "STORE", "--recipe", "x"],
            "recipe of stroke_cnn must be one of paper",
        ),
        (["train", "stroke_cnn", "--data", "STORE", "--set", "config.step=1"], "unknown key 'step'"),
        (
            ["evaluate", "RUN", "--evaluation", "step=1"],
            "evaluation: unknown key 'step'; known here: longest_s",
        ),
        (
            ["evaluate", "RUN", "--evaluation", "steps=0"],
            "evaluation: steps: must be greater than 0, got 0",
        ),
        (["train", "stroke_cnn", "--data", "STORE", "--band", "20", "1000"], "165"),
        (["train", "stroke_cnn", "--data", "nowhere"], "nowhere"),
        (["evaluate", "nowhere"], "nowhere: not a run"),
        (
            ["crossval", "stroke_cnn", "--data", "STORE", "--split", "last=x"],
            "--split must have a number of recordings in last=N",
        ),
        (
            ["crossval", "stroke_cnn", "--data", "STORE", "--folds", "1"],
            "--folds must be greater than or equal to 2",
        ),
        (["classify", "RUN", "nowhere.wav"], "nowhere.wav"),
        (["reproduce", "nothing"], "experiment must be one of"),
        (
            ["train", "stroke_cnn", "--data", "STORE", "--set", "steps=1"],
            "a setting of the model is config.NAME",
        ),
        (["train", "stroke_cnn", "--data", "RUN"], "is not a store: it is a run"),
        (["data", "info", "nowhere"], "not a store: no such folder; make one: tactogram data import folder"),
        (
            ["data", "info", "."],
            "make one of the recordings in it: tactogram data import folder . --out STORE",
        ),
        (
            ["evaluate", "STORE"],
            "not a run: it is a store; train a model on it: tactogram train MODEL --data",
        ),
        (
            ["generate", "RUN", "--out", "x.wav"],
            "stroke_cnn does not generate, it is a model for classification",
        ),
        (["generate", "texture_flow", "--out", "x.wav"], "tactogram generate texture_flow --material "),
        (["table", "RUN"], "was not evaluated: tactogram evaluate "),
        (["table", "--model", "nothing"], "no row contains all of that; `tactogram table` lists every row"),
        (
            ["reproduce", "tactile_image_cgan_figure4", "--data", "x"],
            "--data must be omitted for tactile_image_cgan_figure4, got 'x'; it takes only images",
        ),
    ],
)
def test_what_is_wrong_is_one_line(arguments, message, store, run, capsys, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    (run.folder / "evaluation.json").unlink(missing_ok=True)  # of other tests' evaluations
    places = {"STORE": str(store), "RUN": str(run.folder)}
    assert main([places.get(a, a) for a in arguments]) == 1
    said = capsys.readouterr()
    assert said.out == ""
    last = said.err.strip().split("\n")[-1]
    assert last.startswith("tactogram: ")
    assert message in last
    assert "Traceback" not in said.err


def test_the_same_without_json_is_for_people(run, capsys):
    for arguments in (
        ["models"],
        ["doctor"],
        ["table"],
        ["reproduce", "--list"],
        ["evaluate", str(run.folder)],
    ):
        assert main(arguments) == 0
        assert capsys.readouterr().out.strip()


def test_the_command_starts_as_a_program():
    done = subprocess.run(
        [sys.executable, "-m", "tactogram", "--version"], capture_output=True, text=True, check=True
    )
    assert done.stdout.startswith("tactogram 0.")


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


@pytest.mark.parametrize("words", list(verbs_with_out()), ids=lambda words: "-".join(words[:2]))
def test_a_verb_refuses_what_another_process_writes_before_all_else(words, tmp_path, capsys):
    if words[:2] in (["study", "run"], ["study", "simulate"], ["benchmark", "run"]):
        pytest.skip("several processes may write to one session, or one folder of results")
    with sole_writer(tmp_path / "out"):
        assert Context().run(main, [*words, "--out", str(tmp_path / "out")]) == 1
    assert f"out: process {os.getpid()} writes it at present" in capsys.readouterr().err


@pytest.mark.parametrize(
    "words", [["demo"], ["study", "run", "two-area"], ["study", "analyse", str(Path(__file__).parent)]]
)
def test_a_file_where_a_folder_is_needed_is_refused(words, tmp_path, capsys):
    (tmp_path / "file").write_text("mine")
    assert main([*words, "--out", str(tmp_path / "file")]) == 1
    assert "file: is a file; a folder is needed here" in capsys.readouterr().err
    assert (tmp_path / "file").read_text() == "mine"


def test_what_the_system_refuses_is_one_line(run, store, tmp_path, capsys):
    (tmp_path / "file").touch()
    for arguments in (
        ["run", "export", str(run.folder), "--out", str(tmp_path / "file" / "run.zip")],
        ["crossval", "stroke_cnn", "--data", str(store), "--recipe", "tiny", "--out", str(tmp_path / "file")],
        ["train", "stroke_cnn", "--data", str(store), "--recipe", "tiny", "--out", str(tmp_path / "file")],
        ["generate", str(run.folder), "--material", "cork", "--seed", "-1", "--out", str(tmp_path / "x.wav")],
    ):
        assert main(arguments) == 1
        [*_, last] = capsys.readouterr().err.strip().split("\n")
        assert last.startswith("tactogram: ")
