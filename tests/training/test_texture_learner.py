"""What every texture map fitted in closed form does: conditions, lengths and mixes, and what it refuses."""

from functools import cache

import numpy as np
import pytest
from scipy.signal import lfilter

from tactogram import models
from tactogram.errors import ParameterError
from tactogram.model import Example, SignalKind
from tactogram.signal import Signal

RATE = 1000.0
AXES = ("x", "z")

pytestmark = pytest.mark.parametrize("name", ["ar_texture", "texture_var"])


def recording(material, frequency, level, seconds=2.0, seed=0, **condition):
    angle = 2 * np.pi * frequency / RATE
    noise = np.random.default_rng(seed).standard_normal((2, round(seconds * RATE) + 500))
    x = lfilter([1], [1, -1.8 * np.cos(angle), 0.81], noise)[:, 500:]
    return Example(
        f"{material}-{seed}", Signal(level * x / x.std(), RATE, "m/s^2", AXES), material, condition
    )


def stroked(first=0):
    conditions = enumerate([(50, 0.5), (50, 2), (200, 0.5), (200, 2)], first)
    return [recording("felt", v, v * f / 100, seed=i, speed_mm_s=v, force_n=f) for i, (v, f) in conditions]


CORK = [recording("cork", 60, 0.1, seed=s) for s in range(3)]
TILE = [recording("tile", 250, 2.0, seconds=3.0, seed=s) for s in range(2)]


def untrained(name, materials, **config):
    facts = models.find(name)
    return facts.build(facts.config(config), SignalKind(RATE, "m/s^2", AXES, materials), seed=0)


def trained(name, examples, **config):
    learner = untrained(name, tuple(sorted({e.material for e in examples})), **config)
    (stage,) = learner.stages(examples)
    (batch,) = learner.batches(stage, examples, seed=0)
    learner.step(stage, batch)
    return learner


@cache
def known(name):
    """A model of cork and tile that no test changes."""
    return trained(name, CORK + TILE)


def test_length_is_the_median_of_the_training_recordings(name):
    assert known(name).generate({"material": "cork"}, seed=0).seconds == 2.0


def test_mix_does_not_depend_on_the_scale_of_its_weights(name):
    one, two = (
        known(name).generate({"material": {"cork": w, "tile": 2 * w}}, seed=0).samples for w in (0.5, 4)
    )
    np.testing.assert_array_equal(one, two)


def test_recordings_of_one_condition_are_one_model(name):
    assert len(trained(name, stroked() + stroked(10)).maps[0].models) == 4
    assert len(trained(name, stroked(), by_condition=False).maps[0].models) == 1


def test_condition_that_only_some_recordings_name_is_left_out(name):
    learner = trained(name, [*stroked(), recording("felt", 100, 1.0, seed=9, speed_mm_s=100)])
    assert learner.maps[0].has_conditions == (True, False)
    with pytest.raises(ParameterError, match="force_n is unknown"):
        learner.generate({"material": "felt", "force_n": 1.0}, seed=0)


@pytest.mark.parametrize(
    ("condition", "message"),
    [
        ({}, "'material' is needed"),
        ({"material": "glass"}, "must be one of cork, tile, got 'glass'"),
        ({"material": "cork", "words": {"rough": 1}}, "not one this model takes"),
        ({"material": "cork", "speed_mm_s": 100.0}, "speed_mm_s is unknown"),
    ],
)
def test_condition_it_cannot_meet_is_refused(name, condition, message):
    with pytest.raises(ParameterError, match=message):
        known(name).generate(condition, seed=0)


def test_material_without_recording_is_refused(name):
    learner = untrained(name, ("cork", "tile"))
    with pytest.raises(ParameterError, match="no training recording of tile"):
        learner.step(learner.stages(CORK)[0], CORK)


def test_untrained_does_not_generate(name):
    with pytest.raises(ParameterError, match="has not been trained"):
        untrained(name, ("cork",)).generate({"material": "cork"}, seed=0)


def test_state_of_other_materials_is_refused(name):
    with pytest.raises(ParameterError, match="state is of cork, tile; expected cork"):
        untrained(name, ("cork",)).load_state(known(name).state())
