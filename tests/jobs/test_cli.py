import json
import subprocess
import sys

import pytest
from tactogram.signal.io import write_signal

from tactogram.cli import main


def test_help_names_every_verb(capsys):
    with pytest.raises(SystemExit) as stopped:
        main(["--help"])
    assert stopped.value.code == 0
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
        assert f"\n    {verb} " in said


@pytest.mark.parametrize(
    "arguments", [["nothing"], ["train"], ["train", "stroke_cnn"], ["generate", "r", "--out", "x"]]
)
def test_a_usage_error_exits_2(arguments, capsys):
    with pytest.raises(SystemExit) as stopped:
        main(arguments)
    assert stopped.value.code == 2


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (["train", "nothing", "--data", "STORE"], "model must be one of ar_texture, stroke_cnn"),
        (
            ["train", "stroke_cnn", "--data", "STORE", "--recipe", "x"],
            "recipe of stroke_cnn must be one of paper",
        ),
        (["train", "stroke_cnn", "--data", "STORE", "--set", "config.step=1"], "unknown key 'step'"),
        (["train", "stroke_cnn", "--data", "STORE", "--band", "20", "1000"], "165"),
        (["train", "stroke_cnn", "--data", "nowhere"], "nowhere"),
        (["evaluate", "nowhere"], "nowhere: not a run"),
        (["crossval", "stroke_cnn", "--data", "STORE", "--split", "last=x"], "--split last=N needs a number"),
        (["crossval", "stroke_cnn", "--data", "STORE", "--folds", "1"], "--folds must be at least 2"),
        (["classify", "RUN", "nowhere.wav"], "nowhere.wav"),
        (["reproduce", "nothing"], "experiment must be one of"),
    ],
)
def test_what_is_wrong_is_one_line(arguments, message, store, run, capsys, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    places = {"STORE": str(store), "RUN": str(run.folder)}
    assert main([places.get(a, a) for a in arguments]) == 1
    said = capsys.readouterr()
    assert said.out == ""
    last = said.err.strip().split("\n")[-1]
    assert last.startswith("tactogram: ")
    assert message in last
    assert "Traceback" not in said.err


def test_results_are_one_json_object(run, capsys, tmp_path, texture):
    file = tmp_path / "x.wav"
    write_signal(file, texture("tile", 8))
    assert main(["classify", str(run.folder), str(file), "--json"]) == 0
    said = json.loads(capsys.readouterr().out)["files"][str(file)]
    assert said["material"] == "tile"
    assert main(["search", str(run.folder), str(file), "--json"]) == 0
    assert json.loads(capsys.readouterr().out)["nearest"][0]["material"] == "tile"
    assert main(["evaluate", str(run.folder), "--json"]) == 0
    figures = json.loads(capsys.readouterr().out)
    assert {"window_accuracy", "recording_accuracy"} <= figures.keys()


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


def test_doctor_tells_versions_and_extras(capsys):
    assert main(["doctor", "--json"]) == 0
    facts = json.loads(capsys.readouterr().out)
    assert facts["packages"]["torch"].startswith("2.")
    assert facts["extras"]["dev"] == {"for": "tests, style, types, benchmarks", "missing": []}
    assert facts["device"]


def test_the_command_starts_as_a_program():
    done = subprocess.run(
        [sys.executable, "-m", "tactogram.cli", "--version"], capture_output=True, text=True, check=True
    )
    assert done.stdout.startswith("tactogram 0.")
