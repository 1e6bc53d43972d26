import pytest

from tactogram_studio.study_draft.draft import StudyDraft, copy_study, free_name
from tactogram_studio.study_draft.fields import fields_of
from tactogram_studio.workspace.folder import Workspace
from tactogram_study.designs import designs
from tactogram_study.study_file import Study


@pytest.fixture
def workspace(tmp_path):
    return Workspace.at(tmp_path)


@pytest.fixture
def draft(workspace):
    """Give a function that returns the draft of one's own copy of a shipped study."""
    return lambda name: StudyDraft.open(copy_study(workspace, name, free_name(workspace, name)))


def test_a_text_is_changed_in_one_language_and_stays_in_the_others(draft):
    made, place = draft("two-area"), ("design", "which")
    [default] = [field.default for field in fields_of(designs()["two_area"], only=("which",))]
    assert made.get(place) is None
    made.set_text(place, "en", "Which one was made?", default)
    changed = Study.of(made.values).design.which
    assert changed.in_language("en") == "Which one was made?"
    assert changed.in_language("ja") == "生成された触感はどちらですか。"


@pytest.mark.parametrize("kind", designs())
def test_each_setting_of_a_design_has_a_field(kind):
    elsewhere = {"kind", "words", "word_texts", "pairs"}
    fields = {field.key: field for field in fields_of(designs()[kind], ("design",))}
    assert set(fields) == set(designs()[kind].model_fields) - elsewhere
    assert all(not field.help or field.help.endswith(".") for field in fields.values())
