import json

import numpy as np
import pytest
from tests.rendering.files.documents import problems, read, written_by

from tactogram.errors import ParameterError
from tactogram.rendering.displays.catalogue import open_display
from tactogram.rendering.files import read_haptic, write_haptic
from tactogram.rendering.files.analysis import envelope_of
from tactogram.rendering.files.documents import DocumentHeader
from tactogram.rendering.files.events import Events, Part
from tactogram.rendering.files.formats import android, gamepad, vibration
from tactogram.signal import Signal

RATE = 2000


def bursts(*spans, seconds=1.0, hz=150, strength=0.8):
    t = np.arange(round(seconds * RATE)) / RATE
    on = np.zeros(len(t), bool)
    for start, stop in spans:
        on |= (t >= start) & (t < stop)
    return Signal(np.where(on, strength * np.sin(2 * np.pi * hz * t), 0.0), RATE, "1")


def level(document, module, time):
    found = envelope_of(read(module, document).signal)
    return np.interp(time, found.times, found.amplitude)


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


def test_slow_drives_the_strong_motor_and_fast_the_weak_one():
    for hz, strong, weak in ((50, 0.8, 0), (250, 0, 0.8)):
        document = written_by(gamepad, bursts((0, 1), hz=hz))
        assert problems(gamepad, document) == []
        effect = document["effects"][len(document["effects"]) // 2]
        assert (effect["strongMagnitude"], effect["weakMagnitude"]) == pytest.approx((strong, weak), abs=0.03)
        assert level(document, gamepad, 0.5) == pytest.approx(0.8, abs=0.05)


def test_a_long_rumble_is_a_sequence_of_at_most_5_s():
    t = np.arange(12 * RATE) / RATE
    document = written_by(gamepad, Signal(np.sin(2 * np.pi * 150 * t), RATE, "1"))
    durations = [effect["duration"] for effect in document["effects"]]
    assert (sum(durations), max(durations)) == (12_000, 5000)


@pytest.mark.parametrize(
    ("changes", "problem"),
    [
        ({"duration": 5001}, "at most 5000 ms together, got 5001"),
        ({"startDelay": 4999}, "at most 5000 ms together"),
        ({"startDelay": -1}, "startDelay must be at least 0, got -1: clamped"),
        ({"strongMagnitude": 1.1}, "strongMagnitude must be 0 to 1, got 1.1: clamped"),
        ({"weakMagnitude": True}, "weakMagnitude: must be a number, got True"),
        ({"duration": 0}, "longer than 0 ms"),
    ],
)
def test_gamepad_rules(changes, problem):
    effect = {"startDelay": 0, "duration": 100, "strongMagnitude": 0.5, "weakMagnitude": 0.5}
    document = {"type": "dual-rumble", "effects": [effect]}
    assert problems(gamepad, document) == []
    bad = {"type": "dual-rumble", "effects": [effect | changes]}
    assert any(problem in line for line in problems(gamepad, bad)), problems(gamepad, bad)
    assert problems(gamepad, {"type": "trigger-rumble", "effects": [effect]})


def again(folder, document, format):
    """Return the document of a file's conversion to a format, and what is said about it."""
    (folder / "one.json").write_text(json.dumps(document))
    found = write_haptic(folder / "two.json", read_haptic(folder / "one.json"), format=format)
    return json.loads((folder / "two.json").read_text()), found


PAD = {"startDelay": 0, "strongMagnitude": 1.0, "weakMagnitude": 1.0}


@pytest.mark.parametrize("ms", [500, 60, 20])
def test_a_gamepad_effect_is_itself_on_a_gamepad(ms, tmp_path):
    effects = [PAD | {"duration": ms}]
    document, found = again(tmp_path, {"type": "dual-rumble", "effects": effects}, "gamepad")
    assert document["effects"] == effects
    assert found["told"][0].endswith("loses nothing.")
    assert found["full_scale"] == 1.0


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


@pytest.mark.parametrize(
    "wrap", [lambda one: one, lambda one: [one, one], lambda one: {"effects": [one, one]}]
)
def test_effects_as_play_effect_takes_them_are_read(wrap, tmp_path):
    (tmp_path / "x.json").write_text(json.dumps(wrap(PAD | {"duration": 100})))
    file = read_haptic(tmp_path / "x.json")
    assert file.facts["format"] == "gamepad"
    assert file.events.seconds == pytest.approx(0.1 if wrap(1) == 1 else 0.2)


def test_a_single_number_is_a_pattern(tmp_path):
    (tmp_path / "x.json").write_text("200")
    assert read_haptic(tmp_path / "x.json").facts["format"] == "vibration"
    assert read_haptic(tmp_path / "x.json").events.seconds == pytest.approx(0.2)
