"""The texture model: level, unit and spectrum of what it learned, and what it refuses."""

import numpy as np
import pytest
from scipy.signal import lfilter, welch

from tactogram.model import Example, SignalKind
from tactogram.models.ar_texture import Config, build
from tactogram.signal import Signal

RATE = 1000.0
AXES = ("x", "z")


def recording(name, frequency, level, seconds=2.0, seed=0, **condition):
    angle = 2 * np.pi * frequency / RATE
    noise = np.random.default_rng(seed).standard_normal((2, round(seconds * RATE) + 500))
    x = lfilter([1], [1, -1.8 * np.cos(angle), 0.81], noise)[:, 500:]
    return Example(f"{name}-{seed}", Signal(level * x / x.std(), RATE, "m/s^2", AXES), name, condition)


def trained(examples, **config):
    kind = SignalKind(RATE, "m/s^2", AXES, tuple(sorted({e.material for e in examples})))
    learner = build(Config(**config), kind, seed=0)
    (stage,) = learner.stages(examples)
    (batch,) = learner.batches(stage, examples, seed=0)
    learner.step(stage, batch)
    return learner


CORK = [recording("cork", 60, 0.1, seed=s) for s in range(3)]
TILE = [recording("tile", 250, 2.0, seconds=3.0, seed=s) for s in range(2)]
STROKED = [
    recording("felt", v, v * f / 100, seed=i, speed_mm_s=v, force_n=f)
    for i, (v, f) in enumerate([(50, 0.5), (50, 2), (200, 0.5), (200, 2)])
]


def peak(signal):
    frequencies, density = welch(signal.samples, signal.rate, nperseg=256)
    return frequencies[np.argmax(density.sum(axis=0))]


@pytest.mark.parametrize(("name", "level", "frequency"), [("cork", 0.1, 60), ("tile", 2.0, 250)])
def test_level_unit_and_spectrum_are_those_of_the_training_data(name, level, frequency):
    signal = trained(CORK + TILE).generate({"material": name}, seconds=20, seed=1)
    assert (signal.unit, signal.axes, signal.rate) == ("m/s^2", AXES, RATE)
    assert signal.samples.std() == pytest.approx(level, rel=0.05)
    assert peak(signal) == pytest.approx(frequency, abs=10)


def test_mix_lies_between_its_materials():
    learner = trained(CORK + TILE)
    mixed = learner.generate({"material": {"cork": 0.5, "tile": 0.5}}, seconds=30, seed=0)
    assert 20 * np.log10(mixed.samples.std()) == pytest.approx(10 * np.log10(0.1 * 2.0), abs=0.5)
    assert 80 < peak(mixed) < 230


def test_speed_and_force_decide_what_is_felt():
    learner = trained(STROKED)
    slow = learner.generate({"material": "felt", "speed_mm_s": 50, "force_n": 0.5}, seconds=20, seed=0)
    fast = learner.generate({"material": "felt", "speed_mm_s": 200, "force_n": 2}, seconds=20, seed=0)
    assert (peak(slow), peak(fast)) == (pytest.approx(50, abs=10), pytest.approx(200, abs=10))
    assert (slow.samples.std(), fast.samples.std()) == (
        pytest.approx(0.25, rel=0.1),
        pytest.approx(4, rel=0.1),
    )
    between = learner.model({"material": "felt", "speed_mm_s": 120, "force_n": 1})
    assert 0.25**2 < between.power[0] < 4**2


def test_likelihood_prefers_the_right_material():
    learner = trained(CORK + TILE)
    right = learner.validate([recording("cork", 60, 0.1, seed=50)])
    wrong = learner.validate([recording("cork", 250, 2.0, seed=50)])
    assert right["negative_log_likelihood"] < wrong["negative_log_likelihood"] - 1
