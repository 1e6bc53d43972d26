from functools import cache

import numpy as np
import pytest
import torch
from scipy.signal import lfilter

from tactogram.errors import ParameterError
from tactogram.model import Example, SignalKind, Stage
from tactogram.models.texture_gan import learner as module
from tactogram.models.texture_gan.config import Config
from tactogram.models.texture_gan.learner import TextureGANLearner
from tactogram.signal import Signal
from tactogram.training.loop import fit
from tactogram.validation import validated

RATE = 1000.0
AXES = ("x", "y")
COLOURS = {"cork": [1, -1.5, 0.8], "felt": [1, -0.9], "tile": [1, 0.3, 0.8]}
SMALL = {
    "channels": (12, 8, 4), "batch_size": 4, "latent": 6, "steps": 6, "order": 8, "noise_bands": 2, "sinusoids": 3,
    "moving_average": 0.0, "adversarial": 1.0, "learning_rate": 1e-4, "generator_learning_rate": 1e-4,
}  # fmt: skip


@pytest.fixture(autouse=True)
def few_crops(monkeypatch):
    """Measure the spread of the statistics on few crops: that takes most of so short a training."""
    monkeypatch.setattr(module, "MEASURED", 32)


def config(values=SMALL, **changes):
    return validated(Config, {**values, **changes}, where="test")


def examples(scale=1.0, length=1800, per_class=2, speeds=None):
    """Simulated: noise through a filter per material, each with its own level."""
    data = []
    for number, (name, taps) in enumerate(COLOURS.items()):
        for take in range(per_class):
            noise = np.random.default_rng(10 * number + take).standard_normal((2, length + 200))
            x = 0.3 * (number + 1) * lfilter([1], taps, noise)[:, 200:] + [[0.0], [9.81]]
            condition = {} if speeds is None else {"speed_mm_s": speeds[(number + take) % len(speeds)]}
            data.append(Example(f"{name}-{take}", Signal(scale * x, RATE, "m/s^2", AXES), name, condition))
    return data


def learner(values=SMALL, **changes):
    kind = SignalKind(RATE, "m/s^2", AXES, tuple(COLOURS), simulated=True)
    return TextureGANLearner(config(values, **changes), kind, seed=0)


def trained(values=SMALL, data=None, **changes):
    gan = learner(values, **changes)
    fit(gan, data or examples(), seed=0)
    return gan


@cache
def once():
    """A trained model that no test changes."""
    return trained()


def test_the_average_generates():
    gan = trained(moving_average=0.5)
    assert gan.average is not None
    before = gan.generate({"material": "cork"}, seed=0).samples
    torch.nn.init.zeros_(gan.generator.dense.weight)
    np.testing.assert_array_equal(gan.generate({"material": "cork"}, seed=0).samples, before)
    torch.nn.init.zeros_(gan.average.network.dense.weight)
    assert not np.array_equal(gan.generate({"material": "cork"}, seed=0).samples, before)


def test_half_precision_trains_to_finite_losses():
    from tactogram.recipe import TrainingSettings
    from tactogram.training.device import make_fabric

    gan = learner(SMALL)
    gan.setup(make_fabric(TrainingSettings(precision="bf16-mixed"), accelerator="cpu"))
    seen = []
    fit(gan, examples(), seed=0, on_step=lambda position, stage, losses: seen.append(losses))
    assert len(seen) == 8
    assert np.isfinite(gan.generate({"material": "felt"}, seed=0).samples).all()


def test_whitening_goes_both_ways():
    gan = learner()
    data = examples()
    gan.step(Stage("fit", 1), data)
    signal, index = data[0].signal, 0
    white = gan.whitening.whitened(signal.samples, index)
    weights = np.eye(3)[index]
    rest = np.zeros((2, gan.whitening.settle), np.float32)
    back = gan.whitening.coloured(np.hstack((rest, white)), weights)
    assert len(back) == white.shape[1] == len(signal) - gan.whitening.lead
    # The filters begin at rest, not in the recording's state: that dies away.
    begin = gan.whitening.models[index].order + gan.whitening.rests[index].order
    expected = signal.samples[:, begin : begin + len(back)]
    np.testing.assert_allclose(back.samples[:, 400:], expected[:, 400:], atol=2e-3)
    assert white.var(1) == pytest.approx([1, 1], rel=0.15)


def test_labels_are_learned():
    gan = trained(steps=40, learning_rate=2e-3)
    levels = {name: gan.generate({"material": name}, seconds=3, seed=0).samples[0].std() for name in COLOURS}
    recorded = {e.material: e.signal.samples[0].std() for e in examples()}
    assert all(0.6 < levels[name] / recorded[name] < 1.6 for name in COLOURS)
    assert len({round(float(level), 4) for level in levels.values()}) == 3


