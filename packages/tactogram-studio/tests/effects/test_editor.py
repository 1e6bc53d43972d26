import pytest

from tactogram.errors import ParameterError
from tactogram_studio.effects.editing import ready_track
from tactogram_studio.effects.editor import Editor
from tactogram_studio.effects.effect import Effect, Track


def ready(*titles):
    editor = Editor(Effect())
    for title in titles:
        editor.insert((ready_track(title.lower().replace(" ", "-")),))
    return editor


def test_ready_effects_follow_each_other_and_the_last_one_fades():
    editor = ready("Double tap", "Buzz")
    editor.operate("out")
    tap, buzz = editor.effect.tracks
    assert [one.time for one in tap.transients] == [0.0, 0.12]
    assert (buzz.start, buzz.end) == (0.24, 0.74)
    assert [(p.time, p.value) for p in buzz.amplitude] == [(0.24, 0.0), (0.245, 0.792), (0.74, 0.0)]
    assert editor.cursor == 0.84


def test_undo_and_redo_go_through_every_step():
    editor = ready("Tap")
    states = [Effect(), editor.effect]
    for event in (
        {"do": "add", "track": 0, "line": "amplitude", "time": 0.1, "value": 0.5},
        {"do": "gain", "track": 0, "value": 0.5},
        {"do": "mute", "track": 0},
        {"do": "drop", "track": 0},
    ):
        editor.handle(event)
        states.append(editor.effect)
    for state in reversed(states[:-1]):
        editor.undo()
        assert editor.effect == state
    assert not editor.undoable
    for state in states[1:]:
        editor.redo()
        assert editor.effect == state
    assert not editor.redoable


def test_a_held_key_is_one_step_and_a_new_change_ends_redoing():
    editor = ready("Buzz")
    whole = editor.effect
    move = {"do": "move", "track": 0, "line": "amplitude", "index": 1, "value": 0.8, "nudge": True}
    for time in (0.01, 0.02, 0.03):
        editor.handle({**move, "time": time})
    assert editor.effect.tracks[0].amplitude[1].time == 0.03
    editor.undo()
    assert editor.effect == whole
    editor.handle({"do": "mute", "track": 0})
    assert not editor.redoable


def test_a_range_limits_an_operation():
    editor = ready("Buzz")
    editor.handle({"do": "range", "start": 0.4, "end": 0.2})
    editor.operate("trim")
    track = editor.effect.tracks[0]
    assert (editor.cursor, track.start, track.end) == (0.2, 0.2, 0.4)


def test_a_transient_moves_by_strength_and_by_frequency():
    editor = ready("Tap")
    event = {"do": "move", "track": 0, "index": 0, "time": 0.05}
    editor.handle({**event, "line": "transients", "value": 0.5})
    editor.handle({**event, "line": "tones", "value": 120})
    [one] = editor.effect.tracks[0].transients
    assert (one.time, one.amplitude, one.frequency) == (0.05, 0.5, 120.0)
    editor.handle({"do": "remove", "track": 0, "line": "tones", "index": 0})
    assert (editor.effect.tracks[0].transients, editor.item) == ((), None)


def test_a_drawing_replaces_what_it_covers():
    editor = Editor(Effect(tracks=(Track(),)))
    points = [{"time": n / 100, "value": min(1.0, n / 50)} for n in range(101)]
    editor.handle({"do": "draw", "track": 0, "line": "amplitude", "points": points})
    assert [(p.time, p.value) for p in editor.effect.tracks[0].amplitude] == [(0, 0), (0.5, 1), (1, 1)]
    editor.handle({"do": "draw", "track": 0, "line": "amplitude", "points": [{"time": 0.4, "value": 0.1}]})
    assert len(editor.effect.tracks[0].amplitude) == 4


@pytest.mark.parametrize(
    ("event", "message"),
    [
        ({"do": "format"}, "do must be one of select"),
        ({"do": "select", "track": 7}, "the effect has 1 tracks, there is no 8"),
        ({"do": "select", "track": True}, "track must be a whole number"),
        ({"do": "add", "track": 0, "line": "title", "time": 0, "value": 0}, "line must be one of"),
        ({"do": "add", "track": 0, "line": "amplitude", "time": "1", "value": 0}, "time must be a number"),
        (
            {"do": "move", "track": 0, "line": "amplitude", "index": 9, "time": 0, "value": 0},
            "there is no 10",
        ),
        ({"do": "gain", "track": 0, "value": 9.0}, "gain: must be less than or equal to 2"),
        ({"do": "draw", "track": 0, "line": "amplitude", "points": "all"}, "at most 5000 points"),
        ({"do": "range", "start": float("nan"), "end": 1}, "start must be a number"),
    ],
)
def test_a_bad_event_is_refused_and_changes_nothing(event, message):
    editor = ready("Buzz")
    before = editor.effect
    with pytest.raises(ParameterError, match=message):
        editor.handle(event)
    assert editor.effect == before
