"""Motion of a finger over time."""

import numpy as np
import pytest

from tactogram.errors import ParameterError
from tactogram.signal.motion import Motion

TIMES = np.array([0.0, 1.0, 3.0])


def test_it_is_linear_between_its_samples_and_held_at_the_ends():
    motion = Motion(TIMES, np.array([0.0, 100.0, 300.0]))
    assert motion.seconds == 3.0
    np.testing.assert_allclose(motion.at("speed_mm_s", [-1, 0.5, 2, 9]), [0, 50, 200, 300])
    assert motion.at("force_n", [1.0]) is None


@pytest.mark.parametrize(
    ("arrays", "message"),
    [
        ({"time_s": TIMES + 1}, "begin with 0"),
        ({"time_s": np.array([0.0, 2.0, 2.0])}, "ascend"),
        ({"speed_mm_s": np.array([0.0, -1.0, 2.0])}, "speed_mm_s of a motion must be finite and >= 0"),
        ({"force_n": np.ones(2)}, "one number for each"),
        ({"gain": np.array([0.0, np.nan, 1.0])}, "gain"),
        ({"contact": np.array([0.0, 2.0, 1.0])}, "contact of a motion must be at most 1, got 2"),
        ({"time_s": np.zeros(1), "speed_mm_s": np.ones(1)}, "at least two"),
    ],
)
def test_what_is_no_motion_is_refused(arrays, message):
    with pytest.raises(ParameterError, match=message):
        Motion(**{"time_s": TIMES, "speed_mm_s": np.ones(3)} | arrays)
