import pytest

from tactogram_studio.pages.studies.editor.widgets import lines_of, table_of
from tactogram_studio.study_draft.draft import StudyDraft, copy_study, free_name
from tactogram_studio.workspace.folder import Workspace
from tactogram_study.study_file import shipped_studies


@pytest.fixture
def workspace(tmp_path):
    return Workspace.at(tmp_path)


@pytest.fixture
def draft(workspace):
    """Give a function that returns the draft of one's own copy of a shipped study."""
    return lambda name: StudyDraft.open(copy_study(workspace, name, free_name(workspace, name)))


@pytest.mark.parametrize("name", shipped_studies())
def test_a_grids_source_is_the_same_after_its_lines_were_read(name, draft):
    grid = draft(name).get(("grid",), {})
    for table in (grid.get("source", {}), *grid.get("by_condition", {}).values()):
        assert table_of("\n".join(lines_of(table))) == table


def test_lines_of_a_table_can_be_in_any_order():
    lines = lines_of({"words": {"a b": 6}, "run": "texture_flow", "text": {"pt-BR": "x\ny"}})
    assert lines == ['words."a b" = 6', 'run = "texture_flow"', 'text.pt-BR = "x\\ny"']
    assert table_of("\n".join(reversed(lines)))["words"] == {"a b": 6}
    assert table_of("seconds = ") == "seconds = "
    assert table_of("seconds = 2026-01-01") == "seconds = 2026-01-01"
