import numpy as np
import pytest
from hypothesis import given, strategies as st
from scipy.stats import binomtest, ttest_1samp

from tactogram.errors import ParameterError
from tactogram.evaluation.measures import mean_interval, wilson


@pytest.mark.parametrize(("n", "half"), [(10, 0.263), (20, 0.201), (60, 0.123), (100, 0.096), (400, 0.049)])
def test_half_width_at_one_half(n, half):
    _, low, high = wilson(0.5, n)
    assert (high - low) / 2 == pytest.approx(half, abs=5e-4)


@given(st.integers(1, 200).flatmap(lambda n: st.tuples(st.integers(0, n), st.just(n))))
def test_it_is_scipys(counts):
    right, n = counts
    expected = binomtest(right, n).proportion_ci(0.95, method="wilson")
    got = wilson(right / n, n)
    assert (got.low, got.high) == pytest.approx((expected.low, expected.high), abs=1e-9)
    assert 0 <= got.low <= got.accuracy <= got.high <= 1


@pytest.mark.parametrize(("share", "n"), [(0.5, 0), (-0.1, 3), (1.1, 3), (float("nan"), 3)])
def test_an_invalid_share_is_refused(share, n):
    with pytest.raises(ParameterError, match=r"share must be in 0\.\.1 and trials >= 1"):
        wilson(share, n)


def test_the_interval_of_a_mean_is_students():
    x = np.random.default_rng(0).gamma(2, 1, 6)
    assert mean_interval(x) == pytest.approx(ttest_1samp(x, 0).confidence_interval(0.95))
    low, high = mean_interval(x, least=1.9, most=2.1)
    assert (low, high) == (max(1.9, mean_interval(x)[0]), min(2.1, mean_interval(x)[1]))
    assert mean_interval(x[:2]) is None


@pytest.mark.parametrize("spread", [(1.0, 0.0), (0.0, 1.0), (1.0, 1.0)])
def test_the_interval_of_crossed_values_holds_the_mean_of_new_rows_and_columns(spread):
    rng = np.random.default_rng(1)
    held = []
    for _ in range(1000):
        rows, columns = spread[0] * rng.standard_normal((5, 1)), spread[1] * rng.standard_normal((1, 12))
        low, high = mean_interval(rows + columns + 0.3 * rng.standard_normal((5, 12)))
        held.append(low <= 0 <= high)
    assert 0.93 < np.mean(held) < 0.995
