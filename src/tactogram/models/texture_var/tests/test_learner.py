"""The texture model: level, fluctuation, conditions and mixes of what it learned, and what it refuses."""

import numpy as np
import pytest
from scipy.signal import lfilter, welch

from tactogram.evaluation.measures import signal_measures
from tactogram.model import Example, SignalKind
from tactogram.models.texture_var import Config, build
from tactogram.signal import Signal

RATE = 1000.0
AXES = ("x", "z")


def recording(name, frequency, level, seconds=2.0, seed=0, pulse_hz=0.0, **condition):
    angle = 2 * np.pi * frequency / RATE
    random = np.random.default_rng(seed)
    x = lfilter(
        [1], [1, -1.8 * np.cos(angle), 0.81], random.standard_normal((2, round(seconds * RATE) + 500))
    )
    x = x[:, 500:] * (
        1 + 0.9 * np.sin(2 * np.pi * pulse_hz * np.arange(x.shape[1] - 500) / RATE + random.random())
    )
    return Example(f"{name}-{seed}", Signal(level * x / x.std(), RATE, "m/s^2", AXES), name, condition)


def trained(examples, **config):
    kind = SignalKind(RATE, "m/s^2", AXES, tuple(sorted({e.material for e in examples})))
    learner = build(Config(**config), kind, seed=0)
    (stage,) = learner.stages(examples)
    (batch,) = learner.batches(stage, examples, seed=0)
    learner.step(stage, batch)
    return learner


CORK = [recording("cork", 60, 0.1, seed=s) for s in range(3)]
TILE = [recording("tile", 250, 2.0, seconds=3.0, seed=s, pulse_hz=4) for s in range(2)]
STROKED = [
    recording("felt", v, v * f / 100, seed=i, speed_mm_s=v, force_n=f)
    for i, (v, f) in enumerate([(50, 0.5), (50, 2), (200, 0.5), (200, 2)])
]


@pytest.fixture(scope="module")
def learner():
    return trained(CORK + TILE)


@pytest.fixture(scope="module")
def felt():
    return trained(STROKED)


def peak(signal):
    frequencies, density = welch(signal.samples, signal.rate, nperseg=256)
    return frequencies[np.argmax(density.sum(axis=0))]


@pytest.mark.parametrize(("name", "level", "frequency"), [("cork", 0.1, 60), ("tile", 2.0, 250)])
def test_level_unit_and_spectrum_are_those_of_the_training_data(learner, name, level, frequency):
    signals = [learner.generate({"material": name}, seconds=5, seed=seed) for seed in range(4)]
    assert (signals[0].unit, signals[0].axes, signals[0].rate) == ("m/s^2", AXES, RATE)
    assert np.mean([s.samples.std() for s in signals]) == pytest.approx(level, rel=0.12)
    assert peak(signals[0]) == pytest.approx(frequency, abs=15)


def test_strength_fluctuates_as_in_the_recordings(learner):
    distance = signal_measures()["envelope_spectrum_distance_db"].function
    unseen = [recording("tile", 250, 2.0, seed=s, pulse_hz=4).signal for s in range(20, 24)]
    generated = {
        m: [learner.generate({"material": m}, seconds=2, seed=s) for s in range(4)] for m in ("tile", "cork")
    }
    assert distance(generated["tile"], unseen) < 2.5 < distance(generated["cork"], unseen)


def test_mix_lies_between_its_materials(learner):
    mixed = learner.generate({"material": {"cork": 0.5, "tile": 0.5}}, seconds=10, seed=0)
    assert 20 * np.log10(mixed.samples.std()) == pytest.approx(10 * np.log10(0.1 * 2.0), abs=2.5)


def test_speed_and_force_decide_what_is_felt(felt):
    slow = felt.generate({"material": "felt", "speed_mm_s": 50, "force_n": 0.5}, seconds=10, seed=0)
    fast = felt.generate({"material": "felt", "speed_mm_s": 200, "force_n": 2}, seconds=10, seed=0)
    assert (peak(slow), peak(fast)) == (pytest.approx(50, abs=25), pytest.approx(200, abs=25))
    assert slow.samples.std() == pytest.approx(0.25, rel=0.15)
    assert fast.samples.std() == pytest.approx(4, rel=0.15)


def test_state_keeps_tones():
    count = np.arange(round(2 * RATE))
    wave = np.cos(2 * np.pi * 60 * np.cumsum(np.exp(0.03 * np.sin(count / 200))) / RATE)
    noise = 0.1 * np.random.default_rng(0).standard_normal((len(AXES), len(count)))
    signal = Signal((wave + noise).astype(np.float32), RATE, "m/s^2", AXES)
    learner = trained([Example("felt 0", signal, "felt", {})])
    state = learner.state()
    loaded = build(Config(), learner.kind, seed=0)
    loaded.load_state(state)
    expected = learner.generate({"material": "felt"}, seed=1).samples
    assert len(loaded.maps[0].models[0].tones.frequency) == 1
    assert np.array_equal(loaded.generate({"material": "felt"}, seed=1).samples, expected)


def test_likelihood_prefers_the_right_fluctuation(learner):
    right = learner.validate([recording("tile", 250, 2.0, seed=50, pulse_hz=4)])
    wrong = learner.validate([recording("tile", 250, 2.0, seed=50, pulse_hz=15)])
    assert right["negative_log_likelihood"] < wrong["negative_log_likelihood"] - 1


def test_a_run_of_before_local_amplitudes_loads_and_generates_without_them(learner):
    old = learner.state()
    for each in old["maps"]:
        for arrays in each["models"]:
            del arrays["local"]
    again = build(Config(), learner.kind, seed=0)
    again.load_state(old)
    now, before = (each.generate({"material": "cork"}, seconds=2, seed=1) for each in (learner, again))
    assert again.maps[0].models[0].local.shape[0] == 0
    assert before.samples.std() == pytest.approx(now.samples.std(), rel=0.05)
    assert not np.array_equal(before.samples, now.samples)
