"""The study design in docs/extend-studies.md: its files and commands as written, and all else that a design meets."""

import ast
import json
import re
import shlex
import sys
from pathlib import Path

import pytest

from tactogram.cli import main
from tactogram.errors import ParameterError
from tactogram_studio.pages.studies.catalogue import workspace_studies
from tactogram_studio.workspace.folder import Workspace
from tactogram_study.designs import catalogue, designs, find_design
from tactogram_study.designs.catalogue import FOLDERS_VARIABLE, margin_text, power_tables
from tactogram_study.session.store import SessionStore
from tactogram_study.study_file import Study
from tactogram_study.workflows.analysis import analyse_study
from tactogram_study.workflows.sessions import simulate_study

ROOT = Path(__file__).parents[4]
SOURCE = ROOT / "packages"
SHARED = ("tactogram-study/src/tactogram_study", "tactogram-studio/src/tactogram_studio/pages/studies")
"""Where studies are run, simulated, analysed and shown."""


@pytest.fixture
def recipe(tmp_path, monkeypatch):
    """Write the files of docs/extend-studies.md beside each other, and return its commands."""
    monkeypatch.chdir(tmp_path)
    monkeypatch.setenv(FOLDERS_VARIABLE, "")  # each main() adds to it; undone at the end
    text = (ROOT / "docs/extend-studies.md").read_text(encoding="utf-8")
    [block] = re.findall(r"<!-- own design -->\n(.*?)<!-- /own design -->", text, re.DOTALL)
    *files, (_, commands) = re.findall(r"```(\w+)\n(.*?)```", block, re.DOTALL)
    for _, content in files:
        path = tmp_path / re.match(r"# (mine/\S+)\n", content)[1]
        path.parent.mkdir(exist_ok=True)
        path.write_text(content, encoding="utf-8")
    yield [shlex.split(line, comments=True)[1:] for line in commands.splitlines()]
    sys.modules.pop("pleasantness", None)


@pytest.fixture
def own(recipe, monkeypatch):
    """Return the study of docs/extend-studies.md, whose design is found."""
    monkeypatch.setenv(FOLDERS_VARIABLE, "mine")
    return Study.load("mine/floors.toml")


def test_a_design_of_ones_own_is_used_as_written(recipe, capsys):
    outputs = []
    for command in recipe:
        assert main(command) == 0, command
        outputs.append(capsys.readouterr().out)
    listed, checked, simulated, analysed, power = outputs
    assert re.search(r"pleasantness +pleasantness +pleasantness +How pleasant does it feel\?", listed)
    assert re.search(r"trials:? +12\n", checked)
    assert "12 simulated participants, 156 answers" in simulated
    [line] = [line for line in analysed.splitlines() if "paired t by participant" in line]
    assert line.startswith("  generated minus recorded")
    assert line.endswith("; shown")
    assert "within ±5.000" in line
    assert "paired t" in power
    files = json.loads(Path("lab/result/analysis.json").read_text())["files"]
    assert "pleasantness_pleasant.png" in files


def test_people_can_take_it_and_their_answers_are_kept(own, tmp_path):
    with SessionStore(tmp_path / "session", own) as store:
        participant = store.enrol(language="en")
        store.submit(participant.code, "consent", {"consent": "agreed"})
        while (page := store.page(participant.code)) is not None:
            shown = page.shown("en")
            assert [question["kind"] for question in shown["questions"]] == ["vas"]
            store.submit(participant.code, page.token, {"pleasant": "40"})
    with SessionStore(tmp_path / "session") as again:  # the design is found by what the session holds
        rows = again.answers().where(design="pleasantness")
    assert len(rows) == 12
    assert set(rows.column("value")) == {40.0}


def test_what_was_put_in_is_found_and_nothing_where_nothing_was(own, tmp_path):
    verdicts = {}
    for kind, effect in (("effect", {"shift.generated": -15}), ("none", {})):
        simulate_study("mine/floors.toml", tmp_path / kind, participants=12, effect=effect, seed=1)
        [section] = analyse_study(tmp_path / kind, tmp_path / f"{kind}-result", figures=False)["sections"]
        [decides] = [finding for finding in section["findings"] if finding["role"] == "confirmatory"]
        verdicts[kind] = decides["verdict"]
        if kind == "effect":
            assert decides["low"] < -15 < decides["high"]
    assert verdicts == {"effect": "shown", "none": "equivalent within the margin"}


def test_it_appears_in_the_studio(own, tmp_path):
    entries = workspace_studies(Workspace(tmp_path))
    [entry] = [entry for entry in entries if not entry.shipped]
    assert (entry.title, entry.error) == ("Pleasant floors", "")
    assert entry.question_text == "How pleasant does it feel?"
    assert "Margins: pleasantness ±5 mm" in entry.details
    assert "pleasantness" in power_tables()


def test_two_designs_of_one_name_or_margin_are_refused(own, monkeypatch, tmp_path):
    text = Path("mine/pleasantness.py").read_text(encoding="utf-8")
    for name, content, message in (
        ("second", text, "two designs are called 'pleasantness'"),
        (
            "third",
            text.replace('Literal["pleasantness"] = "pleasantness"', 'Literal["third"] = "third"'),
            "margins",
        ),
        ("empty", "x = 1\n", "must hold a study design, got none"),
        ("broken", "x = \n", "cannot be imported: SyntaxError"),
    ):
        other = tmp_path / f"{name}.py"
        other.write_text(content, encoding="utf-8")
        monkeypatch.setenv(FOLDERS_VARIABLE, f"mine:{other}")
        with pytest.raises(ParameterError, match=message):
            designs()
        sys.modules.pop(name, None)


def test_a_design_behind_an_entry_point_is_found(own, monkeypatch):
    monkeypatch.setenv(FOLDERS_VARIABLE, "")
    monkeypatch.syspath_prepend("mine")
    monkeypatch.setattr(catalogue, "entry_point_modules", lambda group: ["pleasantness"])
    catalogue._designs.cache_clear()
    try:
        assert find_design("pleasantness").title == "Pleasantness"
        assert margin_text("pleasantness", 5) == "pleasantness ±5 mm"
    finally:
        catalogue._designs.cache_clear()


def test_no_shared_source_file_names_a_design():
    kinds = re.compile(rf"(?<![A-Za-z])(?:{'|'.join(designs())})(?![A-Za-z])")
    files = [path for place in SHARED for path in _files(place)]
    assert len(files) > 60
    naming = [str(path.relative_to(SOURCE)) for path in files if kinds.search(_code(path))]
    assert naming == []


def _files(place):
    given = sorted(SOURCE.glob(place))
    found = [path for one in given for path in ([one] if one.is_file() else one.rglob("*"))]
    own = [SOURCE / "tactogram-study/src/tactogram_study" / name for name in ("designs", "statistics.py")]
    return [
        path
        for path in found
        if path.suffix in (".py", ".js", ".css", ".html") and not set(own) & {path, *path.parents}
    ]


def _code(path):
    """Return a file's text; of Python its names and strings, without docstrings and comments."""
    text = path.read_text(encoding="utf-8")
    if path.suffix != ".py":
        return text
    tree = ast.parse(text)
    statements = (node for node in ast.walk(tree) if isinstance(node, ast.Expr))
    prose = {id(node.value) for node in statements if isinstance(node.value, ast.Constant)}
    parts = []
    for node in ast.walk(tree):
        if id(node) not in prose:
            parts += [value for _, value in ast.iter_fields(node) if isinstance(value, str)]
    return "\n".join(parts)
