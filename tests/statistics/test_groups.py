"""Holm's correction against statsmodels."""

import numpy as np
import pytest
from statsmodels.stats.multitest import multipletests

from tactogram.statistics.groups import holm, holm_rows


@pytest.mark.parametrize("ps", [[0.04], [0.01, 0.04, 0.03, 0.005], [0.5, 0.5, 0.02], [0.0, 1.0, 0.2]])
def test_holm_is_that_of_statsmodels(ps):
    assert holm(ps) == pytest.approx(multipletests(ps, method="holm")[1])


def test_of_many_ps_the_order_is_kept_and_none_is_above_one():
    ps = np.random.default_rng(0).random(40) ** 3
    assert holm(ps) == pytest.approx(multipletests(ps, method="holm")[1])
    assert holm([]) == []


def test_rows_are_each_as_alone():
    ps = np.random.default_rng(1).random((4, 6)) ** 3
    assert holm_rows(ps) == pytest.approx(np.array([holm(row) for row in ps]))
