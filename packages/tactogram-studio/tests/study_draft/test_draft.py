"""The editor's form without a page: drafts, their check, fields and stimuli."""

import pytest

from tactogram.errors import DataError, ParameterError
from tactogram_studio.study_draft.draft import StudyDraft, check_draft, copy_study, free_name
from tactogram_studio.study_draft.fields import fields_of
from tactogram_studio.workspace.folder import Workspace
from tactogram_study.designs import designs
from tactogram_study.practice import Practice
from tactogram_study.study_file import Study, shipped_studies
from tactogram_study.workflows.studies import check_study


@pytest.fixture
def workspace(tmp_path):
    return Workspace.at(tmp_path)


@pytest.fixture
def draft(workspace):
    """Give a function that returns the draft of one's own copy of a shipped study."""
    return lambda name: StudyDraft.open(copy_study(workspace, name, free_name(workspace, name)))


@pytest.mark.parametrize("name", shipped_studies())
def test_a_copy_of_each_shipped_study_is_the_same_but_for_its_name(name, draft):
    made = draft(name)
    assert Study.load(name).first_difference(Study.load(made.path)) == "name"
    assert not made.changed
    assert not made.has_comments
    assert check_draft(made).facts["trials"] == Study.load(name).trials


def test_a_copy_in_chosen_languages_keeps_the_other_texts(workspace):
    path = copy_study(workspace, "abx", "mine", languages=["de", "ja"])
    assert Study.load(path).languages == ("de", "ja")
    assert Study.load(path).title.in_language("fr") == Study.load("abx").title.in_language("fr")


def test_a_copy_needs_a_free_and_valid_name(workspace):
    path = copy_study(workspace, "abx", "touch_1")
    assert Study.load(path).name == "touch_1"
    assert copy_study(workspace, path, "touch_2").parent == path.parent
    with pytest.raises(DataError, match=r"studies/touch_1\.toml exists; choose another name"):
        copy_study(workspace, "threshold", "touch_1")
    with pytest.raises(ParameterError, match="name must be 1 to 40 lower-case letters"):
        copy_study(workspace, "abx", "../Touch")
    assert sorted(one.name for one in path.parent.iterdir()) == ["touch_1.toml", "touch_2.toml"]


def test_faults_are_the_sentences_of_check_at_their_places(draft):
    made = draft("abx")
    made.set(("design", "repeats"), 0)
    [fault] = check_draft(made).faults
    assert fault.place == ("design", "repeats")
    made.path.write_text(made.toml)
    with pytest.raises(ParameterError) as checked:
        check_study(made.path)
    assert str(checked.value) == f"{made.path}: {fault.sentence}"


@pytest.mark.parametrize(
    ("place", "value", "found"),
    [
        (("level",), "loud", ("level",)),
        (("display",), "voice-coil", ("grid",)),
        (("seed",), -1, ("seed",)),
        (("practice", "trials"), 99, ("practice",)),
        (("grid", "source"), {"file": "missing.wav"}, ("grid",)),
        (("grid", "source"), "file = ", ("grid", "source")),
        (("grid", "by_condition", "generated"), {"seed": -1}, ("grid", "by_condition", "generated")),
        (
            ("stimuli",),
            [{"name": "a", "run": "r", "given": {"force_n": 0}}],
            ("stimuli", 0, "given", "force_n"),
        ),
        (("title",), {}, ("title",)),
        (("consent", "ja"), "", ("consent", "ja")),
    ],
)
def test_a_fault_is_shown_where_it_is(place, value, found, draft):
    made = draft("abx")
    made.set(place, value)
    assert [fault.place for fault in check_draft(made).faults] == [found]


def test_a_new_language_lists_every_missing_text_at_once(draft):
    made = draft("preference")
    made.set(("languages",), ["en", "tlh"])
    places = [fault.place for fault in check_draft(made).faults]
    assert ("title", "tlh") in places
    assert ("after", 0, "text", "tlh") in places
    assert len(places) == len(set(places))
    models = {"design": designs()["pairwise"], "practice": Practice}
    for *place, language in places:
        model = models.get(place[0]) if len(place) == 2 else None
        default = None if model is None else fields_of(model, only=(place[1],))[0].default
        made.set_text(tuple(place), language, f"tlh {place}", default)
    assert check_draft(made).faults == ()
    assert Study.of(made.values).title.in_language("en") == Study.load("preference").title.in_language("en")


def test_saving_replaces_the_file_and_refuses_what_is_invalid(draft):
    made = draft("abx")
    made.set(("design", "repeats"), 8)
    made.save()
    assert Study.load(made.path).design.repeats == 8
    assert (made.changed, made.overtaken) == (False, False)
    before = made.path.read_bytes()
    made.set(("design", "repeats"), -1)
    with pytest.raises(ParameterError, match="repeats: must be greater"):
        made.save()
    assert made.path.read_bytes() == before
    assert [one.name for one in made.path.parent.iterdir()] == [made.path.name]


def test_a_stored_draft_is_continued_and_knows_of_another_s_change(draft):
    made = draft("abx")
    made.set_text(("title",), "en", "Mine")
    made.path.write_text(f"# by hand\n{made.path.read_text()}")
    again = StudyDraft.open(made.path, made.to_store())
    assert again.text(("title",), "en") == "Mine"
    assert (again.changed, again.overtaken, again.has_comments) == (True, True, True)
