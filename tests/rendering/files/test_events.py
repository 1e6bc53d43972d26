"""Events from one format to another, and files that others designed."""

import json
from pathlib import Path

import numpy as np
import pytest
from hypothesis import HealthCheck, given, note, settings, strategies as st

from tactogram.rendering.files import haptic_formats, read_haptic, write_haptic
from tactogram.rendering.files.analysis import envelope_of
from tactogram.rendering.files.events import Events, Part, Transient
from tactogram.signal import Signal

CASES = Path(__file__).parent / "cases"
FORMATS = haptic_formats()
STRONG = {"haptic"}
"""Formats whose transients are no weaker than the vibration."""


def converted(folder, source, target):
    """Return the events of a file, those read back from another format, and what is said about it."""
    file = read_haptic(source)
    path = folder / f"out-{target}{FORMATS[target].suffix}"
    found = write_haptic(path, file, format=target)
    return file.events, read_haptic(path, format=target).events, found


@pytest.mark.parametrize(
    "target", ["ahap", "haptic", "haps", "android", "hjif", "tact", "gamepad", "android_basic"]
)
def test_taps_remain_taps(target, tmp_path):
    _, back, found = converted(tmp_path, CASES / "ahap_taps_to_haptic-taps.ahap", target)
    assert [round(tap.time, 3) for tap in back.transients] == [0, 0.4, 0.8, 1.2]
    assert [tap.amplitude for tap in back.transients] == pytest.approx([0.64, 0.16] * 2, abs=0.005)
    assert back.parts == ()
    assert found["told"][0].startswith("The file keeps 4 of 4 transients; loses ")


@pytest.mark.parametrize("format", ["ahap", "haps", "hjif"])
def test_events_have_their_length_and_frequency_as_a_signal(format, tmp_path):
    path = tmp_path / f"x{FORMATS[format].suffix}"
    write_haptic(path, Events.of([Part.of([0, 1], [0.5, 0.5], 0.0, 100.0)], [], 1.0), format=format)
    signal = read_haptic(path).signal
    found = envelope_of(signal)
    assert signal.seconds == pytest.approx(1.0, abs=1e-3)
    assert np.interp(0.5, found.times, found.frequency) == pytest.approx(100, abs=2)


@pytest.mark.parametrize(("name", "count", "strength"), [("rattle", 13, 0.35), ("four", 4, 0.6)])
def test_emphases_become_transients_over_the_vibration(name, count, strength, tmp_path):
    _, _, found = converted(tmp_path, CASES / f"haptic_emphases_to_ahap-{name}.haptic", "ahap")
    events = [entry["Event"] for entry in json.loads((tmp_path / "out-ahap.ahap").read_text())["Pattern"]]
    intensity = [event["EventParameters"][0]["ParameterValue"] for event in events]
    kinds = [event["EventType"] for event in events]
    assert kinds == ["HapticContinuous"] + ["HapticTransient"] * count
    assert intensity == pytest.approx([0.2**0.5] + [strength**0.5] * count, abs=1e-4)
    assert found["events"]["kept"] == count
    assert found["verdict"] == "the events themselves"


def test_a_curve_of_20_points_is_read_and_written_in_shorter_ones(tmp_path):
    source, back, _ = converted(tmp_path, CASES / "ahap_curve_20_points-curve.ahap", "ahap")
    t = np.arange(0, 1.9, 0.05)
    assert source.joined.at(t[::2]) == pytest.approx([0.04, 0.64] * 9 + [0.04], abs=1e-3)
    assert back.joined.at(t) == pytest.approx(source.joined.at(t), abs=0.02)
    curves = json.loads((tmp_path / "out-ahap.ahap").read_text())["Pattern"]
    lengths = [
        len(one["ParameterCurve"]["ParameterCurveControlPoints"]) for one in curves if "ParameterCurve" in one
    ]
    assert max(lengths) <= 16


