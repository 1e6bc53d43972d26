"""Two axes of a source from a given moment, without samples that waited before."""

import numpy as np
import pytest

from tactogram.capture.source import Block
from tactogram.capture.stream.axis_pair import PairRecorder
from tactogram.errors import DeviceError, ParameterError


class Numbered:
    """A source whose samples are their own places, in blocks of ``step``; ``waiting`` arrived before the first read."""

    name, unit = "numbered", "V"

    def __init__(self, *, waiting=0, step=7, rate=1000.0, axes=("v", "i", "x"), ends=10**9):
        self.axes, self.rate, self.step, self.ends = axes, rate, step, ends
        self.next, self.waiting = 0, waiting

    def read(self, timeout_s=0.1):
        count = self.waiting if timeout_s == 0 else self.step
        self.waiting = 0
        if count == 0 or self.next >= self.ends:
            return None
        at = np.arange(self.next, self.next + count, dtype=np.float32)
        self.next += count
        return Block(np.stack([at, -at, 0 * at]), int(at[0]), 0.0)


def test_waiting_and_settling_samples_are_left_out():
    source = Numbered(waiting=500)
    v, i = PairRecorder(source).take(0.02, after_s=0.03)
    np.testing.assert_array_equal(v, np.arange(530, 550))
    np.testing.assert_array_equal(i, -v)
    again, _ = PairRecorder(source, ("i", "v")).take(0.005, after_s=0.0)
    assert again[0] <= -550
    assert len(again) == 5


def test_a_silent_source_ends_the_recording():
    now = iter(np.arange(0, 100, 0.5))
    with pytest.raises(DeviceError, match="no samples for 2 s"):
        PairRecorder(Numbered(ends=0), clock=lambda: next(now)).take(0.1, after_s=0.0)


@pytest.mark.parametrize(
    ("source", "axes", "says"),
    [
        (Numbered(axes=("v",)), None, "needs two of its axes"),
        (Numbered(), ("v", "v"), "needs two of its axes"),
        (Numbered(), ("v", "y"), "it has v, i, x"),
        (Numbered(rate=None), None, "at a known rate"),
    ],
)
def test_invalid_pairs_of_axes_are_refused(source, axes, says):
    with pytest.raises(ParameterError, match=says):
        PairRecorder(source, axes)
