"""Envelopes of Android: 16 points within their limits."""

import numpy as np
import pytest
from tests.rendering.files.documents import problems, read, written_by

from tactogram.errors import ParameterError
from tactogram.rendering.files.analysis import envelope_of
from tactogram.rendering.files.events import Events, Transient
from tactogram.rendering.files.formats import android_basic, android_envelope
from tactogram.signal import Signal

RATE = 2000


def tone(amplitude, hz, seconds):
    """Return a sine whose amplitude and frequency are given at the ends of equal lines."""
    t = np.arange(round(seconds * RATE)) / RATE
    places = np.linspace(0, seconds, len(amplitude))
    phase = 2 * np.pi * np.cumsum(np.interp(t, np.linspace(0, seconds, len(hz)), hz)) / RATE
    return Signal(np.interp(t, places, amplitude) * np.sin(phase), RATE, "1")


def written(signal, module=android_envelope):
    document = written_by(module, signal)
    assert problems(module, document) == []
    return document, np.array([list(point.values()) for point in document["controlPoints"]])


def test_the_corners_of_an_envelope_become_its_points():
    _, points = written(tone([0, 0.8, 0.2, 0.6, 0], [150], 2.0))
    times = np.cumsum(points[:, 2])
    assert times[-1] == 2000
    found = np.interp([250, 500, 750, 1000, 1250, 1500, 1750], [0, *times], [0, *points[:, 0]])
    assert found == pytest.approx([0.4, 0.8, 0.5, 0.2, 0.4, 0.6, 0.3], abs=0.03)
    assert points[:-1, 1] == pytest.approx(150, abs=2)


def test_a_steady_tone_takes_a_rise_lines_of_1_s_and_a_fall():
    _, points = written(tone([0.9, 0.9], [150], 2.5))
    assert points[:, 2].tolist() == [20, *points[1:-1, 2], 20]
    assert sorted(points[1:-1, 2])[-1] <= 1000
    assert len(points) == 5
    assert points[:, 0] == pytest.approx([0.9] * 4 + [0], abs=0.01)


def test_a_sweep_of_frequency_is_kept_and_read_back():
    document, points = written(tone([0.7, 0.7], [100, 250], 2.0))
    hz = np.interp([500, 1000, 1500], np.cumsum(points[:, 2]), points[:, 1])
    assert hz == pytest.approx([137.5, 175, 212.5], abs=3)
    back = envelope_of(read(android_envelope, document).signal)
    assert np.interp([0.5, 1, 1.5], back.times, back.frequency) == pytest.approx(hz, abs=3)
    assert np.interp(1, back.times, back.amplitude) == pytest.approx(0.7, abs=0.01)


def test_a_busy_envelope_takes_16_points_within_the_limits():
    rng = np.random.default_rng(3)
    _, points = written(tone(rng.uniform(0, 1, 60), [150], 4.09))
    assert len(points) == 16
    assert (points[:, 2].min() >= 20, points[:, 2].max() <= 1000, points[:, 2].sum()) == (True, True, 4090)
    assert points[-1, 0] == 0


@pytest.mark.parametrize("seconds", [0.039, 16.001])
def test_a_signal_beyond_the_limits_is_refused(seconds):
    signal = Signal(np.ones(round(seconds * 1000)), 1000, "1")
    with pytest.raises(ParameterError, match=f"lasts 40 to 16000 ms, got {round(seconds * 1000)} ms; cut it"):
        written_by(android_envelope, signal)


def test_the_longest_signal_takes_16_lines_of_1_s():
    _, points = written(tone([0.5, 0.5], [150], 16.0))
    assert points[:, 2].tolist() == [1000] * 16


POINT = {"amplitude": 0.5, "frequencyHz": 150.0, "durationMillis": 100}
BASIC = {"intensity": 0.0, "sharpness": 0.5, "durationMillis": 100}


@pytest.mark.parametrize(
    ("module", "points", "problem"),
    [
        (android_envelope, [POINT | {"amplitude": 1.1}], "amplitude must be 0 to 1, got 1.1: clamped"),
        (android_envelope, [POINT | {"frequencyHz": "x"}], "controlPoints.0.frequencyHz: must be a number"),
        (android_envelope, [POINT | {"durationMillis": 19}], "durationMillis must be 20 to 1000, got 19"),
        (android_envelope, [POINT | {"durationMillis": 1001}], "durationMillis must be 20 to 1000, got 1001"),
        (android_envelope, [POINT] * 17, "at most 16 points, got 17"),
        (android_envelope, [], "controlPoints: must not be empty"),
        (
            android_basic,
            [BASIC | {"intensity": 0.1}],
            "last control point must have an intensity of 0, got 0.1",
        ),
        (android_basic, [BASIC | {"sharpness": -0.1}, BASIC], "sharpness must be 0 to 1, got -0.1"),
    ],
)
def test_each_limit_is_checked(module, points, problem):
    good = POINT if module is android_envelope else BASIC
    assert problems(module, {"controlPoints": [good] * 16}) == []
    [line] = problems(module, {"controlPoints": points})
    assert problem in line


def test_a_transient_is_a_peak_of_two_lines_and_read_as_one():
    taps = tuple(Transient(time, share, 200.0) for time, share in ((0.0, 0.8), (0.3, 0.4), (0.7, 1.0)))
    document, points = written(Events.of([], taps))
    assert points[:, 2].tolist() == [20, 20, 260, 20, 20, 360, 20, 20]
    assert read(android_envelope, document).events.transients == taps
