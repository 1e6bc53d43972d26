import copy
from itertools import pairwise

import numpy as np
import pytest
from tests.rendering.files.documents import problems, read, written_by

from tactogram.errors import DataError, ParameterError
from tactogram.rendering.files.analysis import envelope_of
from tactogram.rendering.files.documents import DocumentHeader
from tactogram.rendering.files.events import Events, Part, Transient
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
    return envelope_of(read(ahap, pattern(*entries)).signal)


def test_limits_of_points_and_durations_are_kept():
    t = np.arange(65 * 500) / 500
    document = written_by(ahap, Signal((0.5 - 0.4 * np.cos(t * 2)) * np.sin(2 * np.pi * 100 * t), 500, "1"))
    assert problems(ahap, document) == []
    events = [e["Event"] for e in document["Pattern"] if "Event" in e]
    durations = [e["EventDuration"] for e in events if e["EventType"] == "HapticContinuous"]
    curves = [e["ParameterCurve"] for e in document["Pattern"] if "ParameterCurve" in e]
    assert durations == pytest.approx([30, 30, 5])
    assert len(curves) > 10
    assert max(len(c["ParameterCurveControlPoints"]) for c in curves) == 16


def test_each_curve_begins_where_the_one_before_ended():
    t = np.arange(3 * 500) / 500
    slow = Signal((0.5 - 0.4 * np.cos(t * 9)) * np.sin(2 * np.pi * 100 * t), 500, "1")
    document = written_by(ahap, slow)
    curves = [
        e["ParameterCurve"]
        for e in document["Pattern"]
        if e.get("ParameterCurve", {}).get("ParameterID") == "HapticIntensityControl"
    ]
    assert len(curves) > 2
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
    found = read(ahap, pattern(event(0.1, "HapticTransient"), event(0.5, "HapticTransient"))).signal
    x = np.abs(found.samples[0])
    assert x[: RATE // 10 - 1].max() == 0
    assert x[RATE // 10 : RATE // 10 + 160].max() > 0.5
    assert x[RATE // 10 + 161 : RATE // 2 - 1].max() == 0


def test_an_onset_becomes_a_transient():
    t = np.arange(RATE) / RATE
    x = np.where(np.abs(t - 0.5) < 0.003, np.sin(2 * np.pi * 250 * t), 0.02 * np.sin(2 * np.pi * 90 * t))
    document = written_by(ahap, Signal(0.9 * x, RATE, "1"))
    times = [
        e["Event"]["Time"]
        for e in document["Pattern"]
        if e.get("Event", {}).get("EventType") == "HapticTransient"
    ]
    assert any(abs(time - 0.5) < 0.005 for time in times)


def test_two_events_make_one_vibration_without_a_seam():
    document = written_by(
        ahap, Signal(0.5 * np.sin(2 * np.pi * 150 * np.arange(31 * 1000) / 1000), 1000, "1"), DocumentHeader()
    )
    x = read(ahap, document).signal.samples[0]
    seam = x[30 * RATE - 200 : 30 * RATE + 200]
    assert np.abs(np.diff(seam)).max() < 1.1 * 0.5 * 2 * np.pi * 150 / RATE


def first(document):
    return document["Pattern"][0]["Event"]


def points(document):
    return document["Pattern"][1]["ParameterCurve"]["ParameterCurveControlPoints"]


REFUSED = {
    "Pattern: is required": lambda d: d.pop("Pattern"),
    "holds no haptic event": lambda d: d.update(Pattern=[]),
    "EventDuration: is required": lambda d: first(d).pop("EventDuration"),
    "Pattern.0.Event.Time: must be a number, got True": lambda d: first(d).update(Time=True),
    "ParameterValue: is required": lambda d: points(d)[0].pop("ParameterValue"),
}
FORGIVEN = {
    "EventDuration must be 0 to 30, got 31: clamped": lambda d: first(d).update(EventDuration=31.0),
    "Time must be at least 0, got -1: clamped": lambda d: first(d).update(Time=-1),
    "Time must be a number, got '0': read as one": lambda d: first(d).update(Time="0"),
    "HapticIntensity must be 0 to 1, got 1.5": lambda d: first(d)["EventParameters"][0].update(
        ParameterValue=1.5
    ),
    "control points must be in order of time: sorted": lambda d: points(d).reverse(),
    "HapticIntensityControl must be 0 to 1, got -0.5": lambda d: points(d)[0].update(ParameterValue=-0.5),
    "events must be in order of time": lambda d: d["Pattern"].append(event(-0.5)),
}


@pytest.mark.parametrize("problem", [*REFUSED, *FORGIVEN])
def test_each_rule_is_checked_and_what_core_haptics_forgives_is_read(problem):
    good = pattern(event(0.5), curve("HapticIntensityControl", (0, 0.2), (1, 1)))
    assert problems(ahap, good) == []
    bad = copy.deepcopy(good)
    (REFUSED | FORGIVEN)[problem](bad)
    assert any(problem in line for line in problems(ahap, bad)), problems(ahap, bad)
    if problem in FORGIVEN:
        assert read(ahap, bad).events.parts
    else:
        with pytest.raises(DataError):
            read(ahap, bad)


def test_what_is_not_felt_or_not_known_is_named():
    audio = {"Event": {"Time": 0.0, "EventType": "AudioContinuous", "EventDuration": 1.0}}
    faded = curve("AudioVolumeControl", (0, 1), (1, 0))
    document = pattern(event(Loudness=1.0), audio, faded, {}) | {"Colour": "red"}
    assert problems(ahap, document) == []
    left_out = read(ahap, document).facts["left_out"]
    assert left_out == "1 Loudness, 1 AudioContinuous events, 1 AudioVolumeControl, 1 entries of nothing"
    assert problems(ahap, pattern(audio)) == ["Pattern: holds no haptic event"]


def test_an_event_that_is_not_sustained_dies_away_within_its_decay():
    found = read(ahap, pattern(event(HapticIntensity=1.0, DecayTime=0.3, Sustained=0.0))).events.joined
    assert found.at(np.array([0.0, 0.15, 0.31, 0.9])) == pytest.approx([1, 0.25, 0, 0], abs=0.01)


def test_the_decay_acts_only_on_what_is_not_sustained():
    sustained = read(ahap, pattern(event(duration=0.5, HapticIntensity=1.0, DecayTime=0.8)))
    assert (sustained.events.seconds, sustained.warnings) == (0.5, ())
    assert sustained.events.joined.at(np.array([0.1, 0.49])) == pytest.approx([1, 1])
    for switch in (False, 0):
        document = pattern(event(HapticIntensity=1.0, DecayTime=0.3, Sustained=switch))
        assert read(ahap, document).events.joined.at(0.15) == pytest.approx(0.25, abs=0.01)


@pytest.mark.parametrize("values", [{"AttackTime": 0.1}, {"ReleaseTime": 0.1}, {"Sustained": 0}])
def test_what_apple_does_not_state_is_named(values):
    [warning] = read(ahap, pattern(event(**values))).warnings
    assert warning.startswith(
        "Apple states no unit of AttackTime, DecayTime, ReleaseTime: read as s, a decay as 0.02"
    )


def test_what_core_haptics_ignores_does_not_stop_it():
    assert read(ahap, pattern(event()) | {"Metadata": {"Description": 5}}).metadata == {"comment": "5"}
    assert read(ahap, pattern(event()) | {"Metadata": []}).warnings == ()
    nameless = {"ParameterCurve": {"Time": 0.0, "ParameterCurveControlPoints": []}}
    assert problems(ahap, pattern(event(), nameless)) == [
        "a ParameterCurve must have a ParameterID: left out"
    ]


def test_one_fault_is_one_problem():
    without = event()
    del without["Event"]["EventDuration"]
    assert problems(ahap, pattern(without)) == ["Pattern.0.Event.EventDuration: is required"]
    assert problems(ahap, {"pattern": []}) == ["Pattern: is required"]
    [listed] = problems(ahap, pattern(event(), {"Parameter": [1]}))
    assert listed == "Pattern.1.Parameter: must be an object, got [1]"


def test_attack_and_release_are_ramps_of_the_intensity():
    found = read(ahap, pattern(event(HapticIntensity=1.0, AttackTime=0.2, ReleaseTime=0.4))).events
    assert found.seconds == pytest.approx(1.4)
    assert found.joined.at(np.array([0.1, 0.5, 1.2])) == pytest.approx([0.25, 1, 0.25], abs=0.01)


def test_events_that_overlap_play_together():
    found = read(ahap, pattern(event(HapticIntensity=0.8), event(0.4, duration=0.2, HapticIntensity=0.3)))
    level = found.events.joined.at(np.array([0.2, 0.5, 0.8]))
    assert level == pytest.approx([0.64, np.hypot(0.64, 0.09), 0.64])
    full = pattern(*[event(HapticIntensity=0.9)] * 3)
    assert read(ahap, full).events.joined.at(0.5) == 1


def test_curves_act_on_transients_and_hold_after_their_last_point():
    tap = event(0.8, "HapticTransient", HapticIntensity=0.8, HapticSharpness=0.2)
    [found] = read(ahap, pattern(tap, curve("HapticIntensityControl", (0, 1), (0.5, 0.5)))).events.transients
    assert (found.time, found.amplitude, found.frequency) == (0.8, pytest.approx(0.16), pytest.approx(112))


def test_a_curve_of_many_points_and_a_nested_pattern_are_read():
    many = curve("HapticIntensityControl", *[(i / 100, i % 2) for i in range(827)])
    document = pattern({"Pattern": [event(duration=8.0), many]})
    assert problems(ahap, document) == []
    assert read(ahap, document).events.joined.at(np.array([0.01, 0.02])) == pytest.approx([1, 0], abs=1e-3)


def test_too_short_a_signal_is_refused():
    with pytest.raises(ParameterError, match="at least 1e-05 s"):
        written_by(ahap, Signal(np.ones(1), 1e6, "1"))


def drawn(seconds, points, *taps):
    times, amplitude = np.array(points, dtype=float).T
    return Events.of([Part.of(times, amplitude, 0.0, 170.0)], taps, seconds)


def test_a_drawn_double_tap_is_two_transients_and_nothing_else():
    taps = (Transient(0.0, 0.81, 253.0), Transient(0.12, 0.25, 253.0))
    document = written_by(ahap, drawn(0.14, [(0, 0), (0.14, 0)], *taps))
    assert problems(ahap, document) == []
    events = [entry["Event"] for entry in document["Pattern"]]
    values = [[p["ParameterValue"] for p in event["EventParameters"]] for event in events]
    assert [event["EventType"] for event in events] == ["HapticTransient"] * 2
    assert [event["Time"] for event in events] == [0.0, 0.12]
    assert values == [[0.9, 0.8], [0.5, 0.8]]  # intensity is the root of the amplitude


def test_a_drawn_transient_is_stronger_and_duller_than_the_buzz_it_is_on():
    buzz = [(0.0, 0.0), (0.1, 0.0), (0.101, 0.25), (0.499, 0.25), (0.5, 0.0)]
    taps = (Transient(0.02, 0.64, 253.0), Transient(0.3, 0.81, 100.0))
    document = written_by(ahap, drawn(0.5, buzz, *taps))
    assert problems(ahap, document) == []
    back = read(ahap, document).events
    for wanted, got in zip(taps, back.transients, strict=True):
        assert (got.time, got.amplitude) == (wanted.time, pytest.approx(wanted.amplitude, abs=1e-3))
        assert got.frequency == pytest.approx(wanted.frequency, abs=0.1)
    t = np.array([0.05, 0.2, 0.31, 0.4])  # the buzz is as strong within the second transient as around it
    assert back.joined.at(t) == pytest.approx([0, 0.25, 0.25, 0.25], abs=1e-3)
    assert back.joined.hz(t[1:]) == pytest.approx([170] * 3, abs=0.1)


def test_a_vibration_after_a_tap_begins_where_it_is_and_at_its_strength():
    decay = curve("HapticIntensityControl", (0, 1), (0.25, 0), time=0.015)
    tap = event(0.0, "HapticTransient", HapticIntensity=0.8)
    source = read(ahap, pattern(tap, event(0.015, duration=0.25, HapticIntensity=0.8), decay)).events
    document = written_by(ahap, source)
    assert problems(ahap, document) == []
    back = read(ahap, document).events
    t = np.array([0.005, 0.0149, 0.0151, 0.02, 0.0225, 0.1, 0.2])
    assert source.joined.at(t[:4]) == pytest.approx([0, 0, 0.64, 0.615], abs=2e-3)
    assert back.joined.at(t) == pytest.approx(source.joined.at(t), abs=0.03)
    assert back.joined.start == pytest.approx(0.015, abs=2e-5)


def test_short_changes_between_taps_remain():
    swell = [(i / 50, 0.2 + 0.8 * (i % 2)) for i in range(26)]  # up and down within 40 ms
    taps = [event(i / 20, "HapticTransient", HapticIntensity=1.0) for i in range(9)]
    source = read(ahap, pattern(event(duration=0.5), *taps, curve("HapticIntensityControl", *swell))).events
    back = read(ahap, written_by(ahap, source)).events
    t = np.arange(0.0, 0.5, 0.001)
    assert back.joined.at(t) == pytest.approx(source.joined.at(t), abs=0.15)
    assert np.abs(back.joined.at(t) - source.joined.at(t)).mean() < 0.03
    wanted = [tap.amplitude for tap in source.transients]
    assert [tap.amplitude for tap in back.transients] == pytest.approx(wanted, abs=1e-3)


def test_controls_are_reset_in_silence():
    fades = [Part.of([start, start + 0.2], [0.5, 0.3], 0.0, 170.0) for start in (0.0, 0.3)]
    source = Events.of([*fades, Part.of([0.8, 1.0], [0.4, 0.4], 0.0, 100.0)], [Transient(0.7, 0.5, 200.0)])
    document = written_by(ahap, source)
    steps = [one["Parameter"] for one in document["Pattern"] if "Parameter" in one]
    assert [(one["Time"], one["ParameterValue"]) for one in steps] == [
        (time, idle) for time in (0.25, 0.6) for idle in (1, 0)
    ]
    back = read(ahap, document).events
    t = np.array([0.0, 0.1, 0.19, 0.2, 0.25, 0.3, 0.4, 0.49, 0.5, 0.6, 0.9])
    assert back.joined.at(t) == pytest.approx(source.joined.at(t), abs=0.01)
    assert max(part.peak for part in back.parts) == pytest.approx(0.5, abs=1e-3)
    assert back.transients[0].amplitude == pytest.approx(0.5, abs=1e-3)


def test_a_control_that_steps_when_an_event_ends_does_not_act_on_it():
    step = {"Parameter": {"ParameterID": "HapticIntensityControl", "Time": 1.0, "ParameterValue": 1.0}}
    document = pattern(event(), curve("HapticIntensityControl", (0, 0.5), (1, 0.5)), step)
    assert read(ahap, document).events.parts[0].amplitude == pytest.approx(0.25)
