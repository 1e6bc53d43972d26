import numpy as np
import pytest
from tests.rendering.files.documents import problems, read, written_by

from tactogram.errors import DataError
from tactogram.rendering.files import check_file, read_haptic, write_haptic
from tactogram.rendering.files.analysis import envelope_of
from tactogram.rendering.files.documents import encoded
from tactogram.rendering.files.formats import tact
from tactogram.signal import Signal

RATE = 2000


def swell(seconds=1.0, strength=1.0, hz=150):
    t = np.arange(round(seconds * RATE)) / RATE
    return Signal(strength * np.sin(np.pi * t / seconds) * np.sin(2 * np.pi * hz * t), RATE, "1")


def written(signal):
    document = written_by(tact, signal)
    assert problems(tact, document) == []
    return document, document["project"]["tracks"][0]["effects"][0]["modes"]


def frames(dots, length):
    """Return what the motors do in each frame, of a player that takes a step with both of its ends."""
    found = []
    for time in range(0, length, 20):
        active = [dot for dot in dots if dot["startTime"] <= time <= dot["endTime"]]
        assert len(active) == 1
        found.append({point["intensity"] for point in active[0]["pointList"]} or {0})
    return found


def pattern(*effects, positions=("Head",)):
    """Return a file as the Designer saves it."""
    motors = [{"index": i, "x": 0.2 * i, "y": 0.5} for i in range(6)]
    project = {
        "createdAt": 1600000000000,
        "description": "",
        "layout": {"layouts": dict.fromkeys(positions, motors), "name": "Tactal", "type": "Tactal"},
        "mediaFileDuration": 1,
        "name": "Knock",
        "tracks": [{"effects": list(effects), "enable": True}, {"enable": True, "effects": []}],
        "updatedAt": 1600000000000,
    }
    return {"project": project, "durationMillis": 0, "intervalMillis": 20, "size": 20}


def mode(dots=(), paths=()):
    return {
        "dotMode": {"dotConnected": False, "feedback": list(dots)},
        "mode": "PATH_MODE" if paths else "DOT_MODE",
        "pathMode": {"feedback": list(paths)},
    }


def effect(start, length, **modes):
    return {"modes": modes, "name": "Effect 1", "offsetTime": length, "startTime": start}


def dots(start, end, *strengths, playback="NONE"):
    points = [{"index": i, "intensity": strength} for i, strength in enumerate(strengths)]
    return {"startTime": start, "endTime": end, "playbackType": playback, "pointList": points}


def path(*points, playback="NONE"):
    listed = [{"x": 0.5, "y": 0.5, "intensity": strength, "time": time} for time, strength in points]
    return {"movingPattern": "CONST_SPEED", "playbackType": playback, "visible": True, "pointList": listed}


def level(document, *ms):
    found = envelope_of(read(tact, document).signal)
    return np.interp(np.array(ms) / 1e3, found.times, found.amplitude)


def test_all_motors_of_the_front_have_the_strength_of_each_frame_in_hundredths():
    document, modes = written(swell())
    source = envelope_of(swell())
    steps = frames(modes["VestFront"]["dotMode"]["feedback"], 1000)
    strength = [max(step) for step in steps]
    assert [len(step) for step in steps] == [1] * 50
    times = np.arange(20, 1000, 20) / 1e3
    assert strength[1:] == pytest.approx(np.interp(times, source.times, source.amplitude), abs=0.0051)
    assert all(100 * share == pytest.approx(round(100 * share)) for share in strength)
    assert {len(d["pointList"]) for d in modes["VestFront"]["dotMode"]["feedback"]} <= {0, 20}
    assert document["intervalMillis"] == 20


def test_the_steps_cover_the_effect_and_the_back_is_silent():
    document, modes = written(swell(seconds=0.513))
    steps = modes["VestFront"]["dotMode"]["feedback"]
    assert (steps[0]["startTime"], steps[-1]["endTime"]) == (0, 513)
    assert [d["startTime"] for d in steps[1:]] == [d["endTime"] for d in steps[:-1]]
    assert document["project"]["tracks"][0]["effects"][0]["offsetTime"] == 513
    assert modes["VestBack"]["dotMode"]["feedback"] == []
    layouts = document["project"]["layout"]["layouts"]
    assert [len(layouts[position]) for position in ("VestFront", "VestBack")] == [20, 20]


