import re
from pathlib import Path

import pytest

from tactogram.errors import ParameterError
from tactogram_studio.pages.studies.catalogue import (
    _may_be_answers,
    new_session_folder,
    pairs_of,
    power_rows,
    workspace_sessions,
    workspace_studies,
)
from tactogram_studio.study_draft.draft import copy_study
from tactogram_studio.workspace.folder import Workspace
from tactogram_study.study_file import shipped_studies


def test_each_design_is_listed_once_where_the_workspace_holds_the_package():
    folder = shipped_studies()["abx"].parent
    workspace = Workspace(folder.parent.resolve())
    assert len(workspace.studies()) >= len(shipped_studies())

    assert [(one.name, one.shipped) for one in workspace_studies(workspace)] == [
        (name, True) for name in shipped_studies()
    ]


@pytest.mark.parametrize(
    ("beside", "name", "may"),
    [
        ("", "answers.csv", True),
        ("recipe.toml", "metrics.csv", False),
        ("dataset.json", "shard-00000.parquet", False),
        ("", "answers.participants.csv", False),
    ],
)
def test_tables_of_runs_and_stores_are_no_answers(tmp_path, beside, name, may):
    if beside:
        (tmp_path / beside).touch()
    assert _may_be_answers(Path(tmp_path / name)) is may


def test_the_catalogue_lists_every_design_and_what_is_wrong_with_a_file(session, tmp_path):
    workspace = Workspace.at(tmp_path)
    copied = copy_study(workspace, "threshold", "threshold")
    copied.with_name("broken.toml").write_text("[design]\nkind = 'abx'\n")
    bare = re.sub(r"\[analysis.margins.*?(?=\n\[)", "", copied.read_text(encoding="utf-8"), flags=re.S)
    copied.with_name("bare.toml").write_text(bare, encoding="utf-8")
    found = {study.name: study for study in workspace_studies(workspace)}
    assert set(shipped_studies()) < set(found)
    assert found["studies/threshold.toml"].question_text.startswith("How weak")
    assert "Margins: staircase ±3 dB" in found["threshold"].details
    assert "Margins: none, so that equivalence cannot be shown" in found["studies/bare.toml"].details
    assert found["studies/broken.toml"].error
    [one] = workspace_sessions(workspace)
    assert (one.name, one.line) == ("sessions/pilot", "abx: 2 participants, 1 going on, 1 not begun")


def test_a_session_that_cannot_be_opened_is_listed_with_its_reason(tmp_path):
    (tmp_path / "old").mkdir()
    (tmp_path / "old" / "answers.sqlite").write_bytes(b"not a database " * 100)
    [one] = workspace_sessions(Workspace.at(tmp_path))
    assert "answers.sqlite is damaged" in one.error


@pytest.mark.parametrize("name", ["../x", "", "a b", "-a", "x" * 41, "pilot-simulated", "pilot"])
def test_names_of_sessions_that_cannot_be_are_refused(session, tmp_path, name):
    with pytest.raises(ParameterError):
        new_session_folder(Workspace.at(tmp_path), name)


def test_forms_are_read_in_a_line():
    assert pairs_of("participant=subject, value = hit", "headings") == {
        "participant": "subject",
        "value": "hit",
    }
    with pytest.raises(ParameterError, match="headings must be KEY=VALUE, got 'participant'"):
        pairs_of("participant", "headings")
    assert power_rows([{"participants": 10, "power": 0.5}]) == (
        ["participants", "shows the effect"],
        [["10", "0.50"]],
    )
