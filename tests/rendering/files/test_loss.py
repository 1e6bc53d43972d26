"""What a file keeps of a signal, in words."""

import json

import numpy as np
import pytest

from tactogram.rendering.files import ConversionLoss, loss_sentence, write_haptic
from tactogram.rendering.files.events import Events, Part, Transient, joined
from tactogram.rendering.files.loss import EventCounts, compared, verdict
from tactogram.signal import Signal

TIME = np.arange(4000) / 2000
SWELL = Signal((0.5 + 0.5 * np.sin(2 * np.pi * TIME)) * np.sin(2 * np.pi * 150 * TIME), 2000, "1")


NOISE = np.random.default_rng(0).standard_normal(8000)
TEXTURE = Signal(NOISE / 4, 2000, "m/s^2")
"""Four seconds of noise, whose strength fluctuates and never pauses."""


def told(signal, name, folder):
    return write_haptic(folder / name, signal, format=name)["told"][0]


def judged(signal, name, folder):
    return write_haptic(folder / name, signal, format=name)["verdict"]


@pytest.mark.parametrize(
    ("name", "text"),
    [
        ("hjif", "keeps the waveform"),
        ("haptic", "keeps the strength over time, the level and the frequency; loses the waveform"),
        ("android", "keeps the strength over time, the level and the frequency; loses the waveform"),
    ],
)
def test_each_kind_of_format_keeps_what_it_holds(name, text, tmp_path):
    assert told(SWELL, name, tmp_path) == f"The file {text}."


def test_a_texture_as_a_pattern_is_one_buzz(tmp_path):
    assert judged(TEXTURE, "vibration", tmp_path).startswith(
        "one buzz: use the phone's envelope (android_envelope"
    )
    assert json.loads((tmp_path / "vibration").read_text())["pattern"] == [4000]


def test_the_buzzes_of_a_pattern_are_counted(tmp_path):
    bursts = SWELL.with_samples((TIME % 0.5 < 0.25) * np.sin(2 * np.pi * 150 * TIME))
    assert judged(bursts, "vibration", tmp_path).startswith("4 buzzes of one strength: use ")
    assert len(json.loads((tmp_path / "vibration").read_text())["pattern"]) == 7


@pytest.mark.parametrize(
    ("hz", "name", "text"),
    [
        (150, "hjif", "the signal itself"),
        (150, "haptic", "one tone of the signal's strength and frequency: enough for an effect"),
        (30, "haptic", "the strength, at the wrong frequency: use a format of waveforms"),
        (150, "gamepad", "one tone of the signal"),
    ],
)
def test_a_verdict_follows_the_loss(hz, name, text, tmp_path):
    swell = SWELL.with_samples(np.sin(np.pi * TIME) ** 2 * np.sin(2 * np.pi * hz * TIME))
    assert judged(swell, name, tmp_path).startswith(text)


def test_a_motor_is_too_coarse_for_fast_bursts(tmp_path):
    fast = SWELL.with_samples((TIME % 0.07 < 0.03) * np.sin(2 * np.pi * 150 * TIME))
    assert judged(fast, "gamepad", tmp_path).startswith("a vibration too coarse for the changes")


def test_a_waveform_is_judged_by_its_worst_axis(tmp_path):
    tone = np.sin(2 * np.pi * 100 * np.arange(8000) / 48_000)
    both = Signal(np.stack([tone, NOISE / 4]), 48_000, "1", ("slow", "fast"))  # HJIF holds up to 4 kHz
    assert judged(both.select("slow"), "hjif", tmp_path) == "the signal itself"
    assert judged(both, "hjif", tmp_path) == "the signal, roughly: use .wav instead"


def test_a_frequency_that_is_off_is_told(tmp_path):
    low = SWELL.with_samples((0.5 + 0.5 * np.sin(2 * np.pi * TIME)) * np.sin(2 * np.pi * 40 * TIME))
    assert "loses the waveform and the frequency (2.1 octaves off)" in told(low, "android", tmp_path)


@pytest.mark.parametrize(
    ("loss", "kept", "lost"),
    [
        (
            (0.7, 1.0, 5.0, 0.1, 0.0, -3.0),
            "roughly the strength over time and the frequency",
            "the waveform and the level (+5 dB)",
        ),
        ((None, 0.1, 0.0, None, None, None), "the strength over time and the level", "the waveform"),
        (
            (None, 0.9, -9.0, 2.0, None, None),
            "little",
            "the waveform, the changes of strength, the level (-9 dB) and the frequency (2.0 octaves off)",
        ),
    ],
)
def test_what_is_kept_stands_before_what_is_lost(loss, kept, lost):
    assert loss_sentence(ConversionLoss(*loss), "envelope") == f"keeps {kept}; loses {lost}"


def test_an_error_of_the_waveform_is_told():
    assert loss_sentence(ConversionLoss(1.0, 0.0, 0.0, 0.0, 1.0, 41.2), "waveform") == (
        "keeps the waveform with an error of -41 dB"
    )


def taps(step, count):
    return Events.of([], [Transient(i * step, 0.5, 170.0) for i in range(count)])


@pytest.mark.parametrize(
    ("events", "name", "word"),
    [
        (taps(0.005, 10), "android", "not all events: 7 of 10 transients missing"),
        (taps(0.1, 300), "vibration", "one buzz: use android (before Android 16) instead"),
        (taps(0.1, 8), "android", "the events themselves"),
    ],
)
def test_a_remedy_is_named_only_if_it_keeps_more(events, name, word, tmp_path):
    found = write_haptic(tmp_path / "x", events, format=name)
    assert found["verdict"] == word


@pytest.mark.parametrize(("level", "error"), [(0.0, 0.45), (-6.0, 0.6), (6.0, 1.3)])
def test_the_verdict_of_events_follows_the_sentence(level, error):
    loss, counts = ConversionLoss(0.95, error, level, 0.0, None, None), EventCounts(vibrations=1)
    assert "some changes of strength" in loss_sentence(loss, "envelope", counts)
    assert verdict(loss, "envelope", "x", counts=counts).endswith(
        "too coarse for the changes of strength: use x instead"
    )
    weaker = ConversionLoss(None, 0.5, -6.0, 0.0, None, None)
    assert loss_sentence(weaker, "envelope", counts).endswith("loses the level (-6 dB)")
    assert verdict(weaker, "envelope", "", counts=counts) == "the events without the level (-6 dB)"


def test_overlapping_vibrations_are_compared_one_by_one():
    tones = [Part.of([0, 1], [0.5, 0.5], 0.0, hz) for hz in (60.0, 240.0)]
    both, one = Events.of(tones, []), Events.of([joined(tones)], [])
    assert compared(both, both, 0.002)[0].frequency_octaves == 0
    assert compared(both, one, 0.002)[0].frequency_octaves == pytest.approx(1.0, abs=0.01)


def test_the_last_digit_of_a_time_is_no_loss():
    part = Part.of([0, 1], [0.1, 0.1], 0.0, 170.0)
    one, other = (Events.of([part], [Transient(time, 0.8, 170.0)]) for time in (0.1 + 0.07, 0.17))
    assert compared(one, other, 0.002)[0].envelope_error == pytest.approx(0, abs=1e-6)
