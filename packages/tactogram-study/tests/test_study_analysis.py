import json
from dataclasses import replace

import numpy as np
import pytest
from simulated_answers import ITEMS, finding, only, simulated, which

from tactogram.errors import DataError, ParameterError
from tactogram_study.analysis.findings import EQUIVALENT, NOT_SHOWN, SHOWN, UNDECIDED
from tactogram_study.answers import Answers
from tactogram_study.designs import find_design
from tactogram_study.designs.analysis.pairwise import bradley_terry
from tactogram_study.planned import AnalysisPlan
from tactogram_study.study_analysis import analyse


def realism(people=10, marks=20, gap=0.0, gap_sd=3.0, seed=0):
    rng = np.random.default_rng(seed)
    rows = []
    for p in range(people):
        level, own = 55 + 8 * rng.standard_normal(), gap + gap_sd * rng.standard_normal()
        for t in range(marks):
            for condition, shift in (("generated", own), ("recorded", 0.0)):
                value = float(np.clip(level + shift + 10 * rng.standard_normal(), 0, 100))
                rows.append((p, t + 1, {"stimulus": ITEMS[t % 3], "condition": condition, "value": value}))
    return simulated("two_area", "realism", rows)


def scores(noise, people=12, items=4, seed=0):
    """Return scores of two words, and the targets they scatter around, by condition."""
    rng = np.random.default_rng(seed)
    targets = {f"plate{k}": {"rough": float(2 + k), "dry": 4.0} for k in range(items)}
    rows = []
    for p in range(people):
        for condition, sd in noise.items():
            for item, words in targets.items():
                for word, target in words.items():
                    value = float(np.clip(np.round(target + sd * rng.standard_normal()), 1, 7))
                    rows.append(
                        (p, 1, {"question": word, "condition": condition, "stimulus": item, "value": value})
                    )
    return simulated("rating", "", rows), targets


def pairs(strengths, people=10, seed=0):
    rng = np.random.default_rng(seed)
    rows = []
    for p in range(people):
        t = 0
        for a in range(len(strengths)):
            for b in range(a + 1, len(strengths)):
                for _ in range(3):
                    t += 1
                    first = float(rng.random() < 1 / (1 + np.exp(strengths[b] - strengths[a])))
                    rows.append((p, t, {"stimulus": f"s{a}", "other": f"s{b}", "value": first}))
    return simulated("pairwise", "preferred", rows)


def test_what_is_preferred_is_shown_and_what_is_not_is_not():
    section = only(analyse(pairs([1.5, 0.0, 0.0]), plan=AnalysisPlan({}, draws=400)))
    verdicts = {f.of: f.verdict for f in section.role("confirmatory")}
    assert verdicts == {"s0 over s1": SHOWN, "s0 over s2": SHOWN, "s1 over s2": NOT_SHOWN}
    assert (
        finding(section, "s0 over s1", "Bradley-Terry").low
        < 1.5
        < finding(section, "s0 over s1", "Bradley-Terry").high
    )


def test_preferences_that_are_as_good_as_equal_take_a_margin():
    answers = pairs([0.0, 0.0], people=40, seed=1)
    wide, narrow = (
        only(analyse(answers, plan=AnalysisPlan({"preference": margin}, draws=400))).role("confirmatory")[0]
        for margin in (1.0, 0.05)
    )
    assert (wide.verdict, narrow.verdict) == (EQUIVALENT, UNDECIDED)
    assert wide.margin == 1.0
    shown = only(analyse(pairs([1.5, 0.0]), plan=AnalysisPlan({"preference": 0.4}, draws=400))).role(
        "confirmatory"
    )
    assert shown[0].verdict == SHOWN


def test_strengths_are_those_of_the_choices_and_stay_finite():
    wins = np.array([[0, 30, 40], [10, 0, 25], [5, 15, 0]], float)
    strengths = bradley_terry(wins, prior_sd=100)
    expected = 1 / (1 + np.exp(strengths[None, :] - strengths[:, None]))
    total = wins + wins.T
    assert (expected * total).sum(1) - np.diag(expected * total) == pytest.approx(wins.sum(1), abs=1e-2)
    assert np.isfinite(bradley_terry(np.array([[0, 9], [0, 0]], float))).all()


@pytest.mark.parametrize(
    "answers",
    [
        which(people=3, trials=6),
        realism(people=3, marks=6),
        scores({"a": 1.0, "b": 1.5}, people=3)[0],
        pairs([1, 0], people=3),
    ],
    ids=["which", "realism", "rating", "pairwise"],
)
def test_an_analysis_is_json_text_and_figures_that_say_simulated(answers):
    found = analyse(
        answers, plan=AnalysisPlan({}, draws=100 if answers.rows[0].design != "pairwise" else 400)
    )
    plain = json.loads(json.dumps(found.as_dict(), allow_nan=False))
    assert plain["simulated"] is True
    assert "simulated participants" in found.text()
    for section in found.sections:
        for figure in find_design(section.design).figures(section, answers).values():
            figure.draw_without_rendering()
            said = [axes.get_title() for axes in figure.axes] + [figure.get_suptitle()]
            assert any("simulated participants" in title for title in said)


def changed(answers, **values):
    return Answers(tuple(replace(row, **values) for row in answers))


TWO = which(people=2)


@pytest.mark.parametrize(
    ("answers", "words"),
    [
        (Answers(), "must hold trials"),
        (changed(TWO, design="maze"), "design must be one of"),
        (Answers((*TWO, *TWO)), "appears twice"),
        (Answers((*TWO, *changed(TWO, study="other"))), "of one study"),
        (Answers((*TWO, *changed(TWO, simulated=False))), "simulated participants and of people"),
        (changed(realism(people=2), value=float("nan")), "answer with a number"),
    ],
)
def test_answers_that_cannot_be_analysed_are_refused_in_a_line(answers, words):
    with pytest.raises(DataError, match=words):
        analyse(answers)


@pytest.mark.parametrize(
    ("plan", "words"),
    [
        ({"margins": {"speed": 1.0}}, "a margin must be for one of"),
        ({"margins": {"which": 0.0}}, "must be > 0"),
        ({"margins": {}, "targets": {}, "reference": "a"}, "got both"),
        ({"margins": {}, "draws": 10}, "draws must be at least 100"),
    ],
)
def test_a_plan_that_cannot_be_is_refused(plan, words):
    with pytest.raises(ParameterError, match=words):
        analyse(Answers(TWO), plan=AnalysisPlan(**plan))
