"""What every WaveGAN does: level, length, seams, weights and latents of its signals, and what it refuses."""

from functools import cache
from itertools import islice

import numpy as np
import pytest
from scipy.signal import lfilter, welch
from tests.signal.seams import seam_excess_db

from tactogram import models
from tactogram.errors import ParameterError
from tactogram.model import Example, SignalKind, Stage
from tactogram.recipe import TrainingSettings
from tactogram.signal import Signal
from tactogram.training.device import make_fabric
from tactogram.training.loop import fit
from tactogram.training.seeds import child_rng

RATE = 1000.0
AXES = ("x", "y")
COLOURS = {"cork": [1, -1.5, 0.8], "felt": [1, -0.9], "tile": [1, 0.3, 0.8]}
BOTH = {"channels": (12, 8, 4), "batch_size": 4, "latent": 6, "steps": 6}
SMALL = {
    "stroke_gan": {**BOTH, "repetition": "crossfade"},
    "texture_gan": {
        **BOTH, "order": 8, "noise_bands": 2, "sinusoids": 3, "moving_average": 0.0, "adversarial": 1.0,
        "learning_rate": 1e-4, "generator_learning_rate": 1e-4,
    },
}  # fmt: skip
LATENTS = {"stroke_gan": 6, "texture_gan": 12}
FIRST_HEARD = {"stroke_gan": 0, "texture_gan": 1}
"""The piece that a signal begins with."""

pytestmark = pytest.mark.parametrize("name", SMALL)


@pytest.fixture(autouse=True)
def few_crops(monkeypatch):
    """Measure the spread of the statistics on few crops: that takes most of so short a training."""
    monkeypatch.setattr("tactogram.models.texture_gan.learner.MEASURED", 32)


def examples(scale=1.0):
    """Simulated: noise through a filter per material, each with its own level."""
    found = []
    for number, (material, taps) in enumerate(COLOURS.items()):
        for take in range(2):
            noise = np.random.default_rng(10 * number + take).standard_normal((2, 2000))
            x = 0.3 * (number + 1) * lfilter([1], taps, noise)[:, 200:] + [[0.0], [9.81]]
            found.append(Example(f"{material}-{take}", Signal(scale * x, RATE, "m/s^2", AXES), material))
    return found


def learner(name):
    facts = models.find(name)
    kind = SignalKind(RATE, "m/s^2", AXES, tuple(COLOURS), simulated=True)
    return facts.build(facts.config(SMALL[name]), kind, seed=0)


@cache
def trained(name, scale=1.0):
    """A trained model that no test changes."""
    made = learner(name)
    fit(made, examples(scale), seed=0)
    return made


def test_on_lightning_fabric_as_without_it(name):
    made = learner(name)
    made.setup(make_fabric(TrainingSettings(), accelerator="cpu"))
    fit(made, examples(), seed=0)
    asked = {"material": {"cork": 0.5, "tile": 0.5}}
    expected = trained(name).generate(asked, seed=1).samples
    np.testing.assert_array_equal(made.generate(asked, seed=1).samples, expected)


def test_level_is_kept(name):
    """A hundredth of the signal in is a hundredth out, gravity and all."""
    one, other = (
        made.generate({"material": "cork"}, seconds=0.5, seed=3)
        for made in (trained(name), trained(name, 0.01))
    )
    assert other.unit == "m/s^2"
    np.testing.assert_allclose(
        other.samples, 0.01 * one.samples, rtol=1e-2, atol=1e-3 * np.abs(other.samples).max()
    )
    assert one.samples[1].mean() == pytest.approx(9.81, abs=3)


def test_a_longer_signal_begins_as_the_shorter_one(name):
    made = trained(name)
    asked = {"material": {"cork": 0.4, "tile": 0.6}}
    long = made.generate(asked, seconds=9.3, seed=5)
    assert len(long) == 9300
    for seconds in (0.001, 0.7, 3.0):
        short = made.generate(asked, seconds=seconds, seed=5)
        assert len(short) == round(seconds * RATE)
        np.testing.assert_allclose(short.samples, long.samples[:, : len(short)], rtol=1e-4, atol=1e-5)
    assert len(made.generate(asked, seed=5)) == made.config.length


