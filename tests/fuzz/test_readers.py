"""Damaged inputs: what the fuzzer found once, and a minute of it."""

import json
import os
import subprocess
import sys
from pathlib import Path
from random import Random

import pytest
from tests.fuzz.mutations import damaged
from tests.fuzz.readers import CASES, ODD, Bench, Trial, load

from tactogram.cli import main

ROOT = Path(__file__).parents[2]
FOUND = sorted(path.parent for path in CASES.glob("*/how.json"))


@pytest.fixture(scope="module")
def bench(tmp_path_factory):
    return Bench(tmp_path_factory.mktemp("fuzz"), forks=False)


def refused(bench, trial, monkeypatch, capsys):
    """Run a trial in this process; return its line on stderr, and check that it is one and that nothing changed."""
    before = bench.prepared(trial)
    monkeypatch.chdir(bench.work)
    assert main([*trial.argv, "--quiet"]) == 1
    assert bench.changed(before) == []
    [line] = capsys.readouterr().err.splitlines()
    return line.removeprefix("tactogram: ")


@pytest.mark.parametrize("case", FOUND, ids=[case.name for case in FOUND])
def test_what_was_found_is_refused_in_one_line(bench, case, monkeypatch, capsys):
    line = refused(bench, load(case), monkeypatch, capsys)
    assert json.loads((case / "how.json").read_text())["line"] in line


@pytest.mark.parametrize("kind", ["folder", "pipe", "zero", "loop", "flat"])
@pytest.mark.parametrize(
    ("argv", "victim"),
    [
        ("convert signals/own.wav out.csv", "signals/own.wav"),
        ("convert haptic/haptic.haptic out.ahap", "haptic/haptic.haptic"),
        ("convert pictures/a.png out.wav --play-at 100", "pictures/a.png"),
        ("generate textures --conditions settings/conditions.csv --out out", "settings/conditions.csv"),
        ("generate textures --material cork --out out.wav", "textures/model.safetensors"),
        ("data check store", "store/dataset.json"),
        ("capture-log logs/raw.log --out out.csv", "logs/raw.log"),
        ("study check settings/study.toml", "settings/study.toml"),
    ],
)
def test_what_is_no_file_is_refused_before_it_is_opened(bench, argv, victim, kind, monkeypatch, capsys):
    assert kind in ODD
    refused(bench, Trial("", tuple(argv.split()), victim, kind), monkeypatch, capsys)


def test_a_seed_makes_the_same_damage_again():
    raw = b'{"a": [1, 2, {"b": "x"}], "c": 0.5}'
    for name in ("a.json", "a.toml", "a.csv", "a.wav", "a.zip"):
        made = [damaged(raw, name, Random(seed)) for seed in range(50)]
        assert made == [damaged(raw, name, Random(seed)) for seed in range(50)]
        assert len(set(made)) > 30


@pytest.mark.slow
def test_a_minute_of_damaged_inputs_finds_nothing(tmp_path):
    # In a process of its own: it forks, which what other tests have started does not survive.
    command = [sys.executable, "-m", "tests.fuzz.readers", "--minutes", "1", "--out", str(tmp_path)]
    run = subprocess.run(command, cwd=ROOT, env=os.environ, check=False, capture_output=True, text=True)
    assert run.returncode == 0, (run.stderr[-2000:], sorted(path.name for path in tmp_path.iterdir()))
    assert json.loads((tmp_path / "counts.json").read_text())["inputs"] > 50
