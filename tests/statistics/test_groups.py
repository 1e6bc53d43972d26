"""Summaries, means without what is missing, pooled probabilities, and Holm's correction against statsmodels."""

import warnings

import numpy as np
import pytest
from scipy import stats
from statsmodels.stats.multitest import multipletests

from tactogram.errors import ParameterError
from tactogram.statistics.groups import holm, holm_rows, nan_mean, pooled, summary


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


def test_a_summary_is_of_the_values_that_are_there():
    values = np.random.default_rng(0).normal(3, 2, 12)
    found = summary([*values, np.nan])
    se = stats.sem(values)
    assert (found.n, found.mean, found.sd, found.se) == pytest.approx(
        (12, values.mean(), values.std(ddof=1), se)
    )
    assert (found.low, found.high) == pytest.approx(stats.t.interval(0.95, 11, loc=values.mean(), scale=se))


def test_of_one_value_there_is_no_spread_and_of_none_no_summary():
    found = summary([np.nan, 4.0])
    assert (found.n, found.mean) == (1, 4.0)
    assert np.isnan([found.sd, found.se, found.low, found.high]).all()
    with pytest.raises(ParameterError, match="a summary needs a value, got none"):
        summary([np.nan])


def test_means_leave_out_what_is_missing_without_a_warning():
    values = np.array([[1.0, np.nan, 3.0], [np.nan, np.nan, 5.0]])
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        np.testing.assert_array_equal(nan_mean(values, 0), [1, np.nan, 4])
        np.testing.assert_array_equal(nan_mean(values, 1, keepdims=True), [[2], [5]])
    assert nan_mean(values, (0, 1)) == 3


def test_pooling_by_hand():
    windows = np.array([[0.5, 0.5], [0.1, 0.9]])
    a, b = np.sqrt(0.5 * 0.1), np.sqrt(0.5 * 0.9)
    np.testing.assert_allclose(pooled(windows), [a / (a + b), b / (a + b)])
    assert pooled(np.array([[0.0, 1.0], [0.9, 0.1]])).argmax() == 1
