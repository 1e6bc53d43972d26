import copy
from itertools import pairwise

import numpy as np
import pytest

from tactogram.errors import ParameterError
from tactogram.rendering.files.documents import DocumentHeader
from tactogram.rendering.files.envelope import Envelope, Pulse, envelope_of
from tactogram.rendering.files.formats import ahap
from tactogram.signal import Signal

RATE = 8000


def event(time=0.0, kind="HapticContinuous", duration=1.0, **parameters):
    parameters = parameters or {"HapticIntensity": 1.0, "HapticSharpness": 0.5}
    entry = {
        "Time": time,
        "EventType": kind,
        "EventParameters": [
            {"ParameterID": name, "ParameterValue": value} for name, value in parameters.items()
        ],
    }
    return {"Event": entry | ({"EventDuration": duration} if kind == "HapticContinuous" else {})}


def curve(name, *points, time=0.0):
    return {
        "ParameterCurve": {
            "ParameterID": name,
            "Time": time,
            "ParameterCurveControlPoints": [{"Time": t, "ParameterValue": v} for t, v in points],
        }
    }


def pattern(*entries):
    return {"Version": 1.0, "Pattern": list(entries)}


def noise(seconds, seed=0):
    rng = np.random.default_rng(seed)
    x = rng.normal(size=round(seconds * 2000))
    return Signal(x / (4 * np.abs(x).max()), 2000, "1")


def played(*entries):
    return envelope_of(ahap.decode(pattern(*entries), RATE).signal, pulses=False)


def test_limits_of_points_and_durations_are_kept():
    document = ahap.encode(noise(65), DocumentHeader())
    assert ahap.validate(document) == []
    events = [e["Event"] for e in document["Pattern"] if "Event" in e]
    durations = [e["EventDuration"] for e in events if e["EventType"] == "HapticContinuous"]
    curves = [e["ParameterCurve"] for e in document["Pattern"] if "ParameterCurve" in e]
    assert durations == [30, 30, 5]
    assert len(curves) > 10
    assert max(len(c["ParameterCurveControlPoints"]) for c in curves) == 16


def test_each_curve_begins_where_the_one_before_ended():
    document = ahap.encode(noise(3), DocumentHeader())
    curves = [
        e["ParameterCurve"]
        for e in document["Pattern"]
        if e.get("ParameterCurve", {}).get("ParameterID") == "HapticIntensityControl"
    ]
    for one, other in pairwise(curves):
        last, first = one["ParameterCurveControlPoints"][-1], other["ParameterCurveControlPoints"][0]
        assert one["Time"] + last["Time"] == pytest.approx(other["Time"], abs=2e-6)
        assert last["ParameterValue"] == first["ParameterValue"]


def test_intensity_is_the_root_of_the_amplitude():
    found = played(event(HapticIntensity=0.5, HapticSharpness=0.0))
    inside = (found.times > 0.1) & (found.times < 0.9)
    np.testing.assert_allclose(found.amplitude[inside], 0.25, rtol=0.01)
    np.testing.assert_allclose(found.frequency[inside], 65, atol=1)


def test_curves_multiply_intensity_and_add_sharpness():
    found = played(
        event(HapticIntensity=0.8, HapticSharpness=0.25),
        curve("HapticIntensityControl", (0, 0.5), (1, 0.5)),
        curve("HapticSharpnessControl", (0, 0.5), (1, 0.5)),
    )
    inside = (found.times > 0.1) & (found.times < 0.9)
    np.testing.assert_allclose(found.amplitude[inside], 0.16, rtol=0.02)
    np.testing.assert_allclose(found.frequency[inside], 65 + 0.75 * 235, atol=2)


def test_a_dynamic_parameter_holds_from_its_time_on():
    step = {"Parameter": {"ParameterID": "HapticIntensityControl", "Time": 0.5, "ParameterValue": 0.5}}
    found = played(event(), step)
    assert np.interp([0.3, 0.8], found.times, found.amplitude) == pytest.approx([1, 0.25], rel=0.02)


def test_a_later_curve_takes_over_from_an_earlier_one():
    found = played(
        event(),
        curve("HapticIntensityControl", (0, 1), (1, 1)),
        curve("HapticIntensityControl", (0, 0.5), (0.5, 0.5), time=0.5),
    )
    assert np.interp([0.3, 0.8], found.times, found.amplitude) == pytest.approx([1, 0.25], rel=0.02)


