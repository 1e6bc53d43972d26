from itertools import pairwise

import numpy as np
import pytest
from hypothesis import given, strategies as st

from tactogram.errors import ParameterError
from tactogram.rendering.files import read_haptic, write_haptic
from tactogram_studio.effects import editing as edit
from tactogram_studio.effects.editing import ready_track, shifted
from tactogram_studio.effects.effect import LEAST_S, Effect, Point, Track, Transient, mixed, track_of


def line(*pairs):
    return tuple(Point(time=float(time), value=float(value)) for time, value in pairs)


def pairs(points):
    return [(point.time, point.value) for point in points]


def transient(time, amplitude=1.0, frequency=200.0):
    return Transient(time=time, amplitude=amplitude, frequency=frequency)


BUZZ = Track(title="Buzz", amplitude=line((0, 0.8), (1, 0.8)), transients=(transient(0.1), transient(0.9)))


def test_a_point_stays_between_its_neighbours_and_within_its_range():
    track, index = edit.with_point(BUZZ, "amplitude", 0.5, 2.0)
    assert (index, pairs(track.amplitude)) == (1, [(0, 0.8), (0.5, 1.0), (1, 0.8)])
    moved = edit.moved_point(track, "amplitude", 1, 7.0, -3.0)
    assert pairs(moved.amplitude) == [(0, 0.8), (0.999, 0.0), (1, 0.8)]
    assert edit.without_point(moved, "amplitude", 1) == BUZZ
    with pytest.raises(ParameterError, match="at least one point of the frequency"):
        edit.without_point(BUZZ, "frequency", 0)
    with pytest.raises(ParameterError, match="there is no 10"):
        edit.moved_point(BUZZ, "amplitude", 9, 0.1, 0.1)


def test_a_transient_may_pass_another():
    track, index = edit.changed_transient(BUZZ, 0, time=0.95, amplitude=0.4, frequency=5000.0)
    assert index == 1
    assert track.transients == (transient(0.9), transient(0.95, 0.4, 1000.0))
    assert edit.without_transient(track, 1).transients == (transient(0.9),)


def test_trimming_keeps_the_range_and_clearing_keeps_the_rest():
    ramp = Track(
        amplitude=line((0, 0), (1, 1)), frequency=line((0, 100), (1, 200)), transients=(transient(0.5),)
    )
    kept = edit.trimmed(ramp, 0.25, 0.5)
    assert pairs(kept.amplitude) == [(0.25, 0.25), (0.5, 0.5)]
    assert pairs(kept.frequency) == [(0.25, 125), (0.5, 150)]
    assert kept.transients == ()  # it begins where the range ends
    cleared = edit.cleared(BUZZ, 0.05, 0.6)
    expected = [(0, 0.8), (0.05, 0.8), (0.051, 0), (0.599, 0), (0.6, 0.8), (1, 0.8)]
    assert pairs(cleared.amplitude) == expected
    assert cleared.transients == (transient(0.9),)
    assert edit.cleared(BUZZ, 0.0, 2.0).end == 0


def test_a_fade_is_a_ramp_of_amplitude_and_transients():
    out = edit.faded(BUZZ, 0.0, 1.0, "out")
    assert pairs(out.amplitude) == [(0, 0.8), (1, 0)]
    assert [one.amplitude for one in out.transients] == pytest.approx([0.9, 0.1])
    into = edit.faded(BUZZ, 0.0, 0.5, "in")
    assert pairs(into.amplitude) == [(0, 0), (0.5, 0.8), (1, 0.8)]
    assert [one.amplitude for one in into.transients] == pytest.approx([0.2, 1.0])


def test_a_fade_of_a_slope_follows_the_product():
    slope = Track(amplitude=line((0, 1), (1, 0)))
    points = edit.faded(slope, 0.0, 1.0, "out").amplitude
    t = np.linspace(0, 1, 101)
    drawn = np.interp(t, *np.transpose(pairs(points)))
    assert drawn == pytest.approx((1 - t) ** 2, abs=2e-3)


