"""Rate limits."""

import pytest

from tactogram_study.participants.refusals import RateLimiter, RateLimitError


def test_a_rate_limit_refills_with_time():
    now = [0.0]
    limiter = RateLimiter(2, 10.0, clock=lambda: now[0])
    for key in "aab":
        limiter.spend(key)
    for now[0], wait_s in ((0.0, 10.0), (4.0, 6.0)):
        with pytest.raises(RateLimitError) as refused:
            limiter.spend("a")
        assert refused.value.wait_s == pytest.approx(wait_s)
    now[0] = 11.0
    limiter.spend("a")