def test_latent_decides_the_piece_that_a_signal_begins_with():
    gan, length = once(), config().length
    one, other, by_seed = (
        gan.generate({"material": "cork", **asked}, seconds=3.0, seed=0).samples
        for asked in ({"latent": np.linspace(-1, 1, 12)}, {"latent": np.linspace(1, -1, 12)}, {})
    )
    spread = by_seed.std(1)
    assert (np.abs(one - other)[:, : length // 2].max(1) > 0.05 * spread).all()
    assert (np.abs(one - other)[:, 2 * length :].max(1) < 1e-3 * spread).all()


def test_speed_beside_the_classes():
    data = examples(speeds=(100.0, 200.0))
    gan = trained(SMALL | {"conditions": ("speed_mm_s",)}, data)
    assert gan.generator.dense.in_features == 6 + 3 + 1
    slow, fast, mean, beyond = (
        gan.generate({"material": "cork", "speed_mm_s": speed}, seed=0).samples
        for speed in (100.0, 200.0, 150.0, 500.0)
    )
    assert not np.array_equal(slow, fast)
    np.testing.assert_array_equal(fast, beyond)  # clamped to what was recorded
    np.testing.assert_array_equal(mean, gan.generate({"material": "cork"}, seed=0).samples)
    for speed, message in (
        (-1.0, "be finite and >= 0, got -1"),
        (float("nan"), "be a finite number, mm/s, got nan"),
    ):
        with pytest.raises(ParameterError, match=f"speed_mm_s must {message}"):
            gan.generate({"material": "cork", "speed_mm_s": speed}, seed=0)


def test_a_speed_that_was_not_learned_must_be_the_recordings_own():
    gan = trained(data=examples(speeds=(100.0,)), conditions=())
    plain = gan.generate({"material": "cork"}, seed=0).samples
    np.testing.assert_array_equal(
        gan.generate({"material": "cork", "speed_mm_s": 100.0}, seed=0).samples, plain
    )
    with pytest.raises(
        ParameterError, match="was 100 to 100 in training and is not one of config.conditions"
    ):
        gan.generate({"material": "cork", "speed_mm_s": 200.0}, seed=0)


def test_the_default_of_a_condition_is_the_median_and_bands_are_matched_at_the_recordings_own():
    data = examples(speeds=(100.0, 110.0, 400.0))
    gan = trained(SMALL | {"conditions": ("speed_mm_s",)}, data)
    median, plain = (
        gan.generate({"material": "cork", **asked}, seed=0).samples for asked in ({"speed_mm_s": 110.0}, {})
    )
    np.testing.assert_array_equal(median, plain)
    again = learner(SMALL | {"conditions": ("speed_mm_s",)})
    again.load_state(gan.state())
    np.testing.assert_array_equal(again.generate({"material": "cork"}, seed=0).samples, plain)
    assert again.band_levels.recorded.shape[:2] == (3, 2)


@pytest.mark.parametrize(
    ("speeds", "message"), [(None, "speed_mm_s is unknown"), ((100.0,), None)], ids=["unknown", "constant"]
)
def test_a_condition_that_says_nothing_has_its_place_all_the_same(speeds, message):
    """So that a recipe can ask for it whatever the data."""
    gan = trained(SMALL | {"conditions": ("speed_mm_s", "force_n")}, examples(speeds=speeds))
    assert gan.generator.dense.in_features == 6 + 3 + 2
    plain = gan.generate({"material": "cork"}, seed=0).samples
    if message is None:
        told = gan.generate({"material": "cork", "speed_mm_s": 100.0}, seed=0).samples
        np.testing.assert_array_equal(told, plain)
    else:
        with pytest.raises(ParameterError, match=message):
            gan.generate({"material": "cork", "speed_mm_s": 100.0}, seed=0)


def test_what_cannot_be_learned_is_refused():
    with pytest.raises(ParameterError, match="needs recordings with a material"):
        TextureGANLearner(config(), SignalKind(RATE, "N", ("z",)), seed=0)
    with pytest.raises(ParameterError, match="no training recording of felt, tile"):
        learner().stages(examples()[:2])
    with pytest.raises(ParameterError, match="adversarial and statistics must not both be 0"):
        config(adversarial=0, statistics=0)
    with pytest.raises(ParameterError, match="kernel 3 must not be shorter than stride 4"):
        config(kernel=3)
    wrong = [Example(e.id, Signal(e.signal.samples, 500.0, "m/s^2", AXES), e.material) for e in examples()]
    with pytest.raises(ParameterError, match="signal must be 1000 Hz"):
        fit(learner(), wrong, seed=0)
