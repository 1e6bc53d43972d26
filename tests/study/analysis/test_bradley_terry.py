import numpy as np
import pytest
from scipy import special, stats

from tactogram.statistics.clustered import pooled_share
from tactogram.statistics.multiplicity import holm
from tactogram.study.analysis.bradley_terry import bradley_terry, strengths_by_participant
from tactogram.study.answers import Answer, Answers
from tactogram.study.designs.pairwise.analysis import ALIKE, APART, analyse_preference
from tactogram.study.designs.pairwise.power import (
    ComparisonCounts,
    _holm_above,
    _presented,
    jackknifed,
    shown_and_equal,
    simulated_preferences,
)


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


def test_holm_of_many_studies_is_that_of_each():
    t = np.random.default_rng(3).normal(1.5, 2.0, (40, 6))
    t[0] = 9.0  # all are shown
    ps = stats.t.sf(t, 9)
    assert (_holm_above(t, 9, 0.05) == (np.array([holm(row) for row in ps]) < 0.05)).all()


@pytest.mark.parametrize(("people", "comparisons", "items"), [(5, 30, 20), (2, 3, 6), (7, 40, 6), (3, 12, 6)])
def test_studies_without_tables_are_as_those_with_tables_of_each_participant(people, comparisons, items):
    rng = np.random.default_rng(4)
    first, second = np.triu_indices(items, 1)
    place, asked = _presented(comparisons, len(first), (3, people), rng)
    won = rng.binomial(asked, 0.7)
    one, other = first[place], second[place]
    tables = np.zeros((3, people, items, items))
    study, person, _ = np.indices(one.shape)
    tables[study, person, one, other], tables[study, person, other, one] = won, asked - won
    assert (tables.sum((2, 3)) == comparisons).all()
    assert len(np.unique(place[0, 0])) == min(comparisons, len(first))
    strengths, covariance = strengths_by_participant(tables)
    found, error = jackknifed(ComparisonCounts(one, other, asked, won, items))
    assert found == pytest.approx(strengths)
    centre = np.eye(items) - 1 / items
    assert centre @ error @ centre == pytest.approx(covariance, rel=1e-4, abs=1e-6)


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
