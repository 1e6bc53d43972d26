"""Realism of two areas."""

import numpy as np
import pytest
from scipy.stats import ttest_ind
from simulated_answers import ITEMS, finding, only, simulated

from tactogram.errors import DataError
from tactogram_study.analysis.findings import EQUIVALENT, SHOWN
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


def test_a_gap_in_realism_is_shown_with_its_size_and_its_absence_is_equivalence():
    there = only(analyse(realism(gap=-10.0), plan=AnalysisPlan({"realism": 5.0})))
    [gap] = there.role("confirmatory")
    assert gap.verdict == SHOWN
    assert gap.measure == "generated minus recorded, mm"
    assert gap.low < -10 < gap.high
    assert gap.effect["dz"] < -1
    mixed = finding(there, "all", "linear mixed model")
    assert mixed.estimate == pytest.approx(gap.estimate, abs=0.8)
    [nothing] = only(analyse(realism(gap_sd=1.0), plan=AnalysisPlan({"realism": 5.0}))).role("confirmatory")
    assert nothing.verdict == EQUIVALENT


def test_students_t_stands_beside_as_it_was_printed():
    """Saga et al., Sec. IV-B: "Student's t-test was performed on the pair of data for each texture"."""
    marks = realism(gap=-10.0)
    section = only(analyse(marks))
    printed = section.role("as printed")
    assert [f.of for f in printed] == list(ITEMS)
    assert {f.test for f in printed} == {"Student's t, uncorrected"}
    for finding_ in printed:
        pair = [
            marks.where(stimulus=finding_.of, condition=name).numbers() for name in ("generated", "recorded")
        ]
        assert finding_.p == pytest.approx(ttest_ind(*pair).pvalue)
        assert finding_.estimate == pytest.approx(pair[0].mean() - pair[1].mean())
    assert any("independent" in note for note in section.notes)


def test_realism_needs_two_conditions_and_two_people():
    with pytest.raises(DataError, match="two conditions"):
        analyse(realism().where(condition="recorded"))
    with pytest.raises(DataError, match="two participants"):
        analyse(realism(people=1))
