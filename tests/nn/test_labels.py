"""Labels: numbers standardised by the training recordings, and those that were not learned."""

import numpy as np
import pytest

from tactogram.errors import ParameterError
from tactogram.model import Example
from tactogram.nn.labels import ConditionRange, Labels
from tactogram.signal import Signal


def fitted(names, *conditions):
    labels = Labels(names)
    signal = Signal(np.zeros(8), 1000, "m/s^2")
    labels.fit([Example(str(number), signal, "cork", each) for number, each in enumerate(conditions)])
    return labels


SPEEDS = [{"speed_mm_s": 50.0}, {"speed_mm_s": 100.0}, {"speed_mm_s": 150.0}]
SPREAD = 50 * (2 / 3) ** 0.5


def test_the_median_is_0_a_deviation_1_and_beyond_the_recorded_the_nearest():
    known = ConditionRange(100.0, 20.0, 60.0, 150.0)
    assert [known.standardised(value) for value in (100, 120, 150, 900, 0)] == [0, 1, 2.5, 2.5, -2]
    assert ConditionRange(100.0, 0.0, 100.0, 100.0).standardised(120) == 0


def test_a_label_is_the_weights_and_then_the_numbers():
    labels = fitted(("speed_mm_s", "force_n"), *SPEEDS)
    label = labels.label(np.array([0.25, 0.75]), {"speed_mm_s": 150.0})
    np.testing.assert_allclose(label, [0.25, 0.75, 50 / SPREAD, 0], rtol=1e-6)
    assert labels.numbers({}) == [0, 0]
    assert labels.limited == {"speed_mm_s": (50.0, 150.0)}


def test_a_number_that_one_recording_lacks_is_unknown():
    labels = fitted(("speed_mm_s",), *SPEEDS, {})
    assert labels.numbers({"speed_mm_s": 150.0}) == [0]
    with pytest.raises(ParameterError, match="speed_mm_s is unknown for the training recordings; omit it"):
        labels.check({"speed_mm_s": 100.0})


def test_a_number_that_is_invalid_or_was_not_learned_is_refused():
    labels = fitted((), *SPEEDS)
    labels.check({"speed_mm_s": 150.0})
    with pytest.raises(ParameterError, match=r"was 50 to 150 in training .* got 151; omit it"):
        labels.check({"speed_mm_s": 151.0})
    fitted(("speed_mm_s",), *SPEEDS).check({"speed_mm_s": 151.0})
    for value in (-1.0, float("nan")):
        with pytest.raises(ParameterError, match="speed_mm_s must be finite and >= 0"):
            labels.check({"speed_mm_s": value})


def test_ranges_come_back():
    labels, again = fitted(("speed_mm_s",), *SPEEDS), Labels(("speed_mm_s",))
    again.load_state(labels.state())
    assert again.ranges == labels.ranges == {"speed_mm_s": (100.0, pytest.approx(SPREAD), 50.0, 150.0)}
