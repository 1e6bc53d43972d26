"""The README's tour, run as it stands but for the size of its data and the length of its training."""

import os
import re
import subprocess
import sys
from functools import reduce
from pathlib import Path

import pytest

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
