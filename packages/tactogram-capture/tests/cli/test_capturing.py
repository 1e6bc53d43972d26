"""What the verbs of capture print and refuse."""

import json
import re

import pytest

from tactogram.cli import main
from tactogram_capture.twelite.simulator import SimulatedReceiver


@pytest.mark.parametrize("arguments", [["--list"], ["--list", "--json"]])
def test_capture_lists_its_plans(arguments, capsys):
    assert main(["capture", *arguments]) == 0
    assert "saga-classification" in capsys.readouterr().out


@pytest.mark.parametrize(
    ("arguments", "match"),
    [
        (
            ["capture", "first-try", "--source", "twelite:/dev/no-such-port", "--data", "D", "--yes"],
            "no-such-port",
        ),
        (["capture", "nothing", "--source", "simulated:twelite", "--data", "D"], "no such session plan"),
        (["capture", "first-try", "--source", "x", "--data", "D", "--yes"], "a source must be one of"),
        (["live", "no-run", "--source", "simulated:twelite"], "no-run"),
    ],
)
def test_what_is_wrong_is_said_in_a_line(arguments, match, capsys, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    assert main(arguments) == 1
    said = [line for line in capsys.readouterr().err.splitlines() if line.startswith("tactogram: ")]
    assert len(said) == 1
    assert re.search(match, said[0])
    assert list(tmp_path.iterdir()) == []


@pytest.fixture(name="log")
def log_fixture(tmp_path, write_log):
    path = tmp_path / "take.log"
    write_log(path, SimulatedReceiver(seconds=12, loss=0.02, seed=3))
    return path


def test_verbs_print_what_they_found(log, tmp_path, capsys):
    assert main(["capture-log", str(log), "--out", str(tmp_path / "a.csv"), "--rate", "330"]) == 0
    text = capsys.readouterr().out
    assert "take.log, simulated" in text
    assert "pieces between gaps" in text
    assert main(["capture-log", str(log), "--json"]) == 0
    assert json.loads(capsys.readouterr().out)["sensors"][0]["name"] == "81013C85"
    assert main(["capture-log", str(tmp_path / "none.log")]) == 1
    assert capsys.readouterr().err.count("\n") == 1
