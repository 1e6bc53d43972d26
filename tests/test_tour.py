"""The README's tour, run as it stands but for the length of its training."""

import os
import re
import subprocess
import sys
from pathlib import Path

ROOT = Path(__file__).parents[1]
ENVIRONMENT = {
    **os.environ,
    "PATH": f"{Path(sys.executable).parent}{os.pathsep}{os.environ['PATH']}",
    "MPLBACKEND": "agg",
    "PYTHONWARNINGS": "error",
}
STEPS = "config.steps=150"


def test_the_tour_runs_as_written(tmp_path):
    text = (ROOT / "README.md").read_text(encoding="utf-8")
    blocks = re.findall(r"<!-- tour -->\n```(\w+)\n(.*?)```", text, re.DOTALL)
    assert [language for language, _ in blocks] == ["sh", "python"]
    assert STEPS in blocks[0][1]
    for language, code in blocks:
        short = code.replace(STEPS, "config.steps=10")
        command = ["bash", "-euc", short] if language == "sh" else [sys.executable, "-c", short]
        done = subprocess.run(
            command, cwd=tmp_path, env=ENVIRONMENT, capture_output=True, text=True, check=False
        )
        assert done.returncode == 0, done.stdout + done.stderr
    assert (tmp_path / "runs/names/report.html").stat().st_size > 50_000
    assert (tmp_path / "mix.csv").exists()
    assert (tmp_path / "mix.flac").exists()
