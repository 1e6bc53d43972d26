import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.stats import binomtest

from tactogram.errors import ParameterError
from tactogram.evaluation.measures import wilson


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
