import pytest

from tactogram.errors import DataError, ParameterError
from tactogram_study.study_file import Study, shipped_studies
from tactogram_study.workflows.studies import (
    ANSWER_S,
    CHANGE_S,
    INTRODUCTION_S,
    STIMULUS_S,
    copy_study,
    planned_minutes,
)


def test_a_session_s_length_counts_trials_practice_stimuli_and_questions():
    study = Study.load("abx")
    trial = CHANGE_S + 3 * (CHANGE_S + 1.0) + ANSWER_S["choice"]  # A, B and X of 1 s
    expected = INTRODUCTION_S + ANSWER_S["text"] + (48 + 4) * trial
    assert planned_minutes(study) == pytest.approx(expected / 60)


def test_every_page_of_a_trial_counts_and_so_does_a_stimulus_of_unknown_length():
    changes = {"grid.source": {"text": "Touch {item}."}, "grid.by_condition": {}, "after": [], "before": []}
    study = Study.load("two-area", changes=changes)
    choice = CHANGE_S + 2 * (CHANGE_S + STIMULUS_S) + ANSWER_S["choice"]
    realism = CHANGE_S + 2 * (CHANGE_S + STIMULUS_S) + 2 * ANSWER_S["vas"]
    assert planned_minutes(study) == pytest.approx((INTRODUCTION_S + 90 * (choice + realism)) / 60)


@pytest.mark.parametrize("name", shipped_studies())
def test_a_copy_keeps_the_comments_and_has_a_name_of_its_own(name, tmp_path):
    path = tmp_path / "my-pilot.toml"
    assert copy_study(name, out=path) == {"study": str(path), "name": "my_pilot"}
    study, original = Study.load(path), Study.load(name)
    assert (study.name, study.trials, study.title) == ("my_pilot", original.trials, original.title)
    assert path.read_text().splitlines()[0] == shipped_studies()[name].read_text().splitlines()[0]
    with pytest.raises(DataError, match="exists; choose another name"):
        copy_study(name, out=path)
    with pytest.raises(ParameterError, match=r"out must end in .toml, after .*, got 'My pilot.txt'"):
        copy_study(name, out=tmp_path / "My pilot.txt")
