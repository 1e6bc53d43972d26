from collections import Counter
from itertools import pairwise
from typing import get_args

import numpy as np
import pytest

from tactogram.errors import ParameterError
from tactogram_study.trials import Rule, balanced_sides, generator, latin_square, ordered, williams_square


@pytest.mark.parametrize("n", [1, 2, 5, 8])
def test_each_comes_once_in_each_row_and_column_of_a_latin_square(n):
    square = latin_square(n)
    assert (np.sort(square, axis=0) == np.arange(n)[:, None]).all()
    assert (np.sort(square, axis=1) == np.arange(n)).all()


@pytest.mark.parametrize(("n", "times"), [(2, 1), (4, 1), (9, 2), (10, 1)])
def test_each_follows_each_other_equally_often_in_a_williams_design(n, times):
    square = williams_square(n)
    assert square.shape == (n * times, n)
    follows = Counter((int(a), int(b)) for row in square for a, b in pairwise(row))
    assert set(follows.values()) == {times}
    assert len(follows) == n * (n - 1)
    assert all(Counter(column.tolist()) == dict.fromkeys(range(n), times) for column in square.T)


@pytest.mark.parametrize("rule", get_args(Rule))
def test_an_order_holds_each_item_as_often_as_asked_and_follows_from_the_seed(rule):
    def shown(seed, participant):
        return ordered("abcde", rule=rule, repeats=3, seed=seed, participant=participant)

    assert shown(1, 2) == shown(1, 2)
    assert Counter(item for _, _, item in shown(1, 2)) == dict.fromkeys("abcde", 3)
    if rule != "as-listed":
        assert shown(1, 2) != shown(2, 2)
        assert shown(1, 2) != shown(1, 3)


@pytest.mark.parametrize("rule", ["blocks", "latin", "williams"])
def test_a_block_holds_every_item_once(rule):
    shown = ordered(range(6), rule=rule, repeats=4, seed=0, participant=1)
    for block in range(1, 5):
        assert sorted(item for b, _, item in shown if b == block) == list(range(6))


@pytest.mark.parametrize("rule", ["latin", "williams"])
def test_over_as_many_participants_as_items_each_comes_once_in_each_place(rule):
    orders = [
        [i for _, _, i in ordered(range(6), rule=rule, repeats=1, seed=4, participant=p)] for p in range(1, 7)
    ]
    assert all(sorted(column) == list(range(6)) for column in zip(*orders, strict=True))


def test_balanced_sides_are_equally_often_and_what_is_left_over_is_drawn():
    rng = generator(0, 1, "sides")
    assert Counter(balanced_sides(10, rng)) == {"A": 5, "B": 5}
    assert {tuple(sorted(balanced_sides(1, rng))) for _ in range(40)} == {("A",), ("B",)}


def test_an_order_of_nothing_is_refused():
    with pytest.raises(ParameterError, match="at least 1 item, got 0"):
        ordered([], rule="random", repeats=1, seed=0, participant=1)
