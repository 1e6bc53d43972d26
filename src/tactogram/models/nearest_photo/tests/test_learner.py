"""The baseline: a photograph is taken for what it looks most like, and what comes out was recorded there."""

import numpy as np
import pytest
from scipy.ndimage import gaussian_filter
from scipy.signal import lfilter

from tactogram.errors import ParameterError
from tactogram.model import Example, SignalKind
from tactogram.models.nearest_photo import Config, build
from tactogram.signal import Image, Signal

RATE = 1000.0
LOOKS = {"cork": (4.0, 0.4), "felt": (1.0, 0.4), "tile": (1.0, 0.8)}
"""Simulated: coarseness in pixels, and brightness."""


def photograph(material, seed, size=96):
    grain, bright = LOOKS[material]
    noise = gaussian_filter(np.random.default_rng(seed).standard_normal((size, size)), grain)
    grey = np.clip(bright + 0.08 * noise / noise.std(), 0, 1)
    return Image(np.uint8(255 * np.repeat(grey[..., None], 3, axis=2)))


def example(material, seed):
    noise = np.random.default_rng(seed).standard_normal((1, 1500))
    x = lfilter([1], [1, -0.9 if material == "cork" else 0.5], noise)
    x *= {"cork": 0.1, "felt": 1.0, "tile": 3.0}[material] / x.std()
    pictures = [photograph(material, 10 * seed + k) for k in range(3)]
    return Example(f"{material}-{seed}", Signal(x, RATE, "m/s^2", ("z",)), material, {}, pictures)


TRAINING = [example(name, seed) for name in LOOKS for seed in range(2)]


def trained(examples=TRAINING, **config):
    kind = SignalKind(RATE, "m/s^2", ("z",), tuple(sorted({e.material for e in examples})))
    learner = build(Config(overlap_s=0.02, search_s=0.0, **config), kind, seed=0)
    learner.step(
        *learner.stages(examples), next(learner.batches(learner.stages(examples)[0], examples, seed=0))
    )
    return learner


@pytest.mark.parametrize("material", LOOKS)
def test_a_new_photograph_is_taken_for_its_own_material(material):
    learner = trained()
    assert [learner.material_of(photograph(material, seed)) for seed in range(100, 110)] == [material] * 10


def test_what_comes_out_was_recorded_there():
    signal = trained().generate({"image": photograph("tile", 100)}, seconds=2.0, seed=1)
    recorded = np.hstack([e.signal.samples for e in TRAINING if e.material == "tile"])[0]
    windows = np.lib.stride_tricks.sliding_window_view(recorded, 50)
    matches = [
        np.abs(windows - signal.samples[0, i : i + 50]).max(axis=1).min() < 1e-6 for i in range(0, 1900, 10)
    ]
    assert np.mean(matches) > 0.75
    assert (signal.seconds, signal.unit) == (2.0, "m/s^2")


def test_materials_without_a_photograph_are_named():
    bare = [Example(e.id, e.signal, e.material) if e.material == "felt" else e for e in TRAINING]
    with pytest.raises(ParameterError, match="no photograph of felt"):
        trained(bare)


def test_what_is_no_photograph_is_refused():
    learner = trained()
    with pytest.raises(ParameterError, match="at least 8 x 8 pixels, got 4 x 4"):
        learner.generate({"image": Image(np.zeros((4, 4, 3), np.uint8))}, seed=0)
    with pytest.raises(ParameterError, match="image must be Image"):
        learner.generate({"image": "photo.jpg"}, seed=0)
