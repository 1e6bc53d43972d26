import pytest

from tactogram.errors import ParameterError
from tactogram_study.analysis.findings import (
    EQUIVALENT,
    NOT_SHOWN,
    with_verdicts,
)
from tactogram_study.answers import Answer, Answers
from tactogram_study.designs import find_design
from tactogram_study.designs.catalogue import margin_text
from tactogram_study.planned import AnalysisPlan, PlannedAnalysis, changed_margins
from tactogram_study.study_analysis import analyse, plan_lines
from tactogram_study.study_file import Study, shipped_studies


def discrimination(hits, *, practice=0):
    """Return answers of eight simulated participants: so many of 100 are right, and some to practice trials."""
    rows = [
        Answer(
            "small", f"S{person}", design="abx", question="which", stimulus="cork", answer="A", side="A",
            trial=trial + 1, value=float(trial < hits + person % 3 - 1), simulated=True,
        )
        for person in range(8)
        for trial in range(100)
    ]  # fmt: skip
    rows += [
        Answer(
            "small",
            "S1",
            design="practice",
            question="which",
            answer="A",
            value=0.0,
            more={"practice": "abx"},
        )
    ] * practice
    return Answers(tuple(rows))


def decided(answers, plan):
    [section] = analyse(answers, plan=plan).sections
    return section.role("confirmatory")[0]


def test_a_margin_of_the_file_decides_and_is_said_to_be_given_beforehand():
    planned = PlannedAnalysis.model_validate({"margins": {"abx": {"value": 0.1, "because": "six of ten"}}})
    plan = AnalysisPlan.of(planned)
    assert decided(discrimination(50), plan).verdict == EQUIVALENT
    assert plan.deviations == {}
    [margins, alpha] = plan_lines(plan)
    assert (
        margins
        == "Margins, given beforehand in the study's file: abx ±0.1 of the share correct (six of ten)."
    )
    assert alpha == "Alpha 0.05 (beforehand); intervals are of 95 %."


def test_a_margin_that_differs_is_reported_as_given_afterwards():
    plan = AnalysisPlan.of(PlannedAnalysis.model_validate({"margins": {"abx": 0.001}}), {"abx": 0.1})
    found = decided(discrimination(50), plan)
    assert (found.verdict, found.margin) == (EQUIVALENT, 0.1)
    assert "margin given afterwards" in found.note
    assert plan.deviations == {"abx": 0.1}
    assert any("afterwards, not as in the study's file: abx ±0.1" in line for line in plan_lines(plan))
    assert analyse(discrimination(50), plan=plan).as_dict()["given_afterwards"] == {"abx": 0.1}


def test_without_the_study_nobody_knows_when_a_margin_was_given():
    plan = AnalysisPlan({"abx": 0.1})
    assert "Whether that was beforehand cannot be seen" in plan_lines(plan)[0]
    assert analyse(discrimination(50), plan=plan).as_dict()["margins_beforehand"] is None


def test_without_a_margin_a_large_p_says_that_nothing_is_shown():
    analysis = analyse(discrimination(50), plan=AnalysisPlan.of(PlannedAnalysis()))
    assert analysis.sections[0].role("confirmatory")[0].verdict == NOT_SHOWN
    assert "gives no margin: nothing can be equivalent" in analysis.text()
    assert "no difference" not in analysis.text().casefold()


def test_judging_at_the_same_alpha_changes_no_verdict():
    section = analyse(discrimination(58), plan=AnalysisPlan({"abx": 0.1})).sections[0]
    assert [f.verdict for f in with_verdicts(section).findings] == [f.verdict for f in section.findings]


def test_practice_is_left_out_and_counted():
    answers = discrimination(50, practice=3)
    analysis = analyse(answers, plan=AnalysisPlan({}))
    assert analysis.sections[0].answers == 800
    assert "3 answers to practice trials are left out" in analysis.notes


@pytest.mark.parametrize(
    ("design", "table", "message"),
    [
        ("abx", {"margins": {"which": 0.1}}, "design abx takes margins for abx, got 'which'"),
        (
            "pairwise",
            {"margins": {"which": 0.1}},
            "design pairwise takes margins for preference, got 'which'",
        ),
        ("abx", {"margins": {"abx": 0.5}}, "must be below 0.5"),
        ("abx", {"margins": {"abx": -1}}, "greater than 0"),
        ("abx", {"alpha": 0.9}, "less than or equal to 0.2"),
        ("abx", {"alfa": 0.05}, "alfa"),
    ],
)
def test_a_plan_that_cannot_be_is_refused_in_a_line(make_study, design, table, message):
    with pytest.raises(ParameterError, match=message) as caught:
        make_study(design, analysis=table)
    assert "\n" not in str(caught.value)


def test_margins_are_part_of_the_studys_hash(make_study):
    hashes = {
        make_study(analysis=table).sha256
        for table in (None, {"margins": {"abx": 0.1}}, {"margins": {"abx": 0.2}})
    }
    assert len(hashes) == 3


def test_each_shipped_design_that_takes_a_margin_has_one_with_a_reason():
    for name in shipped_studies():
        study = Study.load(name)
        compared = len({stimulus.condition for stimulus in study.all_stimuli}) > 1
        for margin in study.planned.margins.values():
            assert margin.because, name
        if study.design.kind != "rating" or compared:
            assert study.planned.margins, name


def test_names_of_margins():
    asked = {
        ("two_area", "which"): "which",
        ("rating", "words"): "rating",
        ("pairwise", "preferred"): "preference",
    }
    assert {key: find_design(key[0]).margin_for(key[1]) for key in asked} == asked
    assert find_design("two_area").margin_for("else") == ""
    assert margin_text("realism", 5) == "realism ±5 mm"
    assert changed_margins({"a": 0.1 + 0.2, "b": 1}, {"a": 0.3}) == {"b": 1}
