"""Rumble of gamepads."""

import json

import numpy as np
import pytest
from tests.rendering.files.documents import RATE, again, bursts, level, problems, written_by

from tactogram.rendering.files import read_haptic
from tactogram.rendering.files.formats import gamepad
from tactogram.signal import Signal


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


PAD = {"startDelay": 0, "strongMagnitude": 1.0, "weakMagnitude": 1.0}


@pytest.mark.parametrize("ms", [500, 60, 20])
def test_a_gamepad_effect_is_itself_on_a_gamepad(ms, tmp_path):
    effects = [PAD | {"duration": ms}]
    document, found = again(tmp_path, {"type": "dual-rumble", "effects": effects}, "gamepad")
    assert document["effects"] == effects
    assert found["told"][0].endswith("loses nothing.")
    assert found["full_scale"] == 1.0


@pytest.mark.parametrize(
    "wrap", [lambda one: one, lambda one: [one, one], lambda one: {"effects": [one, one]}]
)
def test_effects_as_play_effect_takes_them_are_read(wrap, tmp_path):
    (tmp_path / "x.json").write_text(json.dumps(wrap(PAD | {"duration": 100})))
    file = read_haptic(tmp_path / "x.json")
    assert file.facts["format"] == "gamepad"
    assert file.events.seconds == pytest.approx(0.1 if wrap(1) == 1 else 0.2)
