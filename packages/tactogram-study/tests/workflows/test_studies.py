import pytest

from tactogram_study.study_file import Study
from tactogram_study.workflows.studies import ANSWER_S, CHANGE_S, INTRODUCTION_S, STIMULUS_S, planned_minutes


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
