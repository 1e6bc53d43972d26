"""Limits, fades and DC of drives."""

import numpy as np
import pytest
from hypothesis import given, settings, strategies as st
from hypothesis.extra import numpy as hnp

from tactogram.errors import ParameterError
from tactogram.rendering.displays.catalogue import display_of
from tactogram.rendering.drive.safety import fade_window, safe
from tactogram.signal import Signal


def display(**changes):
    values = {
        "name": "a",
        "title": "a",
        "family": "linear",
        "rate": 1000,
        "channels": ["a", "b"],
        "unit": "V",
        "limit": 0.7,
        "fade_ms": 20,
    }
    return display_of(values | changes)


SAMPLES = hnp.arrays(
    np.float32,
    st.tuples(st.just(2), st.integers(1, 120)),
    elements=st.floats(-1e6, 1e6, width=32, allow_nan=False),
)


@settings(max_examples=50)
@given(SAMPLES, st.booleans())
def test_limits_hold_whatever_comes(samples, dc):
    d = display(dc=dc)
    drive, facts = safe(Signal(samples, 1000, "V", ("a", "b")), d)
    assert np.abs(drive.samples.astype(np.float64)).max() <= d.limit
    assert facts["clipped_samples"] == np.count_nonzero(np.abs(samples.astype(np.float64)) > d.limit)
    if not dc:
        assert np.abs(drive.samples.astype(np.float64).mean(axis=1)).max() < 1e-6
    assert not drive.samples[:, -1].any()


@settings(max_examples=30)
@given(SAMPLES)
def test_lowest_and_rest_are_kept(samples):
    d = display(lowest=0.1, rest=0.2, dc=True)
    drive, _ = safe(Signal(samples, 1000, "V", ("a", "b")), d)
    x = drive.samples.astype(np.float64)
    assert x.min() >= 0.1
    assert x.max() <= 0.7
    np.testing.assert_allclose(x[:, -1], 0.2, atol=1e-7)


def test_a_drive_within_limits_is_only_faded():
    t = np.arange(1000) / 1000
    x = np.stack([np.sin(2 * np.pi * 50 * t), np.cos(2 * np.pi * 50 * t)]) * 0.5
    drive, facts = safe(Signal(x, 1000, "V", ("a", "b")), display())
    np.testing.assert_allclose(drive.samples[:, 20:-20], x[:, 20:-20], atol=2e-3)
    assert facts["clipped_samples"] == 0
    assert abs(drive.samples[:, 0]).max() < 1e-3


def test_the_fade_is_a_raised_cosine():
    w = fade_window(100, 20)
    assert w[0] == w[-1] == 0
    assert w[10] == pytest.approx(0.5)
    assert (w[20:-20] == 1).all()
    assert (np.diff(w[:20]) > 0).all()
    np.testing.assert_array_equal(fade_window(3, 0), [1, 1, 0])


def test_a_drive_that_is_not_the_displays_is_a_defect():
    with pytest.raises(ParameterError, match="drive must be"):
        safe(Signal(np.zeros((2, 10)), 500, "V", ("a", "b")), display())
