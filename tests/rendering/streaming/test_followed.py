"""Motion that is followed without a stream."""

import numpy as np
import pytest

from tactogram.errors import DataError, ParameterError
from tactogram.rendering.streaming.finger_path import followed
from tactogram.rendering.streaming.recorded_motion import MotionFile, SimulatedHand
from tactogram.workflows.generation.generate import motion_of


@pytest.fixture
def written(tmp_path):
    """Give a function that writes a motion file of few samples and follows it."""

    def follow(text):
        path = tmp_path / "motion.csv"
        path.write_text(text)
        source = MotionFile(path)
        source.fill(source.seconds)
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


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("time_s,force_n\n0,1\n1,1\n", "motion.csv: has neither speed_mm_s nor x_mm"),
        ("time_s,speed_mm_s,force_n\n0,,1\n1,,1\n", "motion.csv: has neither speed_mm_s nor x_mm"),
        ("time_s,x_mm,y_mm\n0,1,\n1,2,\n", "positions have x_mm and y_mm"),
        ("time_s,speed_mm_s\n0,20000\n1,20000\n", "speeds must be at most 10000 mm/s"),
    ],
)
def test_a_motion_without_a_speed_of_a_finger_is_refused(written, text, message):
    with pytest.raises(DataError, match=message):
        written(text)


def test_a_motion_is_at_least_as_long_as_asked(tmp_path):
    path = tmp_path / "motion.csv"
    path.write_text("time_s,speed_mm_s\n0,100\n2.0007,100\n")
    assert motion_of(path).seconds == pytest.approx(2.001)
    assert motion_of(path, seconds=0.5003).seconds == pytest.approx(0.501)
    assert motion_of("simulated", seconds=0.0105).seconds >= 0.0105


def test_what_is_no_motion_is_refused_before_it_is_followed(tmp_path):
    path = tmp_path / "motion.csv"
    for last, more, message in (
        ("1e12", {}, "motion.csv: a motion must have two times or more, and last at most 3600 s, got 1e"),
        ("2", {"seconds": 3.0}, "at most the motion's 2, got 3"),
        ("2", {"seed": -1}, "seed must be >= 0"),
        ("2", {"seconds": 1e9}, "at most 3600"),
    ):
        path.write_text(f"time_s,speed_mm_s\n0,100\n{last},100\n")
        with pytest.raises(ParameterError, match=message):
            motion_of(path, **more)
    path.write_text("time_s,speed_mm_s\n0,100\n")
    with pytest.raises(ParameterError, match="must have two times or more"):
        motion_of(path)
