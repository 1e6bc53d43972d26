"""Waveforms of Android: steps of whole ms."""

import numpy as np
import pytest
from tests.rendering.files.documents import RATE, again, bursts, level, problems, read, written_by

from tactogram.rendering.files.formats import android
from tactogram.signal import Signal


def test_android_steps_are_whole_ms_and_0_to_255():
    document = written_by(android, bursts((0.2, 0.5)))
    assert problems(android, document) == []
    assert sum(document["timings"]) == 1000
    at = np.repeat(document["amplitudes"], document["timings"])
    assert at[[100, 350, 800]] == pytest.approx([0, 0.8 * 255, 0], abs=2)
    assert level(document, android, [0.1, 0.35, 0.8]) == pytest.approx([0, 0.8, 0], abs=0.02)


def test_android_joins_equal_steps():
    document = written_by(android, Signal(np.zeros(RATE), RATE, "1"))
    assert (document["timings"], document["amplitudes"]) == ([1000], [0])


@pytest.mark.parametrize(
    ("changes", "problem"),
    [
        ({"timings": [10]}, "equally many, got 1 and 2"),
        ({"timings": [0, 0]}, "above 0 ms"),
        ({"timings": [10, -1]}, "timings must be 0 to 8.64e+07, got -1: clamped"),
        ({"timings": [10, 100.5]}, "timings must be whole ms, got 100.5"),
        ({"timings": [10, "5"]}, "timings must be a number, got '5': read as one"),
        ({"timings": [10, "x"]}, "timings: must be a number, got 'x'"),
        ({"amplitudes": [0, 256]}, "amplitudes must be -1 to 255, got 256: clamped"),
        ({"repeat": 2}, "repeat must be -1 to 1, got 2: clamped"),
    ],
)
def test_android_rules(changes, problem):
    good = {"timings": [10, 20], "amplitudes": [0, 255], "repeat": -1}
    assert problems(android, good) == []
    assert any(problem in line for line in problems(android, good | changes))


def test_android_repetition_is_left_out_and_said():
    document = {"timings": [100], "amplitudes": [255], "repeat": 0}
    assert read(android, document).facts["left_out"] == "repetition from entry 0"


@pytest.mark.parametrize("ms", [8, 15, 30, 50, 60, 90])
def test_pulses_of_a_phone_keep_their_length(ms, tmp_path):
    android = {"timings": [100, ms, 100, ms, 50], "amplitudes": [0, 255, 0, 128, 0]}
    document, found = again(tmp_path, android, "android")
    assert {key: document[key] for key in android} == android
    assert found["told"][0].endswith("loses nothing.")
    if ms >= 40:
        document, found = again(tmp_path, [ms, 100, ms], "vibration")
        assert document["pattern"] == [ms, 100, ms]
        document, found = again(tmp_path, [ms, 100, ms], "android")
        assert (document["timings"], document["amplitudes"]) == ([ms, 100, ms], [255, 0, 255])
        assert found["told"][0].endswith("loses nothing.")
