import numpy as np
import pytest
from scipy import special, stats

from tactogram_study.answers import Answer, Answers
from tactogram_study.designs.analysis.pairwise import (
    ALIKE,
    APART,
    analyse_preference,
    shown_and_equal,
    simulated_preferences,
)
from tactogram_study.designs.pairwise import bradley_terry, strengths_by_participant
from tactogram_study.statistics import pooled_share


def test_of_two_items_the_error_is_that_of_a_share_by_participant():
    rng = np.random.default_rng(0)
    won = rng.binomial(8, 0.6, 15)
    tables = np.zeros((15, 2, 2))
    tables[:, 0, 1], tables[:, 1, 0] = won, 8 - won
    strengths, covariance = strengths_by_participant(tables, prior_sd=1e3)
    answers = np.concatenate([[1.0] * k + [0.0] * (8 - k) for k in won])
    share = pooled_share(answers, np.repeat(np.arange(15), 8).tolist())
    gap = strengths[0] - strengths[1]
    error = np.sqrt(covariance[0, 0] + covariance[1, 1] - 2 * covariance[0, 1])
    assert special.expit(gap) == pytest.approx(share.estimate, rel=1e-4)
    assert gap / error == pytest.approx(share.statistic, rel=0.04)


def test_many_studies_are_each_as_alone():
    tables = np.random.default_rng(1).integers(0, 4, (3, 6, 4, 4)) * (1 - np.eye(4))
    strengths, covariance = strengths_by_participant(tables)
    for k, one in enumerate(tables):
        alone, error = strengths_by_participant(one)
        assert strengths[k] == pytest.approx(alone)
        assert covariance[k] == pytest.approx(error)
        assert alone == pytest.approx(bradley_terry(one.sum(0)))


def test_the_error_is_the_spread_of_the_estimates():
    rng = np.random.default_rng(2)
    options = {"items": 4, "effect": 0.8, "person_sd": 0.5, "studies": 300, "rng": rng}
    [(gaps, errors)] = list(simulated_preferences(20, 30, **options))
    assert gaps[:, 0].std() == pytest.approx(np.sqrt((errors[:, 0] ** 2).mean()), rel=0.12)
    assert gaps[:, 3].mean() == pytest.approx(0.0, abs=0.06)
    shown, equal = shown_and_equal(gaps, errors, people=20, margin=0.5, alpha=0.05)
    assert not (shown & equal).any()
    assert shown[:, :3].mean() > 0.5 > shown[:, 3:].mean()


def compared(*answered):
    """Return answers about pairs, from who, first item, second item, and what share preferred the first."""
    return Answers(
        tuple(
            Answer("s", who, design="pairwise", stimulus=first, other=second, value=value)
            for who, first, second, value in answered
        )
    )


def test_items_that_were_never_compared_are_not_called_equivalent():
    people = ("P1", "P2", "P3")
    won = [(who, first, second, 1.0) for who in people for first, second in ("AB", "CD")]
    lost = [(who, first, second, 0.0) for who in people[1:] for first, second in ("AB", "CD")]
    found = {f.of: f for f in analyse_preference(compared(*won, *lost), margin=0.7).role("confirmatory")}
    apart = found["A over C"]  # as strong to the prior, and without error
    assert (apart.estimate, apart.p, apart.equivalence_p, apart.low, apart.verdict) == (
        0,
        None,
        None,
        None,
        "",
    )
    assert apart.note == APART
    assert found["A over B"].p is not None


def test_participants_who_all_say_the_same_leave_the_error_of_independent_answers():
    both = [(who, "A", "B", value) for who in ("P1", "P2") for value in (0.0, 1.0)]
    said = analyse_preference(compared(*both), margin=0.7)
    [found] = said.role("confirmatory")
    assert found.high == pytest.approx(stats.t.isf(0.025, 1) * np.sqrt(1 / (1 / 18 + 1)))
    assert (found.verdict, found.note) == ("undecided", ALIKE)
    [strengths] = said.tables.values()
    assert [row["high"] for row in strengths] == pytest.approx(
        [found.high / 2] * 2
    )  # half of the difference each
    options = {"items": 30, "effect": 0.0, "person_sd": 0.0, "studies": 20, "rng": np.random.default_rng(0)}
    for gaps, errors in simulated_preferences(2, 1, **options):  # most items are never asked about
        assert not any(of.any() for of in shown_and_equal(gaps, errors, people=2, margin=0.7, alpha=0.05))
