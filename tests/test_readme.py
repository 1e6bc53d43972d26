"""The examples, and what the README names; its tour is in `test_tour`."""

import os
import re
import subprocess
import sys
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[1]
ENVIRONMENT = {
    **os.environ,
    "PATH": f"{Path(sys.executable).parent}{os.pathsep}{os.environ['PATH']}",
    "MPLBACKEND": "agg",
    "PYTHONWARNINGS": "error",
}


@pytest.mark.parametrize("file", sorted((ROOT / "examples").glob("plot_*.py")), ids=lambda p: p.stem)
def test_an_example_runs(file, tmp_path):
    done = subprocess.run(
        [sys.executable, str(file)],
        cwd=tmp_path,
        env=ENVIRONMENT,
        capture_output=True,
        text=True,
        check=False,
    )
    assert done.returncode == 0, done.stderr


def test_every_command_of_the_readme_is_one():
    files = ("README.md", "docs/command-line.md", "docs/guide.md")
    text = "".join((ROOT / file).read_text(encoding="utf-8") for file in files)
    verbs = set(re.findall(r"tactogram ([a-z]+)(?= |`|\n)", text))
    assert verbs
    for verb in sorted(verbs):
        done = subprocess.run(
            ["tactogram", verb, "--help"], env=ENVIRONMENT, capture_output=True, check=False
        )
        assert done.returncode == 0, verb


def test_every_link_of_the_documents_leads_somewhere():
    for file in (*ROOT.glob("*.md"), *(ROOT / "docs").glob("*.md"), *(ROOT / "src").rglob("README.md")):
        for link in re.findall(r"\]\((?!https?:|#)([^)#]+)", file.read_text(encoding="utf-8")):
            assert (file.parent / link).exists(), f"{file.name}: {link}"


def test_every_make_target_is_listed():
    text = (ROOT / "Makefile").read_text(encoding="utf-8")
    listed = set(re.findall(r"^([a-z]+):.*## ", text, re.MULTILINE))
    assert {"demo", "test", "install", "check", "bench", "docs", "help"} <= listed