def test_a_peak_at_full_scale_is_1_and_equal_steps_are_one():
    t = np.arange(RATE) / RATE
    _, modes = written(Signal(np.sin(2 * np.pi * 150 * t), RATE, "1"))
    (step,) = modes["VestFront"]["dotMode"]["feedback"]
    assert (step["startTime"], step["endTime"]) == (0, 1000)
    assert {point["intensity"] for point in step["pointList"]} == {1.0}


def test_silence_moves_no_motor():
    _, modes = written(Signal(np.zeros(RATE), RATE, "1"))
    (step,) = modes["VestFront"]["dotMode"]["feedback"]
    assert step["pointList"] == []


def test_the_strength_is_read_back_and_the_lost_frequency_is_reported(tmp_path):
    found = write_haptic(tmp_path / "x.tact", swell(hz=60), format="tact")
    assert found["loss"]["envelope_error"] < 0.05
    assert found["loss"]["frequency_octaves"] == pytest.approx(np.log2(170 / 60), abs=0.05)
    assert found["verdict"].startswith("the strength, at the wrong frequency")
    assert read_haptic(tmp_path / "x.tact").signal.seconds == pytest.approx(1)


def test_effects_are_placed_and_the_strongest_motor_counts():
    document = pattern(
        effect(100, 200, Head=mode([dots(0, 200, 0.2, 0.6)])),
        effect(200, 300, Head=mode([dots(0, 100, 0.3), dots(100, 300, "0.900")])),
    )
    assert problems(tact, document) == ["intensity must be a number, got '0.900': read as one"]
    assert level(document, 50, 150, 250, 400) == pytest.approx([0, 0.6, 0.6, 0.9], abs=0.01)
    document["project"]["tracks"][0]["enable"] = False
    with pytest.raises(DataError, match="holds no effect"):
        read(tact, document)


@pytest.mark.parametrize(
    ("playback", "expected"),
    [("FADE_IN", [0.2, 0.4, 0.6]), ("FADE_OUT", [0.6, 0.4, 0.2]), ("FADE_IN_OUT", [0.4, 0.8, 0.4])],
)
def test_fades_are_linear(playback, expected):
    document = pattern(effect(0, 1000, Head=mode([dots(0, 1000, 0.8, playback=playback)])))
    assert level(document, 250, 500, 750) == pytest.approx(expected, abs=0.02)


def test_a_path_is_as_strong_as_its_points():
    lines = pattern(effect(0, 1000, Head=mode([], [path((0, 0.2), (1000, 0.8)), path()])))
    assert level(lines, 250, 500, 750) == pytest.approx([0.35, 0.5, 0.65], abs=0.01)
    single = pattern(effect(0, 1000, Head=mode([], [path((500, 0.7))])))
    assert level(single, 250, 750) == pytest.approx([0, 0.7], abs=0.01)
    assert read(tact, single).facts["left_out"] == "which motors"


@pytest.mark.parametrize(
    ("document", "problem"),
    [
        ({"feedback": {}}, "project: is required"),
        (pattern(effect(0, 10, Head=mode([dots(0, 10, "x")]))), "intensity: must be a number, got 'x'"),
        (pattern(effect(-1, 0)), "holds no effect of 1 ms or more"),
    ],
)
def test_what_no_player_accepts_is_refused_in_a_line(document, problem, tmp_path):
    file = tmp_path / "x.tact"
    file.write_bytes(encoded(document))
    assert problem in check_file(file)["problems"][0]
    with pytest.raises(DataError, match=r"x\.tact: not valid bHaptics pattern: "):
        read_haptic(file)


@pytest.mark.parametrize(
    ("made", "problem"),
    [
        (effect(0, 99, Head=mode([dots(0, 99, 1.5)])), "intensity must be 0 to 1, got 1.5: clamped"),
        (
            effect(0, 99, Head=mode([dots(9, 5, 1)])),
            "endTime must be at least startTime, got 5 and 9: left out",
        ),
        (effect(-1, 99), "startTime must be at least 0, got -1: clamped"),
        (effect(0, 99, Arm=mode()), "position must be one of Head, got Arm: played all the same"),
        (effect(0, 99, Head=mode([dots(0, 99, *[1] * 7)])), "a dot must be at a motor of the layout, got 6"),
        (effect(0, 99, Head=mode([dots(0, 99, 1, playback="LOUD")])), "FADE_IN_OUT, got LOUD: read as NONE"),
    ],
)
def test_what_players_forgive_is_read_and_said(made, problem):
    [line] = problems(tact, pattern(made))
    assert problem in line
    assert read(tact, pattern(made)).events.seconds == pytest.approx(0.099)