def test_a_repeat_has_gaps_and_moves_what_follows():
    twice = edit.repeated(BUZZ, 0.0, 0.5, times=2, gap=0.25)
    assert twice.end == 1.75
    t = [0.25, 0.6, 0.8, 1.25, 1.7]
    assert np.interp(t, *np.transpose(pairs(twice.amplitude))) == pytest.approx([0.8, 0, 0.8, 0.8, 0.8])
    assert [one.time for one in twice.transients] == pytest.approx([0.1, 0.85, 1.65])
    with pytest.raises(ParameterError, match="at most 60 s, this would be 75"):
        edit.repeated(BUZZ, 0.0, 0.75, times=100)


def test_moving_stops_at_zero_and_keeps_the_frequency():
    later = edit.shifted(BUZZ, 2.0)
    assert (later.start, later.end) == (2.0, 3.0)
    slope = later.changed(frequency=line((0, 100), (4, 300)))
    back = edit.shifted(slope, -9.0)
    assert (back.start, back.end) == (0.0, 1.0)
    assert pairs(back.frequency) == [(0, 200), (2, 300)]


@given(
    st.lists(
        st.tuples(st.integers(0, 2000), st.floats(0, 1)), min_size=2, max_size=8, unique_by=lambda p: p[0]
    ),
    st.integers(0, 1999),
    st.integers(1, 2000),
    st.integers(1, 4),
)
def test_every_operation_makes_a_valid_track(points, start, length, times):
    track = Track(amplitude=line(*sorted((ms / 1000, value) for ms, value in points)))
    first, last = start / 1000, (start + length) / 1000
    for made in (
        edit.trimmed(track, first, last),
        edit.cleared(track, first, last),
        edit.faded(track, first, last, "in"),
        edit.repeated(track, first, last, times=times, gap=0.01),
    ):
        at = [point.time for point in made.amplitude]
        assert all(b - a >= LEAST_S - 1e-9 for a, b in pairwise(at))
    middle = (first + last) / 2
    inside = edit.trimmed(track, first, last)
    for each in (track, inside):
        assert each.amplitude == () or each.start >= 0
    if first + 0.002 < middle and inside.amplitude and inside.start < middle < inside.amplitude[-1].time:
        values = [np.interp(middle, *np.transpose(pairs(one.amplitude))) for one in (track, inside)]
        assert values[0] == pytest.approx(values[1], abs=1e-5)


def test_merging_mixes_the_tracks_that_sound():
    other = Track(title="Other", amplitude=line((0, 0.6), (1, 0.6)))
    muted = BUZZ.changed(title="Muted", muted=True)
    made = edit.merged(Effect(tracks=(BUZZ.changed(transients=()), muted, other)))
    assert [track.title for track in made.tracks] == ["Muted", "Buzz + Other"]
    mix = made.tracks[1]
    assert [point.value * mix.gain for point in mix.amplitude] == pytest.approx([1.0, 1.0])


@pytest.mark.parametrize("format", ["ahap", "haptic"])
def test_what_was_drawn_comes_back_from_a_file(format, tmp_path):
    tap, buzz = ready_track("double-tap"), ready_track("ramp-down")
    effect = Effect(tracks=(tap, shifted(buzz, 0.3)))
    path = tmp_path / f"x.{format}"
    write_haptic(path, mixed(effect), format=format)
    track = track_of(read_haptic(path).events, "Read")
    assert [(one.time, round(one.amplitude, 3)) for one in track.transients] == [(0.0, 0.8), (0.12, 1.0)]
    t = np.array([0.2, 0.31, 0.6, 0.9])
    drawn = np.interp(t, [p.time for p in track.amplitude], [p.value for p in track.amplitude])
    assert drawn == pytest.approx([0, 1, 0.508, 0], abs=0.03)
    hz = np.interp(t[2], [p.time for p in track.frequency], [p.value for p in track.frequency])
    assert hz == pytest.approx(160, abs=6)
