"""The documentation: public names, commands and examples of its pages, and what is made from the code."""

import os
import re
import shlex
import subprocess
import sys
from pathlib import Path

import pytest
from docs.extensions.repository_pages import PAGES, ROOT, relinked
from docs.extensions.verb_pages import GUIDES, page

import tactogram
from tactogram import models
from tactogram.cli import main
from tactogram.cli.catalogue import verb_places

DOCS = Path(__file__).parents[1] / "docs"
KINDS = ("tutorials", "how-to", "reference", "explanation")
GENERATED = ("benchmark-results",)
"""Pages that a program writes, of any length."""
WORDS = {"README.md": 800, "CONTRIBUTING.md": 500} | {
    f"docs/{path.name}": 1500 for path in DOCS.glob("*.md") if path.stem not in GENERATED
}
"""Most words of each page, as `wc -w` counts them."""
CELL = 120
"""Most characters of a table's cell, as read: without the addresses of links."""
ENVIRONMENT = {
    **os.environ,
    "PATH": f"{Path(sys.executable).parent}{os.pathsep}{os.environ['PATH']}",
    "PYTHONWARNINGS": "error",
}


def text_of(name):
    return (DOCS / f"{name}.md").read_text(encoding="utf-8")


def test_the_python_page_has_every_public_name():
    documented = re.findall(r"^\.\. auto(?:class|function):: (\w+)$", text_of("api"), re.MULTILINE)
    assert sorted(documented) == sorted(tactogram.__all__)


@pytest.mark.slow
def test_the_examples_of_the_python_page_run_in_their_order(tmp_path):
    shell, *python = re.findall(r"<!-- api -->\n```(\w+)\n(.*?)```", text_of("api"), re.DOTALL)
    assert [language for language, _ in python] == ["python"] * 8
    for command in (["bash", "-euc", shell[1]], [sys.executable, "-c", "".join(code for _, code in python)]):
        done = subprocess.run(
            command, cwd=tmp_path, env=ENVIRONMENT, capture_output=True, text=True, check=False
        )
        assert done.returncode == 0, done.stdout + done.stderr
    assert "<Signal: x, y, z in m/s^2, 2 s at 1000 Hz>" in done.stdout
    assert {"noise.wav", "drive.wav", "touch.ahap", "felt.wav"} <= {path.name for path in tmp_path.iterdir()}


@pytest.mark.slow
def test_the_commands_for_engines_run(tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    blocks = re.findall(r"<!-- engines -->\n```sh\n(.*?)```", text_of("engines"), re.DOTALL)
    lines = "".join(blocks).splitlines()
    for line in lines:
        verb, *arguments = shlex.split(line, comments=True)
        assert (verb, main(arguments)) == ("tactogram", 0), line + capsys.readouterr().err
    written = {path.suffix for path in tmp_path.iterdir()}
    assert {".haptic", ".ahap", ".json", ".hjif", ".wav", ".h"} <= written


def test_a_verbs_page_has_its_options_and_a_groups_page_its_verbs():
    convert = page("convert")
    assert "{option} --full-scale FULL_SCALE\nValue of 1 in a haptic target" in convert
    assert "{option} --check\n" in convert
    assert "{doc}`/engines`" in convert
    assert "pip install 'tactogram[playback]'" in page("stream")
    assert "pip install" not in convert
    data = page("data")
    assert re.findall(r"^## (.*)$", data, re.MULTILINE) == [
        words for words in verb_places() if words.startswith("data ")
    ]
    assert set(GUIDES) == {place.module.rpartition(".")[2] for place in verb_places().values()}


@pytest.mark.parametrize("kind", KINDS)
def test_a_kinds_page_lists_what_is_below_it(kind):
    text = text_of(kind)
    below = re.search(r"```{toctree}\n:hidden:\n\n(.*?)```", text, re.DOTALL)[1].split("\n")
    names = {Path(re.sub(r".*<(.*)>", r"\1", line)).name for line in below if line}
    listed = {Path(link).stem.lower() for link in re.findall(r"(?:\]\(|{doc}`[^<]+<)([^>)]+)", text)}
    assert names <= listed


def test_links_lead_to_pages_and_to_files_that_are_none():
    place, page = (
        ROOT / "src/tactogram/models/texture_gan/README.md",
        ROOT / "docs/from-repository/texture_gan.md",
    )
    assert relinked("[a](../stroke_gan/README.md#mixing)", place, page) == "[a](stroke_gan.md#mixing)"
    assert relinked("[a](../../../../CONTRIBUTING.md)", place, page) == "[a](contributing.md)"
    assert relinked("[a](b.json), [c](https://d.e)", place, page) == (
        "[a](../../src/tactogram/models/texture_gan/b.json), [c](https://d.e)"
    )
    assert relinked("[a](trained/README.md)", place, page).startswith("{download}`a <../../src/")
    assert {path.parent.name for path in PAGES} == {*models.available(), ROOT.name}


def test_every_page_is_of_one_kind():
    below = [
        line
        for kind in KINDS
        for line in re.findall(r"^(?:.*<)?([a-z0-9-]+)>?$", text_of(kind), re.MULTILINE)
    ]
    pages = {path.stem for path in DOCS.glob("*.md")} - {*KINDS, "index"}
    assert sorted(name for name in below if name in pages) == sorted(pages)


def wide_cells(text):
    """Return the cells of the tables of a text that are too long to be read in a table."""
    rows = [line for line in text.splitlines() if line.lstrip().startswith("|")]
    read = [re.sub(r"\[([^\]]*)\]\([^)]*\)", r"\1", row) for row in rows]
    cells = [cell.strip() for row in read for cell in re.split(r"(?<!\\)\|", row)]
    return [cell for cell in cells if len(cell) > CELL]


@pytest.mark.parametrize("page", WORDS)
def test_a_page_is_short_enough_to_be_read(page):
    text = (ROOT / page).read_text(encoding="utf-8")
    assert len(text.split()) <= WORDS[page]
    assert wide_cells(text) == []


def statements_of(text):
    """Return the rows of a paper's tables: section, statement, state, where it is checked or what is missing."""
    rows = [re.split(r" *\| *", line)[1:-1] for line in text.splitlines() if line.startswith("|")]
    return [row for row in rows if row[0] != "Section" and set(row[0]) != {"-"}]


@pytest.mark.parametrize("page", [path.stem for path in sorted(DOCS.glob("paper-*.md"))])
def test_statements_of_a_paper_name_tests_and_results_that_are_there(page):
    statements = statements_of(text_of(page))
    assert {state for _, _, state, _ in statements} == {"tested", "differs", "not here"}
    for _, statement, state, here in statements:
        named = re.findall(r"\[`(test_\w+)`\]\((\S+)\)", here)
        assert here, statement
        assert named or state != "tested", statement
        for name, file in named:
            source = (DOCS / file).read_text(encoding="utf-8")
            assert re.search(rf"^ *def {name}\(", source, re.MULTILINE), f"{file}: {name}"
        for file in re.findall(r"`(\S+\.json)`", here):
            assert list((ROOT / "benchmarks" / "reproduced").glob(file)), file


def test_a_cell_is_measured_as_it_is_read():
    link = f"[{'a' * CELL}](https://b.c)"
    assert wide_cells(f"| one | {link} |\n{'x' * 200}") == []
    assert wide_cells(f"| one \\| {'a' * CELL} | two |") == [f"one \\| {'a' * CELL}"]
