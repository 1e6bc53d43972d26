import numpy as np
import pytest

from tactogram_study.session.progress import answer_rows, next_page
from tactogram_study.study_file import Study
from tactogram_study.trials import PageAnswers, Participant

KINDS = ("two_area", "rating", "evoked", "abx", "staircase", "magnitude", "pairwise")
ANYBODY = Participant("P1", 1)


@pytest.mark.parametrize("kind", KINDS)
def test_a_design_asks_to_its_end_and_each_answer_makes_a_row(make_study, kind, taken, trials):
    study = make_study(kind)
    pages, given = taken(study)
    assert [page.token for page in pages][:2] == ["consent", "before"]
    assert pages[-1].token == "after"
    asked = trials(pages)
    assert len({page.token for page in pages}) == len(pages)
    assert max(page.trial for page in asked) <= study.trials
    if kind != "staircase":
        assert max(page.trial for page in asked) == study.trials
    for page, one in zip(asked, given[2:], strict=False):
        rows = answer_rows(study, ANYBODY, page, one.responses, at="")
        assert len(rows) == len(page.questions)
        assert {row.design for row in rows} == {kind}
        assert all(np.isfinite(row.value) for row in rows)


@pytest.mark.parametrize("kind", KINDS)
def test_resuming_is_replaying_the_answers(make_study, kind, taken):
    study = make_study(kind)
    pages, given = taken(study)
    again = make_study(kind)
    for done, page in enumerate(pages):
        assert next_page(again, ANYBODY, given[:done]) == page
    assert next_page(again, ANYBODY, given) is None


@pytest.mark.parametrize("kind", KINDS)
def test_a_participant_is_shown_no_name_and_no_right_answer(make_study, kind, taken, trials):
    pages, _ = taken(make_study(kind))
    for page in trials(pages):
        shown = str(page.shown("en"))
        names = [p.stimulus.name for p in page.presented if p.stimulus]
        assert not [name for name in (*names, "generated'", "recorded", "expected_bits") if name in shown]


def test_who_declines_is_asked_nothing(make_study):
    assert next_page(make_study(), ANYBODY, [PageAnswers("consent", {"consent": "declined"})]) is None


def test_a_rest_is_offered_after_so_many_trials(make_study, taken):
    pages, _ = taken(make_study("two_area", rest_every=2))
    assert [page.trial for page in pages if page.rest] == [3]


def test_counterbalanced_orders_differ_by_participant_and_cover_each_place():
    study = Study.load("magnitude", changes={"design.repeats": 1, "practice": None})
    first = []
    for number in range(1, 7):
        participant = Participant(f"P{number}", number)
        first.append(
            next_page(study, participant, [PageAnswers("consent", {"consent": "agreed"})])
            .questions[0]
            .stimulus
        )
    assert len(set(first)) == 6
