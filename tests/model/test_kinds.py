"""Signals of another kind than a model's."""

import numpy as np
import pytest

from tactogram.errors import ParameterError
from tactogram.model import SignalKind
from tactogram.signal import Signal


def test_a_kind_refuses_another_rate():
    kind = SignalKind(330, "m/s^2", ("x", "y", "z"))
    kind.check(Signal(np.zeros((3, 4)), 330, "m/s^2"))
    with pytest.raises(ParameterError, match="signal must be 330 Hz.*got 1000 Hz, m/s\\^2, axes x,y,z$"):
        kind.check(Signal(np.zeros((3, 4)), 1000, "m/s^2"))


def test_a_kind_says_how_axes_of_other_names_are_read():
    kind = SignalKind(330, "m/s^2", ("x", "y", "z"))
    with pytest.raises(ParameterError, match=r"got .* axes ax,ay,az; read it with axes x,y,z if these"):
        kind.check(Signal(np.zeros((3, 4)), 330, "m/s^2", ("ax", "ay", "az")))


def test_a_kind_over_displacement_refuses_a_signal_over_time():
    kind = SignalKind(40, "1", ("friction",), domain="displacement")
    kind.check(Signal(np.zeros((1, 4)), 40, "1", ("friction",), "displacement"))
    with pytest.raises(ParameterError, match="must be 40 samples per mm.*got 40 Hz"):
        kind.check(Signal(np.zeros((1, 4)), 40, "1", ("friction",)))
    with pytest.raises(ParameterError, match="domain must be 'time' or 'displacement'"):
        SignalKind(40, "1", ("friction",), domain="space")
