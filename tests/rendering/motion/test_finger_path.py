"""The path of a finger, and motions that are followed."""

import math

import numpy as np
import pytest

from tactogram.errors import DataError, ParameterError
from tactogram.rendering.motion.finger_path import FingerTracker, followed
from tactogram.rendering.motion.finger_state import FingerState
from tactogram.rendering.motion.recorded_motion import MotionFile, SimulatedHand
from tactogram.workflows.generation.generate import motion_of


def follow(script, seconds, *, rate=8000.0, most=40):
    finger, follower = FingerState(), FingerTracker(rate, most)
    kept = {name: [] for name in ("x_mm", "speed_mm_s", "contact", "movement", "path_mm")}
    states = []
    for block in range(round(seconds * rate / most)):
        now = block * most / rate
        for sample in script.poll(now):
            finger.update(sample, now)
        motion = follower.follow(finger, now, most)
        states.append(follower.state)
        for name, values in kept.items():
            values.append(getattr(motion, name)[:most].copy())
    return {name: np.concatenate(values) for name, values in kept.items()}, states


def test_the_follower_is_where_the_finger_is(script):
    found, _ = follow(script(lambda t: 80 * math.sin(2 * t), rate=250.0), 3.0)
    t = (np.arange(len(found["x_mm"])) + 1) / 8000
    later = t > 0.2
    assert np.abs(found["x_mm"] - 80 * np.sin(2 * t))[later].max() < 0.6
    assert np.abs(found["speed_mm_s"] - np.abs(160 * np.cos(2 * t)))[later].max() < 12


def test_place_and_speed_have_no_jump_though_positions_come_in_steps(script):
    found, _ = follow(script(lambda t: 80 * math.sin(2 * t), rate=60.0), 2.0)
    acceleration = np.abs(np.diff(found["speed_mm_s"])) * 8000
    assert acceleration[2000:].max() < 20_000  # mm/s^2: 2.5 mm/s from sample to sample
    assert np.abs(np.diff(found["x_mm"]))[2000:].max() < 250 / 8000


def test_rest_landing_and_lift_are_states_with_ramps(script):
    def place(t):
        return 100 * max(0.0, t - 0.2) if t < 0.5 else 30.0

    force = lambda t: 0.5 if 0.1 < t < 0.8 else 0.0  # noqa: E731
    found, states = follow(script(place, force), 1.0)
    assert [states[int(t / 0.005)] for t in (0.05, 0.18, 0.4, 0.7, 0.95)] == [
        "air",
        "rest",
        "slide",
        "rest",
        "air",
    ]
    assert np.abs(np.diff(found["contact"])).max() < 0.07
    assert np.abs(np.diff(found["movement"])).max() < 0.07
    assert (found["contact"][-1], found["movement"][-1]) == (0, 0)


def test_a_finger_that_lands_elsewhere_makes_no_stroke_there(script):
    place = lambda t: 10.0 if t < 0.5 else 200.0  # noqa: E731
    force = lambda t: 0.0 if 0.3 < t < 0.7 else 0.5  # noqa: E731
    found, _ = follow(script(place, force), 1.0)
    assert (found["speed_mm_s"] * found["contact"]).max() < 1
    assert found["x_mm"][-1] == pytest.approx(200, abs=0.01)


def test_a_jump_while_touching_fades_before_it_goes_there(script):
    found, _ = follow(script(lambda t: 10.0 if t < 0.5 else 200.0), 1.0)
    assert (found["speed_mm_s"] * found["contact"]).max() < 5
    assert found["contact"].min() == 0
    assert found["contact"][-1] == 1
    assert found["x_mm"][-1] == pytest.approx(200, abs=0.01)


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
