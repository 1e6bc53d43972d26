"""Ready effects: within what an actuator plays, as long and as strong as asked for, and the same in every file."""

from itertools import pairwise

import numpy as np
import pytest

import tactogram
from tactogram.datasets.everyday import KIND_OF, SYNONYMS
from tactogram.errors import ParameterError
from tactogram.features.text_classifier import plain
from tactogram.rendering import carrier, haptic_formats, read_haptic, write_haptic
from tactogram.rendering.files import check_file
from tactogram.rendering.ready_effects import effect, effects, find_effect

FORMATS = haptic_formats()
PHONES = (60, 300)
"""Frequencies that the formats of phones and headsets hold, Hz."""


def samples(events, rate=8000):
    return carrier(events, rate).samples[0]


@pytest.mark.parametrize("name", effects())
def test_each_is_felt_and_within_what_phones_and_controllers_play(name):
    ready, events = effects()[name], effect(name)
    assert 0.4 <= events.peak <= 1
    assert PHONES[0] <= min(events.frequencies) <= max(events.frequencies) <= PHONES[1]
    assert events.seconds == ready.seconds <= 4
    x = samples(events)
    assert 0.4 <= np.abs(x).max() <= 1
    power = np.abs(np.fft.rfft(x, 2**16)) ** 2
    hz = np.fft.rfftfreq(2**16, 1 / 8000)
    assert power[(hz > 30) & (hz < 400)].sum() > 0.9 * power.sum()
    times = [tap.time for tap in events.transients]
    assert all(after - before > 0.019 for before, after in pairwise(times))  # none is in another


@pytest.mark.parametrize("format", FORMATS)
def test_each_is_valid_and_read_back_in_every_format(tmp_path, format):
    for name, ready in effects().items():
        path, events = tmp_path / f"{name}{FORMATS[format].suffix}", ready.events()
        written = write_haptic(path, events, format=format)
        checked = check_file(path, format=format)
        assert (checked["valid"], checked["warnings"]) == (True, []), name
        assert written["full_scale"] == 1, name
        file = read_haptic(path, format=format)
        strongest = file.events.peak if file.events else np.abs(file.signal.samples).max()
        assert 0.3 < strongest <= 1, name
        if format != "vibration":  # which plays only what is strong enough to start a motor
            end = max([*(part.end for part in events.parts), *(tap.time for tap in events.transients)])
            assert end - 0.03 < file.signal.seconds < ready.seconds + 0.06, name


@pytest.mark.parametrize("name", effects())
def test_an_ahap_holds_the_same_events(tmp_path, name):
    events = effect(name)
    write_haptic(tmp_path / "x.ahap", events, format="ahap")
    back = read_haptic(tmp_path / "x.ahap").events
    for tap, other in zip(events.transients, back.transients, strict=True):
        assert other.time == pytest.approx(tap.time, abs=0.001)
        assert other.amplitude == pytest.approx(tap.amplitude, abs=0.01)
        assert other.frequency == pytest.approx(tap.frequency, abs=1)
    t = np.arange(0, events.seconds, 0.001)
    np.testing.assert_allclose(back.joined.at(t), events.joined.at(t), atol=0.1)  # steps of a fast ramp


def test_every_name_is_of_one_effect_and_of_no_material():
    called = [plain(word) for ready in effects().values() for word in (ready.title, *ready.also)]
    assert len(set(called)) == len(called)
    materials = {plain(word) for name in KIND_OF for word in (name, *SYNONYMS.get(name, ()))}
    assert not materials & set(called)


def test_an_effect_is_one_by_any_of_its_names():
    assert find_effect("Double tap") is find_effect("double-tap") is effects()["double-tap"]
    assert find_effect("Button press").name == "click"
    for wrong, nearest in (("heartbeet", "heartbeat"), ("corduroy", "tap, double-tap")):
        with pytest.raises(ParameterError, match=f"name must be one of 32, e.g. {nearest}"):
            effect(wrong)


def test_what_repeats_fills_the_seconds_and_a_vibration_is_stretched():
    beats = effect("heartbeat", seconds=5)
    assert beats.seconds == 5
    starts = [run.start for run in beats.parts[0].runs]
    np.testing.assert_allclose(starts[::2], 0.833 * np.arange(6), atol=1e-6)
    twice, once = effect("ramp-up", seconds=1.2), effect("ramp-up")
    np.testing.assert_allclose(twice.parts[0].at(2 * once.parts[0].times), once.parts[0].amplitude, atol=1e-9)
    assert effect("rain", seconds=7.5).seconds == 7.5


@pytest.mark.parametrize(
    ("name", "values", "message"),
    [
        ("click", {"seconds": 1.0}, "seconds cannot change the length of click; omit it"),
        ("heartbeat", {"seconds": 0.5}, "seconds must be >= 0.833 for heartbeat, got 0.5"),
        ("rain", {"seconds": 601}, "seconds must be at most 600, got 601"),
        ("rain", {"strength": 1.5}, "strength must be less than or equal to 1, got 1.5"),
        ("rain", {"seed": -1}, "seed must be >= 0, got -1"),
    ],
)
def test_what_does_not_go_is_refused(name, values, message):
    with pytest.raises(ParameterError, match=message):
        effect(name, **values)


def test_strength_scales_and_a_seed_draws():
    np.testing.assert_allclose(
        samples(effect("engine", strength=0.5)), 0.5 * samples(effect("engine")), atol=1e-6
    )
    first, again, other = (samples(effect("rain", seed=seed)) for seed in (1, 1, 2))
    np.testing.assert_array_equal(first, again)
    assert np.abs(first - other).max() > 0.1
    drops = effect("rain", seconds=300).transients
    assert len(drops) / 300 == pytest.approx(22, rel=0.05)  # as many a second as it says
    assert np.median([drop.amplitude for drop in drops]) < 0.3  # most are light
    np.testing.assert_array_equal(samples(effect("heartbeat", seed=1)), samples(effect("heartbeat", seed=2)))


def test_a_transient_adds_to_the_vibration():
    events = tactogram.effect("thud")
    assert [(tap.time, tap.amplitude, tap.frequency) for tap in events.transients] == [(0.0, 1.0, 80)]
    assert events.parts[0].peak == 0.6