def test_a_transient_is_short():
    found = ahap.decode(pattern(event(0.1, "HapticTransient"), event(0.5, "HapticTransient")), RATE).signal
    x = np.abs(found.samples[0])
    assert x[: RATE // 10 - 1].max() == 0
    assert x[RATE // 10 : RATE // 10 + 160].max() > 0.5
    assert x[RATE // 10 + 161 : RATE // 2 - 1].max() == 0


def test_an_onset_becomes_a_transient():
    t = np.arange(RATE) / RATE
    x = np.where(np.abs(t - 0.5) < 0.003, np.sin(2 * np.pi * 250 * t), 0.02 * np.sin(2 * np.pi * 90 * t))
    document = ahap.encode(Signal(0.9 * x, RATE, "1"), DocumentHeader())
    times = [
        e["Event"]["Time"]
        for e in document["Pattern"]
        if e.get("Event", {}).get("EventType") == "HapticTransient"
    ]
    assert any(abs(time - 0.5) < 0.005 for time in times)


def test_two_events_make_one_vibration_without_a_seam():
    document = ahap.encode(
        Signal(0.5 * np.sin(2 * np.pi * 150 * np.arange(31 * 1000) / 1000), 1000, "1"), DocumentHeader()
    )
    x = ahap.decode(document, RATE).signal.samples[0]
    seam = x[30 * RATE - 200 : 30 * RATE + 200]
    assert np.abs(np.diff(seam)).max() < 1.1 * 0.5 * 2 * np.pi * 150 / RATE


BAD = {
    "Pattern: is required": lambda d: d.pop("Pattern"),
    "at least 1 item": lambda d: d.update(Pattern=[]),
    "EventType": lambda d: d["Pattern"][0]["Event"].update(EventType="Nope"),
    "EventDuration must be at most 30 s, got 31": lambda d: d["Pattern"][0]["Event"].update(
        EventDuration=31.0
    ),
    "needs an EventDuration": lambda d: d["Pattern"][0]["Event"].pop("EventDuration"),
    "greater than 0": lambda d: d["Pattern"][0]["Event"].update(EventDuration=0),
    "greater than or equal to 0": lambda d: d["Pattern"][0]["Event"].update(Time=-1),
    "HapticIntensity must be 0 to 1, got 1.5": lambda d: d["Pattern"][0]["Event"]["EventParameters"][
        0
    ].update(ParameterValue=1.5),
    "at most 16 items": lambda d: d["Pattern"][1]["ParameterCurve"].update(
        ParameterCurveControlPoints=[{"Time": i / 16, "ParameterValue": 0} for i in range(17)]
    ),
    "in order of time": lambda d: d["Pattern"][1]["ParameterCurve"]["ParameterCurveControlPoints"].reverse(),
    "HapticIntensityControl must be 0 to 1, got -0.5": lambda d: d["Pattern"][1]["ParameterCurve"][
        "ParameterCurveControlPoints"
    ][0].update(ParameterValue=-0.5),
    "ParameterID of a curve": lambda d: d["Pattern"][1]["ParameterCurve"].update(ParameterID="Loudness"),
    "one of Event, ParameterCurve and Parameter": lambda d: d["Pattern"].append({}),
    "valid number": lambda d: d["Pattern"][0]["Event"].update(Time="0"),
}


@pytest.mark.parametrize("problem", BAD)
def test_each_rule_is_checked(problem):
    good = pattern(event(), curve("HapticIntensityControl", (0, 0.2), (1, 1)))
    assert ahap.validate(good) == []
    bad = copy.deepcopy(good)
    BAD[problem](bad)
    assert any(problem in line for line in ahap.validate(bad)), ahap.validate(bad)


def test_unknown_keys_and_audio_are_left_alone():
    audio = {"Event": {"Time": 0.0, "EventType": "AudioContinuous", "EventDuration": 1.0}}
    document = pattern(event(), audio) | {"Colour": "red"}
    assert ahap.validate(document) == []
    assert ahap.decode(document, RATE).facts["left_out"] == "1 audio events"
    faded = pattern(event(), curve("AudioVolumeControl", (0, 1), (1, 0)))
    assert ahap.validate(faded) == []
    assert ahap.decode(faded, RATE).facts["left_out"] == "AudioVolumeControl"
    with pytest.raises(ParameterError, match="no haptic event"):
        ahap.decode(pattern(audio), RATE)


def test_too_short_a_signal_is_refused():
    with pytest.raises(ParameterError, match="at least 1e-05 s"):
        ahap.encode(Signal(np.ones(1), 1e6, "1"), DocumentHeader())


def drawn(seconds, points, *pulses):
    times, amplitude = np.array(points, dtype=float).T
    return Envelope(seconds, times, amplitude, np.array([0.0]), np.array([170.0]), pulses)


def test_a_drawn_double_tap_is_two_transients_and_nothing_else():
    taps = (Pulse(0.0, 0.81, 253.0), Pulse(0.12, 0.25, 253.0))
    document = ahap.encode_envelope(drawn(0.14, [(0, 0), (0.14, 0)], *taps), DocumentHeader())
    assert ahap.validate(document) == []
    events = [entry["Event"] for entry in document["Pattern"]]
    values = [[p["ParameterValue"] for p in event["EventParameters"]] for event in events]
    assert [event["EventType"] for event in events] == ["HapticTransient"] * 2
    assert [event["Time"] for event in events] == [0.0, 0.12]
    assert values == [[0.9, 0.8], [0.5, 0.8]]  # intensity is the root of the amplitude


def test_a_drawn_transient_is_stronger_and_duller_than_the_buzz_it_is_on():
    buzz = [(0.0, 0.0), (0.1, 0.0), (0.101, 0.25), (0.499, 0.25), (0.5, 0.0)]
    taps = (Pulse(0.02, 0.64, 253.0), Pulse(0.3, 0.81, 100.0))
    document = ahap.encode_envelope(drawn(0.5, buzz, *taps), DocumentHeader())
    assert ahap.validate(document) == []
    read = ahap.decode(document, RATE).envelope
    for wanted, got in zip(taps, read.pulses, strict=True):
        assert (got.time, got.amplitude) == (wanted.time, pytest.approx(wanted.amplitude, abs=1e-3))
        assert got.frequency == pytest.approx(wanted.frequency, abs=0.1)
    t = [0.05, 0.2, 0.31, 0.4]  # the buzz is as strong within the second transient as around it
    assert np.interp(t, read.times, read.amplitude) == pytest.approx([0, 0.25, 0.25, 0.25], abs=1e-3)
    assert np.interp(t[1:], read.frequency_times, read.frequency) == pytest.approx([170] * 3, abs=0.1)
