"""The page of the Python interface: it has every public name, and its examples run."""

import os
import re
import subprocess
import sys
from pathlib import Path

import tactogram

PAGE = (Path(__file__).parents[1] / "docs" / "api.md").read_text(encoding="utf-8")
ENVIRONMENT = {
    **os.environ,
    "PATH": f"{Path(sys.executable).parent}{os.pathsep}{os.environ['PATH']}",
    "PYTHONWARNINGS": "error",
}


def test_the_page_has_every_public_name():
    documented = re.findall(r"^\.\. auto(?:class|function):: (\w+)$", PAGE, re.MULTILINE)
    assert sorted(documented) == sorted(tactogram.__all__)


def test_the_examples_run_in_their_order(tmp_path):
    blocks = re.findall(r"<!-- api -->\n```(\w+)\n(.*?)```", PAGE, re.DOTALL)
    shell, *python = blocks
    assert [language for language, _ in python] == ["python"] * 6
    for command in (["bash", "-euc", shell[1]], [sys.executable, "-c", "".join(code for _, code in python)]):
        done = subprocess.run(
            command, cwd=tmp_path, env=ENVIRONMENT, capture_output=True, text=True, check=False
        )
        assert done.returncode == 0, done.stdout + done.stderr
    assert "<Signal: x, y, z in m/s^2, 2 s at 1000 Hz>" in done.stdout
    assert {"noise.wav", "drive.wav", "touch.ahap", "felt.wav"} <= {path.name for path in tmp_path.iterdir()}
