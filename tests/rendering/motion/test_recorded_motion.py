"""Motion of a simulated hand, a file and a mouse."""

import math
import os

import numpy as np
import pytest

from tactogram.errors import DataError, DeviceError
from tactogram.rendering.motion.recorded_motion import MotionFile, MouseMotion, SimulatedHand, mouse_step


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


def test_a_mouse_packet_is_buttons_right_and_up():
    assert mouse_step(bytes([0x09, 5, 7])) == (True, 5, 7)
    assert mouse_step(bytes([0x38, 0xFB, 0xF9])) == (False, -5, -7)


def test_a_mouse_moves_the_finger(tmp_path):
    pipe = tmp_path / "mice"
    os.mkfifo(pipe)
    mouse = MouseMotion(path=pipe, counts_per_mm=10.0)
    with open(pipe, "wb", buffering=0) as device:
        device.write(bytes([0x09, 50, 0, 0x09]))
        (first,) = mouse.poll(0.0)
        device.write(bytes([50, 20]))
        (second,) = mouse.poll(0.01)
    mouse.close()
    assert (first.x_mm, first.y_mm, first.force_n) == (5.0, 0.0, 0.5)
    assert (second.x_mm, second.y_mm) == (10.0, 2.0)


def test_a_mouse_that_is_not_there_is_one_line(tmp_path):
    with pytest.raises(DeviceError, match="cannot be read"):
        MouseMotion(path=tmp_path / "none")