def test_a_sound_above_1_khz_is_not_praised(tmp_path):
    t = np.arange(16_000) / 16_000
    high = Signal(0.8 * np.sin(2 * np.pi * 3000 * t) + 0.01 * np.sin(2 * np.pi * 200 * t), 16_000, "1")
    found = write_haptic(tmp_path / "x.ahap", high, format="ahap")
    assert found["told"] == [
        "Only 0 % of the signal's power is up to 1000 Hz; the rest is above 1000 Hz, which a finger does not feel "
        "and the file leaves out."
    ]
    assert "map the sound to touch instead (--map envelope)" in found["verdict"]
    pattern = write_haptic(tmp_path / "x.json", high, format="vibration")
    said = " ".join(pattern["told"])
    assert "leaves out" not in said
    assert f"the level (+{pattern['loss']['level_db']:.0f} dB)" in said


def ramp(start, end, levels, hz):
    return Part.of([start, end], levels, [start, end], np.broadcast_to(hz, 2))


OVERLAPS = {
    "steady": [ramp(0, 1, [0.4, 0.4], 80), ramp(0.2, 0.6, [0.5, 0.5], 200)],
    "fading together": [ramp(0, 1, [0.5, 0.0], 80), ramp(0, 1, [0.25, 0.0], 200)],
    "crossing": [ramp(0, 1, [0.6, 0.1], 80), ramp(0.3, 1, [0.1, 0.5], [100, 250])],
    "beside one with an attack": [
        *[ramp(0, 1, [0.3, 0.3], hz) for hz in (80, 200)],
        ramp(1.2, 2, [0, 0.5], 90),
    ],
}


@pytest.mark.parametrize("target", ["ahap", "haps", "hjif"])
@pytest.mark.parametrize("name", OVERLAPS)
def test_vibrations_that_overlap_keep_their_own_frequencies(name, target, tmp_path):
    path = tmp_path / f"x{FORMATS[target].suffix}"
    source = Events.of(OVERLAPS[name], [], 2.0)
    write_haptic(path, source, format=target)
    back = read_haptic(path).events
    for time in (0.1, 0.35, 0.55, 0.9, 1.6):
        wanted, got = (
            np.array(sorted((float(p.hz(time)), float(p.at(time))) for p in one.parts if p.at(time) > 0.005))
            for one in (source, back)
        )
        assert len(got) == len(wanted)
        wanted, got = wanted.reshape(-1, 2), got.reshape(-1, 2)
        assert got[:, 0] == pytest.approx(wanted[:, 0], abs=6)
        assert got[:, 1] == pytest.approx(wanted[:, 1], abs=0.06)


def test_vibrations_that_exceed_full_scale_together_keep_their_frequencies():
    events = Events.of([ramp(0, 1, [1, 1], 65), ramp(0.5, 1.5, [1, 1], 300)], [])
    assert [part.frequency[0] for part in events.parts] == [65, 300]
    assert [float(part.at(0.7)) for part in events.parts] == pytest.approx([0.5**0.5] * 2, abs=1e-6)
    assert events.joined.at(np.array([0.2, 0.7, 1.2])) == pytest.approx([1, 1, 1])


def lines(path, name):
    points = json.loads(path.read_text())["controlPoints"]
    return list(
        zip(
            np.cumsum([point["durationMillis"] for point in points]).tolist(),
            [p[name] for p in points],
            strict=True,
        )
    )


@pytest.mark.parametrize(
    ("target", "name"), [("android_envelope", "amplitude"), ("android_basic", "intensity")]
)
def test_silence_stays_silent_in_an_envelope(target, name, tmp_path):
    buzz = ramp(0, 0.5, [0.6, 0.6], 150)
    path = tmp_path / "x.json"
    write_haptic(path, Events.of([buzz], [Transient(1.0, 1.0, 150.0)]), format=target)
    assert lines(path, name) == [(20, 0.6), (500, 0.6), (520, 0), (1000, 0), (1020, 1), (1040, 0)]
    write_haptic(path, Events.of([ramp(0.5, 1, [0.5, 0.5], 150)], [], 1.5), format=target)
    assert lines(path, name) == [(500, 0), (520, 0.5), (1000, 0.5), (1020, 0), (1500, 0)]


