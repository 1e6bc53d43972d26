import numpy as np
import pytest
from tests.rendering.files.documents import problems, read, written_by

from tactogram.errors import DataError
from tactogram.rendering.files import check_file, read_haptic
from tactogram.rendering.files.analysis import envelope_of, events_of
from tactogram.rendering.files.documents import encoded
from tactogram.rendering.files.formats import haps
from tactogram.signal import Signal

RATE = 4000


def sweep(seconds=2.0, low=60, high=400, strength=1.0):
    """Return a tone that rises and falls in strength, and rises in frequency."""
    t = np.arange(round(seconds * RATE)) / RATE
    phase = 2 * np.pi * (low * t + (high - low) * t**2 / (2 * seconds))
    return Signal(strength * np.sin(np.pi * t / seconds) * np.sin(phase), RATE, "1")


def written(signal):
    document = written_by(haps, signal)
    assert problems(haps, document) == []
    transients, effects = (m["m_notes"] for m in document["m_vibration"]["m_melodies"])
    return document, transients, effects[0]


def line(note, name):
    keyframes = note["m_hapticEffect"][name]["m_keyframes"]
    return np.array([(keyframe["m_time"], keyframe["m_value"]) for keyframe in keyframes]).T


def modulation(*keyframes):
    return {"m_extrapolationStrategy": 0, "m_keyframes": [{"m_time": t, "m_value": v} for t, v in keyframes]}


def note(start, seconds, gain=1.0, amplitude=(), frequency=()):
    effect = {"m_type": 0}
    if amplitude:
        effect = {
            "m_amplitudeModulation": modulation(*amplitude),
            "m_frequencyModulation": modulation(*frequency),
        }
    return {"m_startingPoint": start, "m_length": seconds, "m_gain": gain, "m_hapticEffect": effect}


def document(*melodies, **others):
    """Return a file with as few members as the vendor's oldest effects have."""
    return {"m_version": "5", "m_vibration": {"m_melodies": [{"m_notes": m} for m in melodies]}} | others


def envelope(content, rate=8000):
    return envelope_of(read(haps, content).signal)


def test_the_strength_is_kept_within_its_step_and_the_frequency_in_hz():
    _, transients, effect = written(sweep())
    source = events_of(sweep()).joined
    assert transients == []
    amplitude = np.interp(source.times, *line(effect, "m_amplitudeModulation"))
    assert amplitude == pytest.approx(source.amplitude, abs=haps.AMPLITUDE_STEP + 1e-4)
    hz = np.interp([0.5, 1, 1.5], *line(effect, "m_frequencyModulation"))
    assert hz == pytest.approx([145, 230, 315], abs=3)
    assert (effect["m_startingPoint"], effect["m_length"], effect["m_gain"]) == (0, 2, 1)


def test_a_peak_at_full_scale_is_1():
    _, _, effect = written(sweep())
    assert line(effect, "m_amplitudeModulation")[1].max() == pytest.approx(1, abs=0.01)


def test_what_is_written_is_read_back():
    content, _, _ = written(sweep(strength=0.7))
    decoded = read(haps, content)
    assert decoded.signal.seconds == pytest.approx(2)
    assert decoded.facts["carrier_from"] == "m_frequencyModulation"
    found = envelope(content)
    assert np.interp(1, found.times, found.amplitude) == pytest.approx(0.7, abs=0.01)
    assert np.interp([0.5, 1.5], found.times, found.frequency) == pytest.approx([145, 315], abs=4)


def test_a_click_becomes_a_transient_with_its_whole_strength():
    t = np.arange(RATE) / RATE
    click = 0.7 * np.exp(-(((t - 0.5) / 0.003) ** 2))
    _, transients, effect = written(Signal((0.2 + click) * np.sin(2 * np.pi * 150 * t), RATE, "1"))
    assert len(transients) == 1
    assert transients[0]["m_startingPoint"] == pytest.approx(0.5, abs=0.005)
    assert (transients[0]["m_length"], transients[0]["m_hapticEffect"]) == (0.022, {"m_type": 0})
    under = np.interp(transients[0]["m_startingPoint"], *line(effect, "m_amplitudeModulation"))
    assert under < 0.5 < transients[0]["m_gain"] <= 1


