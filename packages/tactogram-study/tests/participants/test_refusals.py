"""Rate limits."""

import pytest

from tactogram_study.participants.refusals import RateLimiter


def test_a_rate_limit_refills_with_time():
    now = [0.0]
    limiter = RateLimiter(2, 10.0, clock=lambda: now[0])
    for _ in range(2):
        assert limiter.wait_s("a") == 0
        limiter.spend("a")
    assert (limiter.wait_s("a"), limiter.wait_s("b")) == (10.0, 0.0)
    now[0] = 4.0
    assert limiter.wait_s("a") == pytest.approx(6.0)
    now[0] = 11.0
    assert limiter.wait_s("a") == 0
