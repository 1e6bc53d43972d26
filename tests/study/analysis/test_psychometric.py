import numpy as np
import pytest
from scipy import optimize, special

from tactogram.errors import DataError, ParameterError
from tactogram.study.analysis.psychometric import SHAPES, _Model, fit_psychometric, reversal_threshold
from tactogram.study.designs.staircase.power import simulated_thresholds


@pytest.mark.parametrize("shape", SHAPES)
def test_the_gradient_is_that_of_the_likelihood(shape):
    model = _Model(shape, np.arange(1.0, 7), np.full(6, 60.0), 0.5, 0.06)
    at, k = np.array([1.0, 0.5, 0.02]), np.array([30.0, 35, 40, 50, 55, 58])
    slope = optimize.approx_fprime(at, lambda p: model.loss(p, k)[0], 1e-7)
    assert model.loss(at, k)[1] == pytest.approx(slope, rel=1e-4)


def test_a_threshold_that_was_put_in_is_found():
    rng = np.random.default_rng(1)
    x = np.repeat(np.arange(-30.0, -5, 4), 80)
    share = 0.5 + 0.48 * special.expit(0.5 * (x + 18))
    fit = fit_psychometric(x, rng.random(len(x)) < share, rng=rng, shape="logistic", draws=60)
    truth = -18 + special.logit(0.25 / 0.48) / 0.5
    assert fit.low < truth < fit.high
    assert fit.high - fit.low < 6
    assert fit.inside
    assert fit.share(fit.threshold) == pytest.approx(0.75)
    assert fit.deviance_p > 0.05


def test_what_cannot_give_a_threshold_is_refused():
    rng = np.random.default_rng(0)
    with pytest.raises(DataError, match="both right and wrong"):
        fit_psychometric([1.0, 2.0], [1, 1], rng=rng)
    with pytest.raises(ParameterError, match="take logistic"):
        fit_psychometric([-1.0, 2.0], [0, 1], rng=rng)
    with pytest.raises(ParameterError, match="guess < target"):
        fit_psychometric([1.0, 2.0], [0, 1], rng=rng, target=0.4)


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
