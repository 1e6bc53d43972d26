"""Generation: length, mixes, guidance, speed, and friction over displacement and along a motion."""

from functools import cache

import numpy as np
import pytest
import torch
from scipy.signal import welch

from tactogram.errors import ParameterError
from tactogram.model import Example, SignalKind
from tactogram.models.texture_flow import Config, build
from tactogram.models.texture_flow.surfaces import SurfaceSpectra
from tactogram.models.texture_flow.tests.test_signal_learner import SMALL, trained
from tactogram.signal import Signal
from tactogram.signal.motion import Motion
from tactogram.training.loop import fit


def test_a_longer_signal_begins_with_the_same_spectrum():
    learner = trained()
    label = learner._label(learner.known.surfaces[0], {}, None)[None]
    short, long = (learner._spectrum(label, length, seed=4) for length in (3000, 6000))
    torch.testing.assert_close(short[..., :64], long[..., :64], atol=1e-3, rtol=1e-3)
    assert np.corrcoef(long[..., :64].flatten(), long[..., 64:128].flatten())[0, 1] < 0.3


def test_weights_are_scaled_to_sum_to_one():
    one, other = (trained().generate({"material": {"cork": w, "tile": 3 * w}}, seed=0) for w in (1, 2))
    np.testing.assert_array_equal(one.samples, other.samples)


def test_the_default_length_is_that_of_the_recordings():
    assert len(trained().generate({"material": "cork"}, seed=0)) == 3000


def test_guidance_of_zero_ignores_speed_and_material():
    free = trained(stroked=True, steps=5, guidance=0.0)
    label = free._label(free.known.surfaces[0], {"speed_mm_s": 50}, None)[None]
    other = free._label(free.known.surfaces[1], {"speed_mm_s": 200}, None)[None]
    torch.testing.assert_close(free._spectrum(label, 500, seed=1), free._spectrum(other, 500, seed=1))
    strong = trained(stroked=True, steps=5, guidance=2.0)
    assert not torch.equal(strong._spectrum(label, 500, seed=1), strong._spectrum(other, 500, seed=1))


def test_speed_is_told_from_its_absence_and_limited_to_what_was_recorded():
    learner = trained(stroked=True, steps=1)
    surface, size = learner.known.surfaces[0], learner.codes.shape[1]
    labels = {
        v: learner._label(surface, {"speed_mm_s": v}, None).tolist() for v in (None, 100.0, 200.0, 900.0)
    }
    assert labels[100.0][size:] == [1, 0, 0, 0, 0, 0, 0, 0, 1, 0]  # the median; no force
    assert labels[None][size:] == [1, 0, 0, 0, 0, 0, 0, 0, 0, 0]
    assert labels[200.0] == labels[900.0]
    assert labels[200.0][size + 6] > 1
    measured = learner._label(surface, {}, {"speed_mm_s": 200.0}).tolist()
    assert measured[size:] == [1, 1, labels[200.0][size + 6], 0, 1, 0, 0, 0, 0, 0]
    with pytest.raises(ParameterError, match="force_n is unknown"):
        learner.generate({"material": "cork", "force_n": 1.0}, seed=0)


def friction(name, seed):
    """Simulated: a coefficient of friction over 60 mm at 20 samples per mm, with a rib every 4 mm or every mm."""
    period, level = {"cork": (4.0, 0.6), "tile": (1.0, 0.2)}[name]
    rng = np.random.default_rng(seed)
    position = np.arange(1200) / 20 + rng.uniform(0, period)
    ripple = np.sin(2 * np.pi * position / period) + 0.3 * rng.standard_normal(1200)
    return Example(
        f"{name}-{seed}", Signal(level + 0.05 * ripple[None], 20.0, "1", ("along",), "displacement"), name
    )


@cache
def rubbed():
    kind = SignalKind(20.0, "1", ("along",), ("cork", "tile"), simulated=True, domain="displacement")
    learner = build(SMALL.model_copy(update={"window_samples": 128, "frames": 8, "steps": 20}), kind, seed=0)
    fit(learner, [friction(name, seed) for name in kind.materials for seed in range(3)], seed=0)
    return learner


def test_friction_over_displacement_keeps_its_level_and_period():
    for name, level, period in (("cork", 0.6, 4.0), ("tile", 0.2, 1.0)):
        signal = rubbed().generate({"material": name}, seed=1)
        assert (signal.domain, signal.rate, signal.unit, len(signal)) == ("displacement", 20.0, "1", 1200)
        assert signal.samples.mean() == pytest.approx(level, abs=0.01)
        assert signal.samples.std() == pytest.approx(0.05 * np.hypot(0.5**0.5, 0.3), rel=0.25)
        frequency, power = welch(signal.samples[0], 20.0, nperseg=256)
        assert frequency[power.argmax()] == pytest.approx(1 / period, abs=0.1)


def test_friction_is_felt_at_a_speed_for_any_time():
    signal = rubbed().generate({"material": "cork", "speed_mm_s": 80.0}, seconds=2.0, seed=1)
    assert (signal.domain, signal.seconds) == ("time", pytest.approx(2.0, abs=1e-3))
    assert signal.samples.mean() == pytest.approx(0.6, abs=0.01)
    frequency, power = welch(signal.samples[0], signal.rate, nperseg=len(signal) // 2)
    assert frequency[power.argmax()] == pytest.approx(80 / 4, abs=1.5)


def test_friction_is_felt_along_a_motion():
    motion = Motion(
        np.array([0.0, 2.0, 2.01, 3.0, 3.01, 4.0]), np.array([80.0, 80.0, 0.0, 0.0, 0.0, 0.0]),
        contact=np.array([1.0, 1, 1, 1, 0, 0]),
    )  # fmt: skip
    signal = rubbed().generate({"material": "cork", "motion": motion}, seed=1)
    assert (signal.domain, signal.seconds) == ("time", pytest.approx(4.0, abs=1e-3))
    frequency, power = welch(signal.samples[0, :8000], signal.rate, nperseg=4000)
    assert frequency[power.argmax()] == pytest.approx(80 / 4, abs=1.5)
    assert np.ptp(signal.samples[0, 8400:11600]) < 1e-3  # a finger at rest feels the friction where it is
    assert signal.samples[0, 10000] == pytest.approx(0.6, abs=0.2)
    assert not signal.samples[0, 12200:].any()
    fast = Motion(np.array([0.0, 0.2]), np.array([0.0, 1200.0]))
    assert rubbed().generate({"material": "cork", "motion": fast}, seed=1).seconds == pytest.approx(
        0.2, abs=1e-3
    )
    with pytest.raises(ParameterError, match="at most the motion's 4, got 5"):
        rubbed().generate({"material": "cork", "motion": motion}, seconds=5, seed=1)
    with pytest.raises(ParameterError, match="motion must be Motion"):
        rubbed().generate({"material": "cork", "motion": "simulated"}, seed=1)


def test_what_friction_cannot_be_is_refused():
    with pytest.raises(ParameterError, match="over displacement need a speed: give speed_mm_s"):
        rubbed().generate({"material": "cork"}, seconds=2.0, seed=1)
    with pytest.raises(ParameterError, match="speed_mm_s must be > 0, got 0"):
        rubbed().generate({"material": "cork", "speed_mm_s": 0}, seed=1)
    with pytest.raises(ParameterError, match=r"256 samples have 128 bins.*config\.window_samples"):
        SurfaceSpectra(Config(widths=(8,) * 8, frames=256), 20.0, "displacement")
