"""Motion that is followed without a stream."""

import numpy as np
import pytest

from tactogram.rendering.streaming.finger_path import followed
from tactogram.rendering.streaming.recorded_motion import MotionFile
from tactogram.rendering.streaming.simulated_hand import SimulatedHand


@pytest.fixture
def written(tmp_path):
    """Give a function that writes a motion file of few samples and follows it."""

    def follow(text):
        path = tmp_path / "motion.csv"
        path.write_text(text)
        source = MotionFile(path, dense=True)
        return followed(source, source.seconds)

    return follow


def test_speeds_and_forces_of_few_samples_are_followed(written):
    motion = written("time_s,speed_mm_s,force_n\n5,0,0.5\n6,200,\n7,200,1.5\n")
    assert motion.seconds == 2.0
    np.testing.assert_allclose(motion.at("speed_mm_s", [0.5, 1.5]), [100, 200], atol=6)
    np.testing.assert_allclose(motion.at("force_n", [0.5, 1.5]), [0.75, 1.25], atol=0.02)
    np.testing.assert_allclose(motion.at("gain", [0.0, 0.5, 1.9]), [0, 1, 1], atol=1e-3)


def test_the_speed_comes_from_positions_and_a_force_that_is_missing_is_unknown(written):
    motion = written("time_s,x_mm,y_mm\n0,0,0\n1,30,40\n2,0,0\n")
    assert motion.force_n is None
    np.testing.assert_allclose(motion.at("speed_mm_s", [0.5, 1.5]), 50, rtol=0.02)


def test_a_lifted_or_resting_finger_has_no_gain(written):
    motion = written(
        "time_s,speed_mm_s,force_n\n0,100,1\n1,100,1\n1.1,100,0\n2,100,0\n2.1,100,1\n3,0,1\n3.5,0,1\n"
    )
    np.testing.assert_array_equal(motion.at("gain", [0.8, 1.5, 2.5, 3.4]), [1, 0, 1, 0])


def test_a_simulated_hand_is_followed():
    motion = followed(SimulatedHand(5.0, seed=0), 5.0)
    assert motion.seconds == 5.0
    assert 0.3 < motion.gain.mean() < 0.9
    assert 100 < motion.speed_mm_s.max() < 500
    assert 0.4 < motion.force_n[motion.gain == 1].mean() < 0.8
