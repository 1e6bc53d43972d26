"""The README's examples: the tour, but for the size of its data and the length of its training, and own recordings."""

import json
import os
import re
import subprocess
import sys
from functools import reduce
from pathlib import Path

import numpy as np
import pytest
import soundfile
from PIL import Image
from scipy.signal import lfilter

ROOT = Path(__file__).parents[1]
ENVIRONMENT = {
    **os.environ,
    "PATH": f"{Path(sys.executable).parent}{os.pathsep}{os.environ['PATH']}",
    "MPLBACKEND": "agg",
    "PYTHONWARNINGS": "error",
}
SHORTER = {
    "--per-class 8 --seconds 3": "--per-class 3 --seconds 1",
    "--signals 3 --seconds 3": "--signals 2 --seconds 1",
    "--seconds 5 --out corduroy.wav": "--seconds 2 --out corduroy.wav",
}


@pytest.mark.slow
def test_the_tour_runs_as_written(tmp_path):
    text = (ROOT / "README.md").read_text(encoding="utf-8")
    blocks = re.findall(r"<!-- tour -->\n```(\w+)\n(.*?)```", text, re.DOTALL)
    assert [language for language, _ in blocks] == ["sh", "python"]
    assert all(long in blocks[0][1] for long in SHORTER)
    times = [re.search(r"\(about (\d+) s\)", line) for line in blocks[0][1].splitlines() if line[:1] == "#"]
    assert len(times) == 5
    assert all(found and int(found[1]) < 60 for found in times)
    for language, code in blocks:
        short = reduce(lambda text, long: text.replace(long, SHORTER[long]), SHORTER, code)
        command = ["bash", "-euc", short] if language == "sh" else [sys.executable, "-c", short]
        done = subprocess.run(
            command, cwd=tmp_path, env=ENVIRONMENT, capture_output=True, text=True, check=False
        )
        assert done.returncode == 0, done.stdout + done.stderr
    assert (tmp_path / "runs/names/report.html").stat().st_size > 50_000
    assert (tmp_path / "mix.csv").exists()
    assert (tmp_path / "mix.flac").exists()


POLES = {"cork": 0.9, "felt": 0.3, "tile": -0.6}
HEADING = "Zeit;Beschleunigung X;Beschleunigung Y;Beschleunigung Z\n(ms);(m/s²);(m/s²);(m/s²)\n"


def log(file, pole, *, gain, seed):
    """Write a table as a German logger does: semicolons, decimal commas, a row of units."""
    noise = np.random.default_rng(seed).standard_normal((3, 2000))
    values = gain * lfilter([1], [1, -pole], noise) + [[0], [0], [9.81]]
    rows = (";".join(f"{value:.4f}" for value in row) for row in np.vstack([np.arange(2000), values]).T)
    file.parent.mkdir(parents=True, exist_ok=True)
    file.write_text(HEADING + "\n".join(rows).replace(".", ",") + "\n", encoding="utf-8")


@pytest.mark.slow
def test_own_recordings_become_a_classifier_a_figure_and_a_drive_as_written(tmp_path):
    for number, subject in enumerate(("anna", "ben", "chloe", "dev", "eva")):
        for material, pole in POLES.items():
            for take in range(3):
                file = tmp_path / f"recordings/{subject}/{material}/{take + 1}.csv"
                seed = [number, take, len(material), round(100 * pole + 100)]
                log(file, pole, gain=1 + number / 4, seed=seed)
    log(tmp_path / "new.csv", POLES["tile"], gain=1.3, seed=0)
    text = (ROOT / "README.md").read_text(encoding="utf-8")
    [block] = re.findall(r"<!-- own -->\n```sh\n(.*?)```", text, re.DOTALL)
    lines = block.splitlines()
    assert len(lines) == 6
    said = []
    for number, line in enumerate(lines):
        done = subprocess.run(
            ["bash", "-euc", line], cwd=tmp_path, env=ENVIRONMENT, capture_output=True, text=True, check=False
        )
        assert done.returncode == (1 if number == 0 else 0), done.stdout + done.stderr  # first it asks
        said.append(done.stdout)
    assert "--set path={subject}/{material}/{take}" in said[0]
    assert "1000 Hz" in said[0]
    assert "recordings: 45" in said[1]
    assert json.loads((tmp_path / "runs/own/split.json").read_text())["by"] == "subject"
    accuracy = re.search(r"recording accuracy ([\d.]+) %.* of (\d+),", said[3])
    assert float(accuracy[1]) > 80
    assert int(accuracy[2]) == 9  # all of one subject
    with Image.open(tmp_path / "runs/own/confusion.png") as picture:
        assert picture.width > 400
    assert re.search(r"new\.csv +tile", said[4])
    drive, rate = soundfile.read(tmp_path / "drive.wav")
    assert len(drive) / rate == pytest.approx(2, abs=0.1)
    assert np.abs(drive).max() > 0.1
