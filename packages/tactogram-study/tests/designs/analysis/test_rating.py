"""Errors of words between conditions."""

import numpy as np
import pytest
from simulated_answers import finding, only, simulated

from tactogram.errors import DataError
from tactogram_study.analysis.findings import EQUIVALENT, SHOWN, UNDECIDED
from tactogram_study.planned import AnalysisPlan
from tactogram_study.study_analysis import analyse


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


def test_smaller_errors_of_words_are_shown_by_participant():
    answers, targets = scores({"none": 2.2, "1": 1.0, "5,000": 0.6})
    section = only(analyse(answers, plan=AnalysisPlan({"rating": 0.2}, targets=targets, draws=200)))
    assert finding(section, "all words", "Friedman").verdict == SHOWN
    assert finding(section, "none minus 5,000", "Wilcoxon", "confirmatory").estimate > 0.5
    assert (
        finding(section, "rough, none minus 5,000", "Steel-Dwass", "as printed").correction == "Steel-Dwass"
    )
    overall, words = section.tables.values()
    assert [row["condition"] for row in overall] == ["none", "1", "5,000"]
    assert all(row["low"] < row["mean"] < row["high"] for row in (*overall, *words))
    none = np.concatenate(
        [[abs(r.value - targets[r.stimulus][r.question]) for r in answers.where(condition="none")]]
    )
    assert overall[0]["mean"] == pytest.approx(none.mean())
    assert overall[0]["se_as_printed"] == pytest.approx(none.std(ddof=1) / np.sqrt(len(none)))


def test_errors_that_do_not_differ_are_not_shown_to():
    answers, targets = scores({"none": 1.2, "5,000": 1.2}, seed=2)
    found = only(analyse(answers, plan=AnalysisPlan({"rating": 0.3}, targets=targets, draws=100)))
    assert finding(found, "none minus 5,000", "Wilcoxon", "confirmatory").verdict in (EQUIVALENT, UNDECIDED)
    loose = only(analyse(answers, plan=AnalysisPlan({"rating": 1.0}, targets=targets, draws=100)))
    assert finding(loose, "none minus 5,000", "Wilcoxon", "confirmatory").verdict == EQUIVALENT


def test_a_condition_can_be_what_the_others_are_held_against():
    answers, _ = scores({"plates": 0.5, "a": 0.6, "b": 2.0})
    section = only(analyse(answers, plan=AnalysisPlan({}, reference="plates", draws=100)))
    assert finding(section, "a minus b", "Wilcoxon").verdict == SHOWN
    with pytest.raises(DataError, match="one of the conditions plates, a, b"):
        analyse(answers, plan=AnalysisPlan({}, reference="sensor", draws=100))
    with pytest.raises(DataError, match="must have a score of 'plate0' for 'rough'"):
        analyse(answers, plan=AnalysisPlan({}, targets={"other": {}}, draws=100))
