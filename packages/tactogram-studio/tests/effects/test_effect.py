import numpy as np
import pytest

from tactogram.errors import DataError, ParameterError
from tactogram.rendering import effects
from tactogram.rendering.files import read_haptic
from tactogram.rendering.files.analysis import envelope_of
from tactogram.rendering.files.events import Events, Transient as Tap
from tactogram.signal import Signal
from tactogram_studio.effects.editing import ready_track
from tactogram_studio.effects.effect import (
    Effect,
    Point,
    Track,
    Transient,
    effect_from_json,
    mixed,
    signal_of,
    track_of,
    track_of_signal,
)


def tone(amplitude, hz, *, start=0.0, end=1.0, **values):
    points = tuple(Point(time=time, value=amplitude) for time in (start, end))
    return Track(amplitude=points, frequency=(Point(time=0.0, value=hz),), **values)


def test_a_mix_adds_powers_and_weights_frequencies_by_them():
    mix = mixed(
        Effect(tracks=(tone(0.6, 100.0), tone(0.8, 200.0, gain=0.5), tone(1.0, 300.0, muted=True)))
    ).joined
    assert np.interp(0.5, mix.times, mix.amplitude) == pytest.approx(np.hypot(0.6, 0.4), abs=1e-6)
    hz = (0.36 * 100 + 0.16 * 200) / (0.36 + 0.16)
    assert np.interp(0.5, mix.times, mix.frequency) == pytest.approx(hz, rel=1e-6)


def test_a_mix_is_each_track_where_it_is_alone():
    mix = mixed(Effect(tracks=(tone(0.5, 100.0, end=0.4), tone(0.25, 200.0, start=0.6)))).joined
    assert mix.end == 1.0
    t = [0.0, 0.2, 0.4, 0.41, 0.59, 0.6, 1.0]
    expected = [0.5, 0.5, 0.5, 0, 0, 0.25, 0.25]
    assert np.interp(t, mix.times, mix.amplitude) == pytest.approx(expected, abs=1e-6)
    at = [0.0, 0.4, 0.6, 1.0]
    assert np.interp(at, mix.times, mix.frequency) == pytest.approx([100, 100, 200, 200])


def test_transients_at_the_same_time_become_one():
    first = Track(transients=(Transient(time=0.1, amplitude=0.6, frequency=100.0),))
    second = Track(transients=(Transient(time=0.1, amplitude=0.6, frequency=250.0),), gain=0.5)
    [pulse] = mixed(Effect(tracks=(first, second))).transients
    assert (pulse.time, pulse.amplitude) == (0.1, pytest.approx(0.9))
    assert pulse.frequency == pytest.approx(150)


def test_the_signal_of_an_effect_has_its_envelope():
    effect = Effect(tracks=(tone(0.5, 150.0, end=0.5),))
    found = envelope_of(signal_of(effect))
    assert np.interp(0.25, found.times, found.amplitude) == pytest.approx(0.5, abs=0.005)
    assert np.interp(0.25, found.times, found.frequency) == pytest.approx(150, abs=1)


def test_nothing_to_play_is_refused():
    silent = tone(0.0, 100.0)
    for tracks in ((), (silent,), (tone(1.0, 100.0, muted=True),)):
        with pytest.raises(ParameterError, match="nothing to play"):
            mixed(Effect(tracks=tracks))


def test_an_effect_survives_json_and_damage_is_refused():
    effect = Effect(title="Æ", tracks=(ready_track("error"),), simulated=True)
    assert effect_from_json(effect.to_json(), where="x") == effect
    for text in ("{", "[]", '{"tracks":[{"amplitude":[{"time":1,"value":2}]}]}', '{"tracks":[{"gain":NaN}]}'):
        with pytest.raises(DataError, match="x: not an effect: "):
            effect_from_json(text, where="x")


@pytest.mark.parametrize("name", effects())
def test_a_ready_effect_is_a_track_that_plays_the_same(name):
    track, ready = ready_track(name), effects()[name]
    assert track.title == ready.title
    assert track.start == 0
    assert ready.seconds - 0.05 < track.end <= ready.seconds + 0.001  # a track ends with its last transient
    own, drawn = ready.events(), mixed(Effect(tracks=(track,)))
    assert drawn.peak == pytest.approx(own.peak, abs=0.02)
    t = np.arange(0.0005, ready.seconds, 0.001)
    np.testing.assert_allclose(drawn.strength(t), own.strength(t), atol=0.05)


def test_a_signal_becomes_a_track_relative_to_its_peak():
    t = np.arange(8000) / 8000
    samples = 9.81 + np.where(t < 0.5, 40.0, 10.0) * np.sin(2 * np.pi * 120 * t)
    track = track_of_signal(Signal(samples.astype(np.float32), 8000, "m/s^2"), "Stroke")
    at = [point.time for point in track.amplitude], [point.value for point in track.amplitude]
    assert np.interp([0.25, 0.75], *at) == pytest.approx([1.0, 0.25], abs=0.03)
    hz = np.interp(0.5, [p.time for p in track.frequency], [p.value for p in track.frequency])
    assert hz == pytest.approx(120, abs=3)
    assert ready_track("tap").frequency == Track().frequency  # to draw on, as an empty track's
    many = Events(1.0, (), (Tap(0.0, 1.0, 100.0),) * 3000)
    with pytest.raises(ParameterError, match="at most 2000 transients, got 3000"):
        track_of(many, "Many")
    with pytest.raises(ParameterError, match="at most 60 s, got 61 s"):
        track_of_signal(Signal(np.ones(6100, np.float32), 100, "1"), "Long")


def test_jumps_of_a_file_take_a_millisecond(tmp_path):
    (tmp_path / "x.json").write_text("[100, 50, 100]")
    track = track_of(read_haptic(tmp_path / "x.json").events, "Pattern")
    assert [(p.time, p.value) for p in track.amplitude] == [
        (0.0, 1.0), (0.1, 1.0), (0.101, 0.0), (0.15, 0.0), (0.151, 1.0), (0.25, 1.0)
    ]  # fmt: skip
    assert track.transients == ()
