import numpy as np
import pytest
from scipy import stats

from tactogram.errors import ParameterError
from tactogram.statistics.comparison import (
    friedman_wilcoxon,
    mann_whitney,
    paired_t,
    steel_dwass,
    student_t,
)
from tactogram.statistics.groups import summary

# S. Aoki's worked example of the Steel-Dwass test, with the t and p that he prints.
AOKI = {
    "1": [6.9, 7.5, 8.5, 8.4, 8.1, 8.7, 8.9, 8.2, 7.8, 7.3, 6.8],
    "2": [9.6, 9.4, 9.5, 8.5, 9.4, 9.9, 8.7, 8.1, 7.8, 8.8],
    "3": [5.7, 6.4, 6.8, 7.8, 7.6, 7.0, 7.7, 7.5, 6.8, 5.9],
    "4": [7.6, 8.7, 8.5, 8.5, 9.0, 9.2, 9.3, 8.0, 7.2, 7.9, 7.8],
}
AOKI_T_AND_P = {
    ("1", "2"): (2.680234, 0.036960431),
    ("1", "3"): (2.539997, 0.053980573),
    ("1", "4"): (1.282642, 0.574011771),
    ("2", "3"): (3.746076, 0.001031145),
    ("2", "4"): (2.046776, 0.170965537),
    ("3", "4"): (3.384456, 0.003976894),
}


@pytest.mark.parametrize("names", AOKI_T_AND_P)
def test_steel_dwass_gives_the_published_example(names):
    pair = steel_dwass(AOKI).pair(*names)
    t, p = AOKI_T_AND_P[names]
    assert abs(pair.statistic) == pytest.approx(t, abs=1e-6)
    # studentised range of R 1.6 and of scipy differ in the sixth place
    assert pair.p == pytest.approx(p, rel=1e-3)


def test_steel_dwass_has_the_sign_of_the_first_group_and_warns_of_repeated_answers():
    found = steel_dwass(AOKI)
    assert found.pair("1", "2").statistic < 0 < found.pair("1", "3").statistic
    assert found.pair("3", "1") == found.pair("1", "3")
    assert "independent" in found.caveat


def test_groups_of_one_and_the_same_value_do_not_differ():
    same = {"a": [2.0] * 4, "b": [2.0] * 5, "c": [1.0, 2.0, 3.0]}
    for test in (steel_dwass, student_t, mann_whitney):
        pair = test(same).pair("a", "b")
        assert (pair.statistic, pair.p) == (0.0, 1.0)


def test_student_t_is_uncorrected_and_pooled():
    pair = student_t(AOKI).pair("1", "3")
    a, b = np.array(AOKI["1"]), np.array(AOKI["3"])
    pooled = ((a.size - 1) * a.var(ddof=1) + (b.size - 1) * b.var(ddof=1)) / (a.size + b.size - 2)
    t = (a.mean() - b.mean()) / np.sqrt(pooled * (1 / a.size + 1 / b.size))
    assert pair.statistic == pytest.approx(t)
    assert pair.p == pytest.approx(2 * stats.t.sf(abs(t), a.size + b.size - 2))


def test_holm_multiplies_the_smallest_p_by_the_number_of_pairs():
    holm = mann_whitney(AOKI)
    smallest = min(holm.pairs, key=lambda pair: pair.p)
    raw = stats.mannwhitneyu(AOKI[smallest.first], AOKI[smallest.second]).pvalue
    assert smallest.p == pytest.approx(6 * raw)
    assert holm.correction == "holm"


def test_paired_tests_see_what_people_agree_on():
    rng = np.random.default_rng(0)
    person = rng.normal(0, 5, 20)
    table = {"a": person + rng.normal(0, 0.1, 20), "b": person + 0.3, "c": person + 0.6}
    assert student_t(table).pair("a", "b").p > 0.5
    assert paired_t(table).pair("a", "b").p < 0.001
    found = friedman_wilcoxon(table)
    assert found.overall is not None
    assert found.overall[1] < 0.001
    assert found.pair("a", "b").p < 0.001


def test_friedman_is_scipys_and_pairs_are_wilcoxons_with_holm():
    rng = np.random.default_rng(1)
    table = {name: rng.normal(size=9) for name in "abc"}
    found = friedman_wilcoxon(table)
    assert found.overall == pytest.approx(tuple(stats.friedmanchisquare(*table.values())))
    raw = sorted(stats.wilcoxon(table[p.first], table[p.second]).pvalue for p in found.pairs)
    assert min(pair.p for pair in found.pairs) == pytest.approx(min(1, 3 * raw[0]))


def test_who_lacks_a_condition_is_left_out_and_counted():
    found = paired_t({"a": [1.0, 2.0, 3.5, np.nan], "b": [2.0, 2.5, 3.0, 9.0]})
    assert found.left_out == 1
    assert found.groups["b"].n == 3


def test_conditions_that_are_all_alike_do_not_differ():
    found = friedman_wilcoxon({"a": [1.0, 2.0], "b": [1.0, 2.0], "c": [1.0, 2.0]})
    assert found.overall == (0.0, 1.0)
    assert {pair.p for pair in found.pairs} == {1.0}


def test_groups_without_spread_differ_without_doubt():
    assert student_t({"a": [1.0, 1.0], "b": [2.0, 2.0]}).pair("a", "b").p == 0.0
    assert paired_t({"a": [1.0, 2.0, 3.0], "b": [2.0, 3.0, 4.0]}).pair("a", "b").p == 0.0


def test_summary_gives_students_interval():
    found = summary([1.0, 2.0, 3.0, np.nan])
    assert (found.n, found.mean, found.sd) == (3, 2.0, 1.0)
    assert found.se == pytest.approx(1 / np.sqrt(3))
    # t of 2 degrees of freedom at 97.5 % is 4.302653
    assert found.high - found.mean == pytest.approx(4.302653 / np.sqrt(3), abs=1e-6)
    assert np.isnan(summary([4.0]).se)


@pytest.mark.parametrize(
    ("call", "message"),
    [
        (lambda: steel_dwass({"a": [1.0, 2.0]}), "two groups, got a"),
        (lambda: steel_dwass({"a": [1.0, 2.0], "b": [1.0]}), "group b: must have two values, got 1"),
        (lambda: student_t({"a": [1.0, np.nan], "b": [1.0, 2.0]}), "group a: values must be finite"),
        (lambda: paired_t({"a": [1.0, 2.0], "b": [1.0]}), "every person .* a 2, b 1"),
        (lambda: paired_t({"a": [1.0, np.nan], "b": [1.0, 2.0]}), "two people .* got 1 of 2"),
        (lambda: steel_dwass(AOKI).pair("1", "9"), "two of 1, 2, 3, 4"),
        (lambda: summary([np.nan]), "needs a value"),
    ],
)
def test_refused(call, message):
    with pytest.raises(ParameterError, match=message):
        call()
