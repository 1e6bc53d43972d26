from pathlib import Path

import pytest

from tactogram_studio.pages.studies.catalogue import _may_be_answers, workspace_studies
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
