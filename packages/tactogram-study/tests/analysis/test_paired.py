from dataclasses import replace

import numpy as np
import pytest
from scipy import stats

from tactogram.errors import DataError
from tactogram_study.analysis.findings import EQUIVALENT, SHOWN
from tactogram_study.analysis.paired import analyse_means
from tactogram_study.answers import Answer, Answers


def marks(gap, people=8, trials=5, seed=0):
    """Return marks of simulated participants on two stimuli, ``gap`` higher under the second condition."""
    rng = np.random.default_rng(seed)
    return Answers(
        tuple(
            Answer(
                "small", f"P{who}", design="line", question="pleasant", stimulus=stimulus, condition=condition,
                trial=trial, value=50 + shift + own + rng.normal(), simulated=True,
            )
            for who, own in enumerate(rng.normal(0, 10, people))
            for stimulus in ("cork", "tile")
            for condition, shift in (("a", 0.0), ("b", gap))
            for trial in range(trials)
        )
    )  # fmt: skip


def test_a_mean_and_its_interval_are_over_participants():
    answers = marks(0.0)
    rows = analyse_means(answers, title="Line").tables["means over participants"]
    assert [(row["stimulus"], row["condition"]) for row in rows] == [
        ("cork", "a"),
        ("cork", "b"),
        ("tile", "a"),
        ("tile", "b"),
    ]
    own = [
        group.numbers().mean()
        for group in answers.where(stimulus="cork", condition="a").by("participant").values()
    ]
    low, high = stats.t.interval(0.95, len(own) - 1, np.mean(own), stats.sem(own))
    assert (rows[0]["mean"], rows[0]["low"], rows[0]["high"]) == pytest.approx((np.mean(own), low, high))


def test_conditions_are_compared_by_participant():
    answers = marks(-6.0)
    [there] = analyse_means(answers, title="Line", margin=3.0).role("confirmatory")
    means = [
        [g.where(condition=c).numbers().mean() for g in answers.by("participant").values()] for c in "ab"
    ]
    assert there.p == pytest.approx(stats.ttest_rel(*means).pvalue)
    assert (there.of, there.verdict) == ("a minus b", SHOWN)
    assert there.low < 6.0 < there.high
    [absent] = analyse_means(marks(0.0, seed=1), title="Line", margin=3.0).role("confirmatory")
    assert absent.verdict == EQUIVALENT


def test_one_condition_is_described_and_nothing_is_tested():
    section = analyse_means(marks(0.0).where(condition="a"), title="Line")
    assert section.findings == ()
    assert "nothing is compared" in section.notes[-1]
    with pytest.raises(DataError, match="Line: must have an answer with a number"):
        analyse_means(Answers(tuple(replace(row, value=float("nan")) for row in marks(0.0))), title="Line")
