"""Motion of a simulated hand and of a file."""

import math

import numpy as np
import pytest

from tactogram.errors import DataError
from tactogram.rendering.motion.recorded_motion import MotionFile, SimulatedHand


def test_a_simulated_hand_strokes_rests_and_lifts():
    hand = SimulatedHand(20, seed=3, noise_mm=0)
    samples = hand.poll(20.0)
    places = np.array([(s.time_s, s.x_mm) for s in samples if s.x_mm == s.x_mm])
    forces = np.array([s.force_n for s in samples if s.force_n == s.force_n])
    speed = np.abs(np.diff(places[:, 1]) / np.diff(places[:, 0]))
    assert len(places) == 5000
    assert len(forces) == 10_000
    assert 100 < speed.max() < 1.875 * 120 / 0.4 + 400
    assert 0.02 < np.mean(forces == 0) < 0.5
    assert 0.3 < forces[forces > 0].mean() < 0.9
    again = SimulatedHand(20, seed=3, noise_mm=0).poll(20.0)
    assert repr(again) == repr(samples)


def test_a_motion_file_is_read_with_its_gaps(tmp_path):
    path = tmp_path / "motion.csv"
    path.write_text("time_s,x_mm,force_n\n5.0,1.5,\n5.1,,0.4\n5.2,2.5,0.5\n")
    motion = MotionFile(path)
    assert [s.time_s for s in motion.poll(0.15)] == pytest.approx([0.0, 0.1])
    (last,) = motion.poll(1.0)
    assert (last.x_mm, last.y_mm, last.force_n) == (2.5, 0.0, 0.5)
    assert math.isnan(last.speed_mm_s)


@pytest.mark.parametrize(
    ("text", "says"),
    [
        ("", "expected columns"),
        ("time_s,speed\n0,1\n", "line 1: expected columns"),
        ("time_s,force_n\n", "no motion"),
        ("time_s,force_n\n0,1\n0,1\n", "line 3: times must ascend"),
        ("time_s,force_n\n0,-1\n", "line 2: speed and force"),
        ("time_s,force_n\n0,a\n", "line 2: expected 2 numbers"),
        ("time_s,y_mm\n0,1\n", "y_mm needs x_mm"),
    ],
)
def test_a_wrong_motion_file_is_refused_by_its_line(tmp_path, text, says):
    path = tmp_path / "motion.csv"
    path.write_text(text)
    with pytest.raises(DataError, match=says):
        MotionFile(path)
