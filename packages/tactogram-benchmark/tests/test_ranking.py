"""Ranking: who is told apart from whom."""

import numpy as np
import pytest
from scipy.stats import permutation_test

from tactogram.errors import ParameterError
from tactogram_benchmark.ranking import rank_models, sign_flip_p
from tactogram_benchmark.result import BenchmarkResult


def result(model, values, *, seed=0, better="lower", failed="", recipe="", named="item", **ends):
    by_item = {f"{named} {n}": float(value) for n, value in enumerate(values)}
    main = {"value": float(np.mean(values)), "better": better, "title": "error", "by_item": by_item} | ends
    return BenchmarkResult(
        task="t", task_sha256="", model=model, entry="model", seed=seed,
        data={"name": "d", "sha256": "", "simulated": True}, split_sha256="", judge=1, code="", device="", finished="",
        recipe=recipe,
        figures={} if failed else {"error": main}, failed=failed,
    )  # fmt: skip


@pytest.mark.parametrize("count", [8, 40])
def test_p_is_that_of_scipy(count):
    x = np.random.default_rng(3).normal(0.4, 1, count)
    expected = permutation_test(
        (x,), np.sum, permutation_type="samples", n_resamples=20_000, rng=np.random.default_rng(0)
    ).pvalue
    assert sign_flip_p(x) == pytest.approx(expected, abs=0.01)
    assert sign_flip_p(np.zeros(5)) == 1


def test_a_clear_order_is_told_and_equals_are_not():
    rng = np.random.default_rng(0)
    base = rng.normal(1, 0.1, 30)
    ranked = rank_models(
        [
            result("far", base + 1),
            result("near", base),
            result("alike", base + rng.normal(0, 0.05, 30)),
            result("broken", [1.0], failed="no photographs"),
        ]
    )
    by_name = {entry.model: entry for entry in ranked}
    assert {"near", "alike", "far"} == set(by_name)
    assert ranked[-1].model == "far"
    assert by_name["far"].rank_text == "3"
    assert by_name["near"].rank_text == by_name["alike"].rank_text == "1–2"
    assert by_name["near"].not_told_apart == ("alike",)


def test_higher_is_better_where_the_figure_says_so():
    base = np.random.default_rng(0).normal(1, 0.1, 30)
    ranked = rank_models([result("low", base, better="higher"), result("high", base + 1, better="higher")])
    assert [entry.model for entry in ranked] == ["high", "low"]


def test_a_difference_that_changes_its_sign_between_seeds_is_not_told():
    base = np.random.default_rng(0).normal(1, 0.1, 30)
    steady = [result("a", base, seed=seed) for seed in range(3)]
    wild = [result("b", base + shift, seed=seed) for seed, shift in enumerate((-0.1, 1.0, 1.0))]
    ranked = rank_models([*steady, *wild])
    assert sign_flip_p(np.full(30, 0.63)) < 0.05  # the mean over seeds alone would tell
    assert [entry.rank_text for entry in ranked] == ["1–2", "1–2"]
    assert ranked[1].sd == pytest.approx(np.std([-0.1, 1, 1], ddof=1))


def test_models_that_enter_take_no_differences_away():
    """Of nine items no p is below 2/512, too large for Holm's correction of fifteen pairs."""
    base = np.random.default_rng(0).normal(1, 0.1, 9)
    ranked = rank_models([result(name, base + place) for place, name in enumerate("abcdef")])
    assert [entry.rank_text for entry in ranked] == ["1", "2", "3", "4", "5", "6"]


def test_a_model_is_informed_if_it_is_better_than_what_ignores_the_input():
    base = np.array([1.0, 1.1, 0.9, 1.05])  # too few for the permutation test
    rows = [result("random", base), result("mean", base + 0.1)]
    near = [result("near", base - 0.5 - 0.1 * np.arange(4), seed=seed) for seed in (0, 1)]
    noisy = [result("noisy", base - np.array([2.0, 0, 0, 0]))]
    between = [result("between", base + 0.05)]  # than the mean alone
    wild = [result("wild", base - 0.5 + shift, seed=seed) for seed, shift in enumerate((-0.6, 0.6))]
    found = {entry.model: entry.informed for entry in rank_models([*rows, *near, *noisy, *between, *wild])}
    expected = {"near": True, "noisy": False, "between": False, "wild": False, "random": None, "mean": None}
    assert found == expected
    assert rank_models(near)[0].informed is None  # nothing to compare with


def test_models_without_a_common_seed_are_not_told():
    base = np.random.default_rng(0).normal(1, 0.1, 30)
    near = [result("near", base, seed=seed) for seed in (0, 1)]
    far = [result("far", base + 1, seed=seed) for seed in (2, 3)]
    assert [entry.rank_text for entry in rank_models([*near, *far])] == ["1–2", "1–2"]


def test_few_items_tell_nothing():
    ranked = rank_models([result("a", [0.0, 0.1, 0.0, 0.1]), result("b", [1.0, 1.1, 1.0, 1.1])])
    assert [entry.rank_text for entry in ranked] == ["1–2", "1–2"]


@pytest.mark.parametrize(
    ("changes", "message"),
    [
        ({"better": "higher"}, "main figure must be error, lower is better, as of one; got error, higher"),
        ({"named": "question"}, "t, two with seed 0: answers other questions than one"),
        (
            {"model": "one", "seed": 1, "recipe": "paper"},
            "one with seed 1: made by 'paper', seed 0 by 'model'",
        ),
    ],
)
def test_what_does_not_compare_is_refused(changes, message):
    other = {"model": "two", "values": [1, 2, 3]} | changes
    with pytest.raises(ParameterError, match=message):
        rank_models([result("one", [1, 2, 3]), result(**other)])


def test_a_ranking_is_of_plain_types_as_json_needs():
    ranked = rank_models([result("one", np.ones(20)), result("two", np.arange(20))])
    assert {type(value) for entry in ranked for value in (entry.best_rank, entry.worst_rank)} == {int}


def test_the_interval_holds_the_spread_of_trainings_too():
    """Student's quantile of 2 degrees of freedom is 4.303."""
    seeds = [
        result("a", [value, value], seed=n, low=value - 0.3, high=value + 0.4)
        for n, value in enumerate((1, 1.1, 1.2))
    ]
    (entry,) = rank_models(seeds)
    margin = 4.303 * 0.1 / np.sqrt(3)
    assert entry.low == pytest.approx(1.1 - np.hypot(0.3, margin), abs=1e-4)
    assert entry.high == pytest.approx(1.1 + np.hypot(0.4, margin), abs=1e-4)
    (lone,) = rank_models(seeds[:1])
    assert (lone.low, lone.high) == (0.7, 1.4)


@pytest.mark.parametrize(("better", "bound"), [("lower", (0.0, 3.0)), ("higher", (-1.0, 1.0))])
def test_an_interval_stays_within_what_is_possible(better, bound):
    (entry,) = rank_models([result("a", [0.9, 0.9], better=better, low=-1.0, high=3.0)])
    assert (entry.low, entry.high) == pytest.approx(bound)