def test_notes_are_placed_relative_to_their_start_and_gains_are_multiplied():
    first = note(0, 0.5, amplitude=[(0, 0.8), (9, 0.8)], frequency=[(0, 100), (9, 100)])
    second = note(1.0, 0.5, gain=0.5, amplitude=[(0, 0.8)], frequency=[(0, 200)])
    content = document([], [first, second], m_gain=0.5)
    assert problems(haps, content) == []
    found = envelope(content)
    assert found.end == pytest.approx(1.5)
    assert np.interp([0.25, 0.75, 1.25], found.times, found.amplitude) == pytest.approx(
        [0.4, 0, 0.2], abs=0.01
    )
    assert np.interp([0.25, 1.25], found.times, found.frequency) == pytest.approx([100, 200], abs=3)


def test_keyframes_out_of_order_and_beyond_the_note_are_read():
    amplitude = [(0, 0.0), (3.0, 0.0), (1.0, 1.0)]
    found = envelope(document([note(0, 2.0, amplitude=amplitude, frequency=[(0, 150)])]))
    assert found.end == pytest.approx(2)
    assert np.interp([0.5, 1.0, 1.5], found.times, found.amplitude) == pytest.approx([0.5, 1, 0.75], abs=0.02)


def test_a_transient_is_as_strong_as_its_gain():
    steady = note(0, 1.0, amplitude=[(0, 0.4)], frequency=[(0, 100)])
    doubled = [note(0.5, 0.022, gain=0.9), note(0.5, 0.022, gain=0.9), note(0.8, 0.022, gain=0.3)]
    x = read(haps, document(doubled, [steady])).signal.samples[0]
    assert np.abs(x[:3900]).max() == pytest.approx(0.4, abs=0.01)
    assert np.abs(x[4000:4200]).max() == pytest.approx(0.8, abs=0.11)
    assert np.abs(x[6300:]).max() == pytest.approx(0.4, abs=0.01)


def test_a_file_of_transients_lasts_as_long_as_they_do():
    decoded = read(haps, document([note(0.1, 0.022, gain=1.109), note(0.4, 0.022, gain=0.5)]))
    assert decoded.signal.seconds == pytest.approx(0.42, abs=1e-3)
    assert decoded.facts["carrier_from"] == "nothing in the file: transients have none"


def test_what_is_not_read_is_named():
    one = [note(0, 1.0, amplitude=[(0, 0.5)], frequency=[(0, 100)])]
    content = document(
        one, one, m_stiffness={"m_melodies": [{"m_notes": [{}]}]}, m_texture={"m_melodies": []}
    )
    assert read(haps, content).facts["left_out"] == "stiffness"
    assert read(haps, content).events.joined.at(0.5) == pytest.approx(0.5**0.5)
    muted = document([], one)
    muted["m_vibration"]["m_melodies"][1]["m_mute"] = 1
    with pytest.raises(DataError, match="holds no vibration"):
        read(haps, muted)


@pytest.mark.parametrize(
    ("content", "problem"),
    [
        ({"version": "6", "vibration": {}}, "version must be 5 (m_version), got '6'; export it as version 5"),
        (document() | {"m_version": "4"}, "version must be 5 (m_version), got '4'"),
        ({"m_version": "5"}, "m_vibration: is required"),
        (document([{"m_length": 1.0, "m_gain": 1, "m_hapticEffect": {}}]), "0.m_startingPoint: is required"),
        ([], "version must be 5"),
    ],
)
def test_what_no_player_accepts_is_refused_in_a_line(content, problem, tmp_path):
    path = tmp_path / "x.haps"
    path.write_bytes(encoded(content))
    assert problem in check_file(path)["problems"][0]
    with pytest.raises(DataError, match=r"x\.haps: not valid Interhaptics effect v5: "):
        read_haptic(path)


@pytest.mark.parametrize(
    ("notes", "problem"),
    [
        ([note(-1, 1)], "m_startingPoint must be at least 0, got -1: clamped"),
        ([note(0, 1, gain="1")], "m_gain must be a number, got '1': read as one"),
        ([note(0, 1, amplitude=[(0, -0.5)])], "m_value must be at least 0, got -0.5: clamped"),
        (
            [
                note(0, 1, amplitude=[(0, 0.5)], frequency=[(0, hz)]) | {"m_startingPoint": hz / 200}
                for hz in (0, 100)
            ],
            "notes of a melody must not overlap, got 1 s and 0.5 s: one ends where the next begins",
        ),
    ],
)
def test_what_players_forgive_is_read_and_said(notes, problem):
    assert problems(haps, document(notes)) == [problem]
    assert read(haps, document(notes)).warnings == (problem,)
