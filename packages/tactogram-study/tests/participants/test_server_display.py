"""The server's display: one stimulus at a time, stopped by whom it plays to."""

import threading

import numpy as np
import pytest

from tactogram.errors import ParameterError
from tactogram.rendering.displays.catalogue import open_display
from tactogram.signal import Signal
from tactogram_study.participants.server_display import DisplayInUseError, ServerDisplay


def test_a_stimulus_that_plays_is_stopped_by_its_owner_alone(until):
    coil = open_display("voice-coil")
    drive = Signal(0.1 * np.ones((1, 60 * 8000), np.float32), 8000.0, "V", ("coil",))
    display, facts = ServerDisplay("null", full_scale=5.0), []
    playing = threading.Thread(target=lambda: facts.append(display.play("anna", drive, coil)))
    playing.start()
    until(lambda: display._owner == "anna")
    with pytest.raises(DisplayInUseError, match="playing to another participant"):
        display.play("ben", drive, coil)
    assert not display.stop("ben")
    assert display.stop("anna")
    playing.join(30)
    assert len(facts) == 1
    assert not display.stop("anna")  # it has ended


def test_what_the_device_cannot_drive_is_refused_beforehand():
    with pytest.raises(ParameterError, match="full_scale"):
        ServerDisplay("audio").check(open_display("voice-coil"))
    ServerDisplay("audio", full_scale=5.0).check(open_display("voice-coil"))
    tracked = ServerDisplay("null", track={})
    with pytest.raises(ParameterError, match="the carrier of a Digilent is tracked, got the device null"):
        tracked.check(open_display("ultrasonic-envelope"), streams=True)
