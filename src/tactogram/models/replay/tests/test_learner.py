"""The baseline: what comes out was recorded, at its level, and a mix lies between its materials."""

import numpy as np
import pytest
from scipy.signal import lfilter

from tactogram.errors import ParameterError
from tactogram.model import Example, SignalKind
from tactogram.models.replay import Config, build
from tactogram.signal import Signal

RATE = 1000.0
AXES = ("x", "z")


def recording(name, pole, level, seconds=3.0, seed=0, steady=0.0, **condition):
    noise = np.random.default_rng(seed).standard_normal((2, round(seconds * RATE)))
    x = lfilter([1], [1, -pole], noise)
    x = level * x / x.std() + steady
    return Example(f"{name}-{seed}", Signal(x, RATE, "m/s^2", AXES), name, condition)


def trained(examples, seed=0, **config):
    kind = SignalKind(RATE, "m/s^2", AXES, tuple(sorted({e.material for e in examples})))
    learner = build(Config(**config), kind, seed=seed)
    (stage,) = learner.stages(examples)
    (batch,) = learner.batches(stage, examples, seed=0)
    learner.step(stage, batch)
    return learner


CORK = [recording("cork", 0.9, 0.1, seed=s) for s in range(4)]
TILE = [recording("tile", -0.5, 2.0, seconds=5.0, seed=s) for s in range(10, 12)]


def rms(signal):
    return float(np.sqrt(np.mean(signal.samples.astype(float) ** 2)))


def test_what_comes_out_was_recorded():
    signal = trained(CORK, overlap_s=0.02, search_s=0).generate({"material": "cork"}, seconds=4, seed=1)
    recorded = np.hstack([e.signal.samples for e in CORK])
    windows = np.lib.stride_tricks.sliding_window_view(recorded[0], 50)
    matches = [
        np.abs(windows - signal.samples[0, i : i + 50]).max(axis=1).min() < 1e-6 for i in range(0, 3900, 10)
    ]
    assert np.mean(matches) > 0.75  # all but what lies in or across a crossfade of 20 ms, each 480 ms


@pytest.mark.parametrize(("name", "level"), [("cork", 0.1), ("tile", 2.0)])
def test_level_unit_and_axes_are_those_of_the_training_data(name, level):
    signal = trained(CORK + TILE).generate({"material": name}, seconds=30, seed=1)
    assert (signal.unit, signal.axes, signal.rate, signal.seconds) == ("m/s^2", AXES, RATE, 30.0)
    assert rms(signal) == pytest.approx(level, rel=0.06)


def test_length_is_the_median_of_the_training_recordings():
    assert trained(CORK + TILE).generate({"material": "cork"}, seed=0).seconds == 3.0


def test_a_mix_has_a_power_between_its_materials():
    learner = trained(CORK + TILE)
    mixed = learner.generate({"material": {"cork": 1, "tile": 3}}, seconds=30, seed=0)
    assert rms(mixed) ** 2 == pytest.approx(0.25 * 0.1**2 + 0.75 * 2.0**2, rel=0.1)
    again = learner.generate({"material": {"cork": 2, "tile": 6}}, seconds=30, seed=0)
    np.testing.assert_array_equal(mixed.samples, again.samples)


def test_gravity_is_not_mixed_by_power():
    steady = [recording(n, 0.5, 0.1, seed=i, steady=9.81) for i, n in enumerate(("cork", "tile"))]
    mixed = trained(steady).generate({"material": {"cork": 1, "tile": 1}}, seconds=5, seed=0)
    assert mixed.samples.mean() == pytest.approx(9.81, abs=0.05)


def test_speed_and_force_take_the_nearest_recordings():
    stroked = [
        recording("felt", 0.5, v * f, seed=i, speed_mm_s=v, force_n=f)
        for i, (v, f) in enumerate([(50, 0.5), (50, 2), (200, 0.5), (200, 2)])
    ]
    learner = trained([*stroked, recording("felt", 0.5, 1e-3, seed=9)])
    for speed, force, level in ((60, 0.4, 25), (190, 1.9, 400), (20, 2, 100)):
        signal = learner.generate({"material": "felt", "speed_mm_s": speed, "force_n": force}, seed=0)
        assert rms(signal) == pytest.approx(level, rel=0.1)
    slow = learner.generate({"material": "felt", "speed_mm_s": 0}, seconds=60, seed=0)
    assert rms(slow) == pytest.approx(np.sqrt((25**2 + 100**2) / 2), rel=0.1)


def test_what_is_kept_is_bounded_and_of_every_recording():
    learner = trained(CORK + TILE, seconds_per_material=2.0)
    for members in learner.segments.values():
        assert sum(k.signal.seconds for k in members) == pytest.approx(2.0)
    assert {k.id for k in learner.segments["cork"]} == {e.id for e in CORK}
    few = trained(CORK, seconds_per_material=1.0)
    assert len(few.segments["cork"]) == 2
    short = [recording("cork", 0.9, 0.1, seconds=0.3, seed=s) for s in range(3)]
    both = trained([*short, *CORK], seconds_per_material=10.0)
    assert sum(k.signal.seconds for k in both.segments["cork"]) == pytest.approx(10.0)


def test_the_seed_of_the_recipe_decides_what_is_kept():
    one, two = (trained(CORK, seed=seed, seconds_per_material=2.0) for seed in (0, 1))
    assert not np.array_equal(one.segments["cork"][0].signal.samples, two.segments["cork"][0].signal.samples)


@pytest.mark.parametrize(
    ("condition", "message"),
    [
        ({"material": "cork", "speed_mm_s": 100.0}, "speed_mm_s is unknown for the recordings of cork"),
        ({"material": "cork", "speed_mm_s": np.nan}, "speed_mm_s must be a finite number"),
    ],
)
def test_condition_it_cannot_meet_is_refused(condition, message):
    with pytest.raises(ParameterError, match=message):
        trained(CORK + TILE).generate(condition, seed=0)


def test_what_it_cannot_learn_from_is_refused():
    with pytest.raises(ParameterError, match="must be longer than 240 samples"):
        trained([recording("cork", 0.9, 0.1, seconds=0.2)])
    kind = SignalKind(RATE, "m/s^2", AXES, ("cork", "tile"))
    learner = build(Config(), kind, seed=0)
    with pytest.raises(ParameterError, match="no training recording of tile"):
        learner.step(learner.stages(CORK)[0], CORK)
    with pytest.raises(ParameterError, match="has not been trained"):
        learner.generate({"material": "cork"}, seed=0)
    with pytest.raises(ParameterError, match="state is of cork; expected tile"):
        trained(TILE).load_state(trained(CORK).state())
    with pytest.raises(ValueError, match="segment_s must be above"):
        Config(segment_s=0.2)