def test_pieces_are_joined_without_a_seam(name):
    made = trained(name)
    long = made.generate({"material": "tile"}, seconds=40.0, seed=0)
    hop = made.config.length - round(made.config.overlap * made.config.length)
    places = [p + d for p in range(hop, len(long) - 200, hop) for d in range(0, 128, 8)]
    assert seam_excess_db(long, places) < 0.5
    pieces = [made.generate({"material": "tile"}, seed=seed).samples for seed in range(40)]
    _, joined = welch(long.samples, RATE, nperseg=256)
    _, alone = welch(np.array(pieces), RATE, nperseg=256)
    difference = 10 * np.log10(joined[:, 2:] / alone.mean(0)[:, 2:])
    assert np.sqrt((difference**2).mean()) < 1.0
    # In a crossfade, the power is between that of a piece's end and that of the next one's beginning.
    overlap = made.config.length - hop
    ends = np.mean([x[:, -overlap:].var(1) + x[:, :overlap].var(1) for x in pieces], 0) / 2
    starts = range(hop, len(long) - hop, hop)
    faded = np.mean([long.samples[:, s : s + overlap].var(1) for s in starts], 0)
    assert 10 * np.log10(faded / ends) == pytest.approx(0, abs=1.0)


def test_weights_go_in_as_given(name):
    made = trained(name)
    one = made.generate({"material": {"cork": 1.0, "tile": 0.5}}, seed=0)
    scaled = made.generate({"material": {"cork": 2.0, "tile": 1.0}}, seed=0)
    assert not np.array_equal(one.samples, scaled.samples)
    plain = made.generate({"material": "cork"}, seed=0)
    weighted = made.generate({"material": {"cork": 1.0, "tile": 0.0}}, seed=0)
    np.testing.assert_array_equal(plain.samples, weighted.samples)


@pytest.mark.parametrize(
    ("condition", "message"),
    [
        ({}, "condition 'material' is needed"),
        ({"material": "glass"}, "must be one of cork, felt, tile, got 'glass'"),
        ({"material": {"cork": 0, "tile": 0.0}}, "needs a weight > 0, got all 0"),
        ({"material": {"cork": -0.5, "tile": 1}}, "weight of cork must be finite and >= 0, got -0.5"),
        ({"material": {"cork": float("nan")}}, "weight of cork must be finite and >= 0, got nan"),
        ({"material": "cork", "words": {"rough": 1}}, "'words' is not one this model takes"),
        (
            {"material": "cork", "speed_mm_s": 100},
            "'speed_mm_s' is not one this model takes|speed_mm_s is unknown",
        ),
        ({"material": "cork", "latent": np.zeros(5)}, "latent must be (6|12) numbers in -1 to 1, got shape"),
        ({"material": "cork", "latent": 1.5}, "latent must be (6|12) numbers in -1 to 1"),
        ({"material": "cork", "latent": np.nan}, "latent must be (6|12) numbers in -1 to 1"),
    ],
)
def test_broken_conditions_are_one_line(name, condition, message):
    made = learner(name)
    made.step(Stage("fit", 1), examples())
    if np.isscalar(condition.get("latent")):
        condition = condition | {"latent": np.full(LATENTS[name], condition["latent"])}
    with pytest.raises(ParameterError, match=message) as error:
        made.generate(condition, seed=0)
    assert "\n" not in str(error.value)


def test_the_same_seed_is_the_same_noise_under_any_condition(name):
    made = trained(name)
    latent = child_rng(5, "latent", FIRST_HEARD[name]).uniform(-1, 1, LATENTS[name])
    for material in ("cork", "tile"):
        by_seed = made.generate({"material": material}, seed=5).samples
        given = made.generate({"material": material, "latent": latent}, seed=5).samples
        np.testing.assert_array_equal(by_seed, given)


def test_batches_hold_every_recording_once_an_epoch(name):
    made, data = trained(name), examples()
    stage = next(stage for stage in made.stages(data) if stage.steps > 1)
    labels = np.concatenate(
        [b[-1] for b in islice(made.batches(stage, data, seed=7), 3)]
    )  # 12 crops: 2 epochs
    assert labels.sum(0)[:3].tolist() == [4, 4, 4]
