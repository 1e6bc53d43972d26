"""Ways of making one axis of several."""

import numpy as np
import pytest

from tactogram.errors import ParameterError
from tactogram.rendering.drive.axes import combined
from tactogram.signal import Signal
from tactogram.signal.filters import dft321


def three():
    return Signal(np.random.default_rng(0).normal(size=(3, 200)), 1000, "m/s^2")


def test_ways_of_making_one_axis_of_three():
    signal = three()
    np.testing.assert_array_equal(combined(signal, "y")[0].samples, signal.select("y").samples)
    np.testing.assert_array_equal(combined(signal, "dft321")[0].samples, dft321(signal).samples)
    np.testing.assert_allclose(combined(signal, "mean")[0].samples[0], signal.samples.mean(axis=0), atol=1e-6)
    assert combined(signal, "channels")[0] is signal
    assert combined(signal, "y")[1] == "axis y alone, x, z left out"


def test_two_axes_keep_their_energy():
    two = three().select("x", "y")
    one, words = combined(two, "dft321")
    assert np.sum(one.samples**2) == pytest.approx(np.sum(two.samples**2), rel=1e-3)
    assert "2 axes" in words


def test_what_cannot_be_combined_is_refused():
    with pytest.raises(ParameterError, match=r"of the signal's \(x, y, z\), got 'w'"):
        combined(three(), "w")
    four = Signal(np.zeros((4, 5)), 1000, "m/s^2", ("a", "b", "c", "d"))
    with pytest.raises(ParameterError, match="at most three axes, got 4; use mean, .* e.g. `how=a`"):
        combined(four, "dft321")
