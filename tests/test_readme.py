"""The examples, and what the README names; its tour is in `test_tour`."""

import re
import runpy
from pathlib import Path

import matplotlib.pyplot as plt
import pytest

from tactogram.cli.catalogue import verb_places

ROOT = Path(__file__).parents[1]


@pytest.mark.parametrize("file", sorted((ROOT / "examples").glob("plot_*.py")), ids=lambda p: p.stem)
@pytest.mark.slow
def test_an_example_runs(file, tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    monkeypatch.setattr(plt, "show", lambda: None)
    with plt.rc_context({"backend": "agg"}):
        runpy.run_path(str(file), run_name="__main__")
        plt.close("all")
    assert capsys.readouterr().out
    assert not list(tmp_path.iterdir())


def test_every_command_of_the_documents_is_one():
    files = (ROOT / "README.md", *(ROOT / "docs").glob("*.md"))
    text = "".join(file.read_text(encoding="utf-8") for file in files)
    verbs = set(re.findall(r"tactogram ([a-z]+)(?= |`|\n)", text))
    assert verbs
    assert verbs <= {words.split()[0] for words in verb_places()}


def test_every_link_of_the_documents_leads_somewhere():
    for file in (*ROOT.glob("*.md"), *(ROOT / "docs").glob("*.md"), *(ROOT / "src").rglob("README.md")):
        for link in re.findall(r"\]\((?!https?:|#)([^)#]+)", file.read_text(encoding="utf-8")):
            assert (file.parent / link).exists(), f"{file.name}: {link}"


def test_every_make_target_is_listed():
    text = (ROOT / "Makefile").read_text(encoding="utf-8")
    listed = set(re.findall(r"^([a-z]+):.*## ", text, re.MULTILINE))
    assert {"demo", "test", "install", "check", "bench", "docs", "help"} <= listed
