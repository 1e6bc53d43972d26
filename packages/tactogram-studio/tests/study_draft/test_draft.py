"""The editor's form without a page: drafts, their check, fields and stimuli."""

import numpy as np
import pytest

from tactogram.errors import DataError, ParameterError
from tactogram.signal import Signal
from tactogram.signal.io import read_metadata
from tactogram_studio.pages.studies.editor.widgets import lines_of, table_of
from tactogram_studio.study_draft.draft import StudyDraft, check_draft, copy_study, free_name
from tactogram_studio.study_draft.fields import fields_of, text_default
from tactogram_studio.study_draft.stimuli import (
    listed,
    named_keys,
    place_signal,
    stimulus_names,
    summary,
    with_source,
)
from tactogram_studio.workspace.folder import Workspace
from tactogram_studio.workspace.shelf import ResultArchive, SignalSources
from tactogram_study.designs import designs
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


def test_a_text_is_changed_in_one_language_and_stays_in_the_others(draft):
    made, place = draft("two-area"), ("design", "which")
    default = text_default("two_area", place)
    assert made.get(place) is None
    made.set_text(place, "en", "Which one was made?", default)
    changed = Study.of(made.values).design.which
    assert changed.in_language("en") == "Which one was made?"
    assert changed.in_language("ja") == "生成された触感はどちらですか。"


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
    for place in places:
        made.set_text(place[:-1], "tlh", f"tlh {place}", text_default("pairwise", place[:-1]))
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


@pytest.mark.parametrize("name", ["two-area", "display-words", "reconstruction"])
def test_a_grid_listed_one_by_one_has_the_same_stimuli_and_names(name, draft):
    made, before = draft(name), Study.load(name)
    listed(made)
    after = Study.of(made.values)
    assert after.all_stimuli == before.all_stimuli
    assert after.display_names == before.display_names
    assert stimulus_names(made) == [stimulus.name for stimulus in before.all_stimuli]
    assert set(named_keys(made)) == set(after.display_names)


def test_a_large_grid_is_not_listed(draft):
    made = draft("evoked-words")
    with pytest.raises(ParameterError, match="320 stimuli are too many to list one by one"):
        listed(made)
    assert made.get(("grid", "count")) == 320


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


def test_another_source_takes_the_place_of_the_former_and_its_settings():
    former = {"name": "a", "simulated": "stroking9/tile", "autoregressive": True, "seconds": 1.0}
    assert with_source(former, "file", "a.wav") == {"name": "a", "seconds": 1.0, "file": "a.wav"}
    other = with_source(former, "simulated", "stroking9/cloth")
    assert other == former | {"simulated": "stroking9/cloth"}
    assert summary(other) == "simulated stroking9/cloth, from an autoregressive model of it, 1 s"


def test_a_kept_result_is_copied_beside_the_study_and_a_file_is_not(workspace, draft):
    made, shelf = draft("abx"), ResultArchive(workspace.studio_folder / "kept")
    kept = shelf.keep(Signal(np.ones(100), 1000.0, "1"), title="cork / tile", facts={"simulated": True})
    copied = place_signal(workspace, made.path, SignalSources(workspace, shelf).select(f"kept:{kept.id}"))
    shelf.remove(kept.id)
    assert copied.startswith("my_abx_stimuli/cork_-_tile-")
    assert read_metadata(made.path.parent / copied) == {"simulated": True}
    (workspace.folder / "own.csv").write_text("time,x\n0,1\n0.1,2\n")
    own = SignalSources(workspace, shelf).select("file:own.csv")
    assert place_signal(workspace, made.path, own) == "../own.csv"


@pytest.mark.parametrize("kind", designs())
def test_each_setting_of_a_design_has_a_field(kind):
    elsewhere = {"kind", "words", "word_texts", "pairs"}
    fields = {field.key: field for field in fields_of(designs()[kind], ("design",))}
    assert set(fields) == set(designs()[kind].model_fields) - elsewhere
    assert all(not field.help or field.help.endswith(".") for field in fields.values())
