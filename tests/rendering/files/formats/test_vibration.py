"""Patterns of phones: on and off."""

import json

import numpy as np
import pytest
from tests.rendering.files.documents import RATE, bursts, level, problems, read, written_by

from tactogram.errors import ParameterError
from tactogram.rendering.displays.catalogue import open_display
from tactogram.rendering.files import read_haptic, write_haptic
from tactogram.rendering.files.documents import DocumentHeader
from tactogram.rendering.files.events import Events, Part
from tactogram.rendering.files.formats import vibration
from tactogram.signal import Signal


def test_a_pattern_vibrates_in_its_odd_entries():
    document = written_by(vibration, bursts((0.2, 0.5), (0.7, 0.8)))
    assert problems(vibration, document) == []
    assert document["pattern"] == pytest.approx([0, 200, 300, 200, 100], abs=12)
    assert level(document, vibration, [0.1, 0.35, 0.6, 0.75]) == pytest.approx([0, 1, 0, 1], abs=0.05)


def test_short_pauses_are_filled_and_short_pulses_lengthened():
    on = np.ones(100, bool)
    on[[40, 41, 42]] = False
    assert vibration._entries(vibration._cleaned(on, 10)) == [100]
    on = np.zeros(100, bool)
    on[50:53] = True
    assert vibration._entries(vibration._cleaned(on, 10)) == [0, 50, 10]


def test_pulses_at_the_end_and_pauses_after_lengthened_pulses_are_long_enough():
    on = np.zeros(100, bool)
    on[[10, 50, 98]] = True
    assert vibration._entries(vibration._cleaned(on, 35)) == [0, 10, 90]
    assert vibration._entries(vibration._cleaned(on, 10)) == [0, 10, 10, 30, 10, 30, 10]


@pytest.mark.parametrize("shortest_ms", [10, 35, 60])
def test_a_motor_gets_no_shorter_pulse_than_it_needs(shortest_ms, tmp_path):
    signal = bursts((0.1, 0.115), (0.3, 0.345), (0.36, 0.5), (0.7, 0.712), (0.99, 1.0))
    motor = open_display("phone-on-off", changes={"shortest_ms": shortest_ms})
    write_haptic(tmp_path / "x.json", signal, format="vibration", motor=motor)
    pattern = json.loads((tmp_path / "x.json").read_text())["pattern"]
    assert len(pattern) >= 6
    assert min(pattern[1:]) >= shortest_ms
    short = bursts((0, 0.02), seconds=0.02)
    assert written_by(vibration, short, DocumentHeader(shortest_ms=shortest_ms))["pattern"] == [
        max(20, shortest_ms)
    ]


def test_the_shipped_motor_is_the_default():
    shipped = open_display("phone-on-off").shortest_ms
    assert written_by(vibration, bursts((0, 0.02), seconds=0.02))["pattern"] == [shipped]


def test_a_display_without_that_fact_or_a_format_without_use_for_it_is_refused(tmp_path):
    with pytest.raises(
        ParameterError, match="voice-coil: states no shortest_ms, which a pattern of on and off"
    ):
        write_haptic(tmp_path / "x", bursts((0, 1)), format="vibration", motor=open_display("voice-coil"))
    with pytest.raises(ParameterError, match="Android waveform does not only switch on and off; omit"):
        write_haptic(tmp_path / "x", bursts((0, 1)), format="android", motor=open_display("phone-on-off"))
    assert list(tmp_path.iterdir()) == []


def test_a_long_vibration_is_split_and_a_busy_one_made_coarser():
    t = np.arange(25 * RATE) / RATE
    long = written_by(vibration, Signal(np.sin(2 * np.pi * 150 * t), RATE, "1"))
    assert long["pattern"] == [10000, 0, 10000, 0, 5000]
    busy = written_by(
        vibration, bursts(*[(k / 10, k / 10 + 0.05) for k in range(100)], seconds=10), DocumentHeader()
    )
    assert problems(vibration, busy) == []
    assert len(busy["pattern"]) <= 99


@pytest.mark.parametrize(
    ("signal", "message"),
    [
        (Signal(np.zeros(RATE), RATE, "1"), "silent"),
        (Signal(np.ones(1), 1e5, "1"), "at least 1 ms"),
        (Signal(np.sin(np.arange(520 * 200)), 200, "1"), "holds 99 entries of 10000 ms"),
    ],
)
def test_what_no_pattern_can_hold_is_refused(signal, message):
    with pytest.raises(ParameterError, match=message):
        written_by(vibration, signal)


@pytest.mark.parametrize(
    ("document", "problem"),
    [
        ([], "must be above 0 ms"),
        ([100] * 100, "at most 99 entries, got 100: Chromium drops the rest"),
        ([10_001], "an entry must be at most 10000 ms, got 10001"),
        ([0, 100], "must be above 0 ms"),
        ([50, -1, 100], "pattern must be at least 0, got -1: clamped"),
        ({"format": "w3c-vibration"}, "pattern: is required"),
        ("buzz", "pattern: is required"),
    ],
)
def test_pattern_rules(document, problem):
    assert any(problem in line for line in problems(vibration, document)), problems(vibration, document)


def test_a_bare_list_is_a_pattern_and_a_last_pause_does_not_count():
    assert problems(vibration, [100, 50]) == []
    assert read(vibration, [100, 50]).signal.seconds == pytest.approx(0.1)


@pytest.mark.parametrize("format", ["gamepad", "vibration", "haptic"])
def test_another_length_of_a_pulse_is_told(format, tmp_path):
    (tmp_path / "one.json").write_text('{"timings": [100, 30, 100], "amplitudes": [0, 255, 0]}')
    found = write_haptic(tmp_path / "two", read_haptic(tmp_path / "one.json"), format=format)
    assert "loses the length of 1 of 1 transient" in found["told"][0]


def test_short_vibrations_that_are_read_as_pulses_are_kept(tmp_path):
    spans = [(0.1 * i, 0.1 * i + 0.06) for i in range(10)]
    parts = [Part.of(span, [0.64, 0.64], 0.0, 150.0) for span in spans]
    found = write_haptic(tmp_path / "x.json", Events.of(parts, []), format="gamepad")
    assert found["told"] == [
        "The file keeps the strength over time, the level and the frequency; loses nothing."
    ]


def test_a_single_number_is_a_pattern(tmp_path):
    (tmp_path / "x.json").write_text("200")
    assert read_haptic(tmp_path / "x.json").facts["format"] == "vibration"
    assert read_haptic(tmp_path / "x.json").events.seconds == pytest.approx(0.2)