@pytest.mark.parametrize("target", ["android_envelope", "android_basic"])
def test_an_envelope_keeps_taps_on_a_vibration_and_the_strongest_of_many(target, tmp_path):
    path = tmp_path / "x.json"
    on_buzz = [Transient(0.3, 1.0, 150.0), Transient(0.6, 0.8, 150.0)]
    write_haptic(path, Events.of([ramp(0, 1, [0.25, 0.25], 150)], on_buzz), format=target)
    back = read_haptic(path, format=target).events
    assert [(tap.time, tap.amplitude) for tap in back.transients] == [(0.3, 1.0), (0.6, 0.8)]
    assert back.joined.at(np.array([0.1, 0.32, 0.62, 0.8])) == pytest.approx([0.25] * 4)
    many = [Transient(i * 0.055, 1.0 if i % 2 else 0.4, 150.0) for i in range(12)]
    write_haptic(path, Events.of([], many), format=target)
    back = read_haptic(path, format=target).events
    assert [tap.amplitude for tap in back.transients] == [1.0] * 5
    assert back.parts == ()


@st.composite
def designs(draw):
    """Return taps 100 ms apart or more, and a vibration that begins and ends."""
    times = draw(st.lists(st.integers(0, 19), unique=True, max_size=5))
    shares = st.integers(4, 20).map(lambda level: level / 20)
    taps = [
        Transient(time / 10, draw(shares), draw(st.sampled_from([80.0, 170.0]))) for time in sorted(times)
    ]
    levels = draw(st.lists(shares, min_size=2, max_size=4))
    start = draw(st.sampled_from([0.0, 0.55]))
    part = Part.of(np.linspace(start, 2.0, len(levels)), 0.3 * np.array(levels), 0.0, 170.0)
    return Events.of([part] if draw(st.booleans()) or not taps else [], taps, 2.1)


@pytest.mark.parametrize("source", FORMATS)
@settings(max_examples=6, deadline=None, suppress_health_check=[HealthCheck.function_scoped_fixture])
@given(events=designs())
def test_as_many_events_as_go_in_come_out_or_are_named(source, tmp_path, events):
    first = tmp_path / f"first{FORMATS[source].suffix}"
    write_haptic(first, events, format=source)
    file = read_haptic(first, format=source)
    for target in FORMATS:
        note(target)
        check_events_in(target, file, tmp_path / f"second{FORMATS[target].suffix}")


def check_events_in(target, file, second):
    found = write_haptic(second, file, format=target)
    back = read_haptic(second, format=target)
    counts, resolution = found["events"], max(0.002, FORMATS[target].resolution_s)
    times = [tap.time for tap in back.events.transients]
    near = [
        min((abs(time - tap.time) for time in times), default=1) <= resolution
        for tap in file.events.transients
    ]
    assert counts["transients"] == len(file.events.transients)
    assert counts["kept"] == sum(near)
    missing = counts["merged"] + counts["in_vibration"] + counts["lost"]
    assert counts["kept"] + missing == counts["transients"]
    assert (f"loses {missing} of" in found["told"][0]) or not missing or counts["lost"] < missing
    if target in ("ahap", "haptic", "haps", "hjif"):
        assert missing == counts["added"] == counts["vibrations_lost"] == 0
        t = np.arange(0, 2.1, 0.005)
        scale = found["full_scale"] / (file.facts["full_scale"] or 1.0)
        ours = scale * back.events.strength(t)
        assert np.abs(ours - file.events.strength(t)).mean() < 0.03
