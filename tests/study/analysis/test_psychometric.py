import numpy as np
import pytest
from scipy import optimize, special

from tactogram.errors import DataError, ParameterError
from tactogram.study.analysis.psychometric import _Likelihood, fit_logistic, reversal_threshold
from tactogram.study.designs.staircase.power import simulated_thresholds


def test_the_gradient_is_that_of_the_likelihood():
    model = _Likelihood(np.arange(1.0, 7), np.full(6, 60.0), 0.5)
    at, k = np.array([1.0, 0.5, 0.02]), np.array([30.0, 35, 40, 50, 55, 58])
    slope = optimize.approx_fprime(at, lambda p: model.loss(p, k)[0], 1e-7)
    assert model.loss(at, k)[1] == pytest.approx(slope, rel=1e-4)


def test_a_threshold_that_was_put_in_is_found():
    rng = np.random.default_rng(1)
    x = np.repeat(np.arange(-30.0, -5, 4), 80)
    share = 0.5 + 0.48 * special.expit(0.5 * (x + 18))
    fit = fit_logistic(x, rng.random(len(x)) < share)
    assert fit.threshold == pytest.approx(-18 + special.logit(0.25 / 0.48) / 0.5, abs=1.5)
    rise = special.expit(fit.slope * (fit.threshold - fit.place))
    assert 0.5 + (0.5 - fit.lapse) * rise == pytest.approx(0.75)


def test_what_cannot_give_a_threshold_is_refused():
    with pytest.raises(DataError, match="both right and wrong"):
        fit_logistic([1.0, 2.0], [1, 1])
    with pytest.raises(ParameterError, match="guess < target"):
        fit_logistic([1.0, 2.0], [0, 1], target=0.4)


def test_reversals_leave_out_the_first_and_count_peaks_and_valleys_alike():
    x, turned = [0, 8, 4, 6, 2, 4, 3], [False, True, True, True, True, True, False]
    assert reversal_threshold(x, turned) == pytest.approx((2 + 4) / 2)
    assert reversal_threshold(x, [False] * 7) is None


def test_simulated_staircases_settle_where_three_in_a_row_are_as_likely_as_not():
    rng = np.random.default_rng(0)
    place = np.full(400, -20.0)
    found = simulated_thresholds(place, 120, slope=0.5, rng=rng)
    settled = -20 + special.logit((0.5 ** (1 / 3) - 0.5) / 0.5) / 0.5
    assert found.mean() == pytest.approx(settled, abs=0.5)
