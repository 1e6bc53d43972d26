import numpy as np
import pytest
from scipy import special, stats

from tactogram.errors import ParameterError
from tactogram.statistics.comparison import paired_equivalence, pseudomedian, signed_rank_p
from tactogram_study.statistics import (
    abx_share,
    bootstrap_by_participant,
    corrected,
    d_prime_2afc,
    d_prime_abx,
    exact_ps,
    mixed_difference,
    pooled_share,
    share_equivalence,
    share_equivalence_power,
    share_of,
    smallest_significant,
)


@pytest.mark.parametrize(
    ("n", "needed", "half"),
    [
        (10, 9, 0.263),
        (20, 15, 0.201),
        (60, 39, 0.123),
        (100, 61, 0.096),
        (200, 115, 0.069),
        (400, 221, 0.049),
    ],
)
def test_so_many_answers_are_needed_to_tell_a_share_from_chance(n, needed, half):
    assert smallest_significant(n) == needed
    low, high = share_of(n // 2, n).wilson
    assert (high - low) / 2 == pytest.approx(half, abs=5e-4)


@pytest.mark.parametrize(
    ("margin", "n", "power"),
    [
        (0.10, 50, 0.0),
        (0.10, 100, 0.24),
        (0.10, 150, 0.54),
        (0.10, 200, 0.77),
        (0.10, 250, 0.85),
        (0.10, 300, 0.93),
        (0.15, 100, 0.81),
        (0.15, 150, 0.96),
    ],
)
def test_equivalence_of_shares_has_the_power_that_was_calculated(margin, n, power):
    assert share_equivalence_power(n, margin=margin) == pytest.approx(power, abs=5e-3)


def test_power_of_equivalence_is_how_often_the_test_shows_it():
    shown = [share_equivalence(k, 100, margin=0.1) < 0.05 for k in range(101)]
    likely = stats.binom.pmf(np.arange(101), 100, 0.5)
    assert share_equivalence_power(100, margin=0.1) == pytest.approx(likely[shown].sum())
    assert not any(share_equivalence(k, 50, margin=0.1) < 0.05 for k in range(51))


@pytest.mark.parametrize(("n", "chance"), [(1, 0.5), (10, 0.5), (37, 0.3), (40, 0.5)])
def test_every_counts_p_is_that_of_the_binomial_test(n, chance):
    found = [stats.binomtest(count, n, chance).pvalue for count in range(n + 1)]
    assert exact_ps(n, chance=chance) == pytest.approx(found)


def test_a_share_of_nothing_is_refused():
    with pytest.raises(ParameterError, match="0 <= count <= n"):
        share_of(3, 2)
    with pytest.raises(ParameterError, match="less than 0.5"):
        share_equivalence(5, 10, margin=0.6)


def test_d_prime_is_that_of_the_observer():
    for d in (0.3, 1.0, 2.5):
        assert d_prime_2afc(float(stats.norm.cdf(d / np.sqrt(2)))) == pytest.approx(d)
        assert d_prime_abx(abx_share(d)) == pytest.approx(d)
    assert d_prime_abx(0.45) == 0.0
    assert np.isfinite(d_prime_2afc(corrected(10, 10)))


def test_paired_equivalence_is_where_the_90_percent_interval_lies_within_the_margin():
    gaps = np.array([0.4, -0.2, 0.1, 0.3, -0.1, 0.0])
    edge = max(abs(end) for end in stats.t.interval(0.9, 5, gaps.mean(), stats.sem(gaps)))
    assert (
        paired_equivalence(gaps, margin=edge * 1.001) < 0.05 < paired_equivalence(gaps, margin=edge * 0.999)
    )
    with pytest.raises(ParameterError, match="margin must be > 0"):
        paired_equivalence(gaps, margin=0)


def test_the_pseudomedian_is_that_of_the_published_example():
    # M. Hollander, D. A. Wolfe, depression scores; R's wilcox.test gives 0.46 (0.010 to 0.786).
    before = [1.83, 0.50, 1.62, 2.48, 1.68, 1.88, 1.55, 3.06, 1.30]
    after = [0.878, 0.647, 0.598, 2.05, 1.06, 1.29, 1.06, 3.14, 1.29]
    assert pseudomedian(np.subtract(before, after)) == pytest.approx((0.46, 0.010, 0.786), abs=1e-9)
    assert pseudomedian([1.0, 2.0, 3.0, 4.0, 5.0])[1:] == (None, None)


@pytest.mark.parametrize("differences", [[1.5, -2.0, 3.0, 0.4, 5.0, 2.2], [1, 1, -2, 3, 3, -1, 0, 2]])
def test_signed_ranks_have_the_p_of_scipy_with_ties_and_without(differences):
    given = np.array(differences, float)
    assert signed_rank_p(given) == pytest.approx(stats.wilcoxon(given).pvalue)
    assert signed_rank_p([0.0, 0.0]) == 1.0


def test_a_pooled_share_is_as_wide_as_people_differ():
    shares = np.array([2, 9, 4, 8, 1, 9, 6, 3]) / 10
    hits = np.concatenate([[1] * round(10 * s) + [0] * (10 - round(10 * s)) for s in shares])
    found = pooled_share(hits, np.repeat(np.arange(8), 10).tolist(), margin=0.1)
    mu = shares.mean()
    se = np.sqrt(((shares - mu) ** 2).sum()) / (7 * mu * (1 - mu))  # Mancl and DeRouen, equal numbers
    half = stats.t.isf(0.025, 7) * se
    assert (found.low, found.high) == pytest.approx(
        special.expit(special.logit(mu) + np.array([-half, half]))
    )
    assert found.high - found.low > 2 * (share_of(42, 80).wilson[1] - share_of(42, 80).wilson[0]) * 0.9
    assert found.equivalence_p > 0.05


def test_shares_that_are_all_alike_do_not_claim_certainty():
    people = ["a"] * 10 + ["b"] * 10 + ["c"] * 10
    all_right = pooled_share([1] * 30, people)
    assert (all_right.p, all_right.low) == pytest.approx((0.25, 0.2924), abs=1e-3)
    halves = pooled_share([0, 1] * 15, people)
    assert halves.low < 0.4 < 0.6 < halves.high
    assert "independent" in halves.note
    with pytest.raises(ParameterError, match="two participants"):
        pooled_share([1, 0], ["a", "a"])


def test_the_mixed_model_finds_what_was_put_in():
    rng = np.random.default_rng(0)
    who, item = np.repeat(np.arange(12), 24), np.tile(np.repeat(np.arange(4), 6), 12)
    second = np.arange(288) % 2
    marks = 50 + rng.normal(0, 10, 12)[who] + second * (8 + rng.normal(0, 2, 12)[who]) + rng.normal(0, 8, 288)
    gap = mixed_difference(marks, second, who.tolist(), item.tolist())
    assert gap.low < 8 < gap.high
    assert gap.p < 0.01


def test_the_bootstrap_draws_participants_whole():
    table = np.repeat([[0.0], [10.0]], 5, axis=1)
    found, low, high = bootstrap_by_participant(
        table, lambda t: t.mean(), rng=np.random.default_rng(0), draws=200
    )
    assert (found, low, high) == (5.0, 0.0, 10.0)
    assert np.isnan(bootstrap_by_participant([[1.0]], lambda t: t.mean(), rng=np.random.default_rng(0))[1])
