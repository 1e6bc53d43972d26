import math

import numpy as np
import pytest

from tactogram.rendering.displays.catalogue import open_display
from tactogram.signal import Signal, detection_threshold
from tactogram.signal.io import write_signal
from tactogram.workflows.rendering.render import render
from tactogram_studio.pages.send.display import output_db, warnings_of


def output(folder, amplitude, level):
    t = np.arange(4000) / 4000
    signal = Signal((amplitude * np.sin(2 * np.pi * 200 * t)).astype(np.float32), 4000, "m/s^2")
    write_signal(folder / "tone.npz", signal)
    facts = render(folder / "tone.npz", folder / "d.wav", display="voice-coil", level=level)
    return output_db(facts["report"], signal)


def test_whether_the_output_is_felt_depends_on_the_level(tmp_path):
    threshold = float(detection_threshold(200.0, "m/s^2"))
    assert output(tmp_path, 0.1 * threshold, "physical") == pytest.approx(-20, abs=1)
    assert output(tmp_path, 0.1 * threshold, "sensation=10") == pytest.approx(10, abs=1)
    assert output(tmp_path, 0.1 * threshold, "peak=0.5") > 0


def test_a_silent_drive_is_not_felt_and_an_unknown_output_not_judged(tmp_path):
    assert output(tmp_path, 0.0, "physical") == -math.inf
    write_signal(tmp_path / "n.npz", Signal(np.sin(np.arange(4000)).astype(np.float32), 4000, "N"))
    report = render(tmp_path / "n.npz", tmp_path / "n.wav", display="audio", level="peak=0.1")["report"]
    assert output_db(report, None) is None


def test_the_most_dangerous_is_said_first(tmp_path):
    t = np.arange(4000) / 4000
    write_signal(tmp_path / "mu.npz", Signal((0.34 + 0.04 * np.sin(60 * t)).astype(np.float32), 4000, "1"))
    report = render(tmp_path / "mu.npz", tmp_path / "d.wav", display="electrovibration", level="peak=0.5")[
        "report"
    ]
    first = warnings_of(open_display("electrovibration"), report)[0]
    assert "limits the current" in first
