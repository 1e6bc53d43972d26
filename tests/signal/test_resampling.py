"""Signals at other rates."""

import numpy as np
import pytest
from hypothesis import given, settings, strategies as st

from tactogram.errors import ParameterError
from tactogram.signal import Signal
from tactogram.signal.resampling import resample


def sine(frequency, rate, seconds, *, phase=0.3, level=1.0, unit="m/s^2"):
    t = np.arange(round(rate * seconds)) / rate
    return Signal(level * np.sin(2 * np.pi * frequency * t + phase), rate, unit)


@given(
    st.integers(1, 700),
    st.floats(100, 20000, allow_nan=False),
    st.floats(100, 20000, allow_nan=False),
)
@settings(deadline=None, max_examples=60)
def test_resampled_length_is_the_rounded_product(length, old, new):
    x = Signal(np.full(length, 2.5), old, "N")
    if round(length * new / old) < 1:
        with pytest.raises(ParameterError, match="at least one sample"):
            resample(x, new)
        return
    y = resample(x, new)
    assert len(y) == round(length * new / old) or new == old
    assert y.rate == new
    np.testing.assert_allclose(y.samples, 2.5, rtol=1e-6)


@pytest.mark.parametrize(
    ("old", "new"), [(1000, 330), (330, 1000), (44100, 10000), (333.3, 1000), (6012.37, 1000)]
)
def test_resampling_keeps_level_and_phase(old, new):
    frequency = 0.2 * min(old, new)
    x, expected = sine(frequency, old, 4), sine(frequency, new, 4)
    y = resample(x, new)
    margin = round(0.5 * new)
    error = y.samples[0, margin:-margin] - expected.samples[0, margin : len(y) - margin]
    assert np.abs(error).max() < 3e-4


def test_resampling_removes_what_the_new_rate_cannot_hold():
    assert np.abs(resample(sine(400, 1000, 4), 500).samples[:, 100:-100]).max() < 1e-5


@pytest.mark.parametrize("share", [0.1, 0.4, 0.45])
def test_resampling_is_flat_to_045_of_the_lower_rate(share):
    x = sine(share * 300, 1000, 20)
    y = resample(x, 300)
    assert 20 * np.log10(y.samples[0, 500:-500].std() * np.sqrt(2)) == pytest.approx(0, abs=0.01)


def test_the_same_rate_changes_nothing():
    x = sine(50, 330, 1)
    assert resample(x, 330) is x


@pytest.mark.parametrize("rate", [0, -1, np.nan, np.inf])
def test_a_rate_that_is_none_is_refused(rate):
    with pytest.raises(ParameterError, match="rate must be > 0"):
        resample(sine(50, 330, 1), rate)
