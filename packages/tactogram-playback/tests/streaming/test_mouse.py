"""A mouse as a finger."""

import os

import pytest

from tactogram.errors import DeviceError
from tactogram_playback.streaming.mouse import MouseMotion, mouse_step


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
