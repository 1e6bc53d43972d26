"""Discrimination: whether generated is told from recorded, by participant."""

import numpy as np
from simulated_answers import only, simulated, which

from tactogram_study.analysis.findings import EQUIVALENT, NOT_SHOWN, SHOWN, UNDECIDED
from tactogram_study.planned import AnalysisPlan
from tactogram_study.statistics import pooled_share, share_of
from tactogram_study.study_analysis import analyse


def test_the_texture_table_counts_the_people_at_chance():
    """Saga et al., Sec. IV-B: "7 out of 10 people showed a correct answer rate of 50%"."""
    right = {0: 5, 1: 8, 2: 9, 3: 10, 4: 1}
    rows = [
        (p, t + 1, {"stimulus": "cork", "value": float(t < count), "correct": t < count})
        for p, count in right.items()
        for t in range(10)
    ]
    answers = simulated("two_area", "which", rows)
    [row] = only(analyse(answers)).tables["share correct per texture"]
    assert row["at_chance"] == "2 of 5"  # of 10 answers, 9 or more and 1 or fewer differ from one half at .05
    section = only(analyse(answers, plan=AnalysisPlan({}, alpha=0.005)))
    assert section.tables["share correct per texture"][0]["at_chance"] == "4 of 5"
    [note] = [note for note in section.notes if note.startswith("at chance")]
    assert "exact binomial" in note
    assert "p >= 0.005" in note


def test_an_effect_on_which_is_generated_is_shown_and_its_absence_is_equivalence():
    [there] = only(analyse(which(logit=0.8))).role("confirmatory")
    assert there.verdict == SHOWN
    assert there.low < 1 / (1 + np.exp(-0.8)) < there.high
    absent = which(trials=90, sd=0.1)
    [nothing] = only(analyse(absent, plan=AnalysisPlan({"which": 0.1}))).role("confirmatory")
    assert nothing.verdict == EQUIVALENT
    [without] = only(analyse(absent)).role("confirmatory")
    assert without.verdict == NOT_SHOWN


def test_ten_trials_are_undecided():
    section = only(analyse(which(people=1, trials=10, seed=1), plan=AnalysisPlan({"which": 0.1})))
    [one] = section.role("confirmatory")
    assert (one.verdict, one.participants) == (UNDECIDED, 1)
    assert "one participant" in one.note
    assert [row["verdict"] for row in section.tables["share correct per texture"]] == [UNDECIDED] * 3


def test_the_default_test_errs_less_than_that_of_all_answers_where_people_differ():
    sound = printed = 0
    for seed in range(20):
        answers = which(people=8, trials=60, sd=0.9, seed=seed)
        hits = answers.numbers()
        sound += pooled_share(hits, answers.column("participant")).p < 0.05
        printed += share_of(int(hits.sum()), len(hits)).p < 0.05
    assert sound <= 4 < printed


def test_abx_gives_the_d_prime_of_abx():
    section = only(analyse(which(logit=0.8, design="abx")))
    assert section.title.startswith("ABX")
    assert section.role("confirmatory")[0].effect["d'"] > 1.3  # 2AFC would be 0.7
    assert not section.role("as printed")
