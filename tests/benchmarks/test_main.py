"""The command `python -m benchmarks`: experiments of our own beside the measurements of speed."""

import json

import pytest
from benchmarks import __main__ as command
from benchmarks.experiments import staircase_bias


def test_experiments_are_listed_apart_from_those_that_are_published(capsys):
    from tactogram_benchmark.experiments.catalogue import experiments

    assert command.main(["--list", "--json"]) == 0
    listed = json.loads(capsys.readouterr().out)
    assert listed["staircase_bias"].startswith("Bias and spread of staircase thresholds")
    assert not listed.keys() & experiments().keys()


def test_an_experiment_takes_its_options_and_leaves_its_result(tmp_path, capsys, monkeypatch):
    monkeypatch.setattr(staircase_bias, "SPREADS_DB", (4.0,))
    monkeypatch.setattr(staircase_bias, "LENGTHS", {6: 40})
    assert command.main(["staircase_bias", "--set", "observers=5", "--out", str(tmp_path), "--json"]) == 0
    printed = json.loads(capsys.readouterr().out)
    assert printed["observers"] == 5
    assert json.loads((tmp_path / "result.json").read_text()) == printed


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (["nothing"], "unknown: nothing"),
        (["staircase_bias", "transducer"], "an experiment runs alone"),
        (["phase", "--set", "seeds=2"], "are those of experiments"),
    ],
)
def test_what_cannot_be_run_is_refused(arguments, message, capsys):
    with pytest.raises(SystemExit):
        command.main(arguments)
    assert message in capsys.readouterr().err


def test_a_wrong_option_is_one_line(capsys, tmp_path):
    assert command.main(["transducer", "--set", "q=3", "--out", str(tmp_path / "x")]) == 1
    assert "benchmarks: option of transducer must be one of seeds, got 'q'" in capsys.readouterr().err
