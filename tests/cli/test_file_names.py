"""Files whose names are not UTF-8, and paths with a null byte."""

import json
import os
import subprocess
import sys

import numpy as np
import pytest

from tactogram.cli import main
from tactogram.datasets import Recording, create_store, open_store
from tactogram.signal import Signal
from tactogram.signal.io import write_signal

LATIN = os.fsdecode(b"caf\xe9")
"""A name in Latin-1, as Python decodes it: with a lone surrogate."""
NULL = "a\0b"


@pytest.fixture(name="signal")
def signal_fixture(tmp_path):
    """A file whose name is not UTF-8; skipped where the file system refuses it."""
    path = tmp_path / f"{LATIN}.wav"
    try:
        path.touch()
    except OSError:
        pytest.skip("this file system has only UTF-8 names")
    write_signal(path, Signal(np.sin(np.arange(2000) / 5), 1000.0, "m/s^2"))
    return path


def test_a_name_that_is_not_utf_8_is_printed_escaped_by_the_program(signal, tmp_path):
    words = ("convert", signal, tmp_path / f"{LATIN}.csv")
    done = subprocess.run([sys.executable, "-m", "tactogram", *words], capture_output=True, check=False)
    assert done.returncode == 0, done.stderr
    assert rb"caf\udce9.csv" in done.stdout


def test_a_name_that_is_not_utf_8_is_read_back_from_json(signal, tmp_path, capfdbinary):
    assert main(["convert", str(signal), str(tmp_path / f"{LATIN}.npz"), "--json"]) == 0
    target = json.loads(capfdbinary.readouterr().out)["target"]
    assert target == str(tmp_path / f"{LATIN}.npz")
    assert os.path.exists(target)


def test_an_error_that_names_it_is_one_line(tmp_path, capfdbinary):
    assert main(["convert", str(tmp_path / f"{LATIN}.wav"), str(tmp_path / "x.csv")]) == 1
    said = capfdbinary.readouterr().err
    assert said.count(b"\n") == 1
    assert rb"caf\udce9.wav" in said


def test_a_report_holds_it(signal, tmp_path):
    drive = tmp_path / f"{LATIN}-drive.wav"
    assert (
        main(["render", str(signal), "--display", "audio", "--level", "peak=0.5", "--out", str(drive)]) == 0
    )
    report = json.loads(drive.with_suffix(".report.json").read_text(encoding="utf-8"))
    assert report["source_file"] == str(signal)


def test_a_store_needs_names_in_utf_8(signal, tmp_path, capsys):
    first = Recording(
        streams={"acceleration": Signal(np.ones(2000), 1000.0, "m/s^2")}, material="tile", source="x"
    )
    store = create_store(tmp_path / "s", [first], name="t", licence="made in a test", simulated=False)
    assert main(["data", "add", str(tmp_path / "s"), str(signal), "--material", "cork"]) == 1
    assert "file names must be UTF-8; rename the file or folder" in capsys.readouterr().err
    assert main(["data", "check", str(tmp_path / "s")]) == 0
    assert open_store(tmp_path / "s").sha256 == store.sha256


@pytest.mark.parametrize(
    "words",
    [
        ["live", "RUN", "--source", f"log:{NULL}"],
        ["capture", NULL, "--source", "simulated:twelite", "--data", "d"],
        ["capture", "first-try", "--source", f"log:{NULL}", "--data", "d", "--yes"],
        ["capture", "first-try", "--source", "simulated:twelite", "--data", NULL, "--yes"],
        ["convert", NULL, "b.wav"],
        ["convert", "a.wav", NULL],
        ["classify", NULL, "x.wav"],
        ["data", "info", NULL],
        ["render", "x.wav", "--display", NULL, "--level", "peak=1", "--out", "y.wav"],
        ["render", "x.wav", "--display", "audio", "--level", "peak=1", "--out", NULL],
        ["study", "check", NULL],
        ["study", "progress", NULL],
        ["capture-log", NULL],
        ["train", "stroke_cnn", "--data", NULL],
    ],
)
def test_a_null_byte_in_a_path_is_one_line(words, capsys, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    assert main(words) == 1
    lines = capsys.readouterr().err.splitlines()
    assert len(lines) == 1
    assert lines[0].startswith("tactogram: ")
