from functools import cache
from itertools import islice

import numpy as np
import pytest
import torch
from scipy.signal import lfilter, welch

from tactogram.errors import ParameterError
from tactogram.model import Example, SignalKind, Stage
from tactogram.models.stroke_gan.config import TEXTURE_GAN, Config
from tactogram.models.stroke_gan.learner import StrokeGANLearner
from tactogram.recipe import Recipe
from tactogram.signal import Signal
from tactogram.signal.joining import seam_excess_db
from tactogram.training.loop import fit
from tactogram.training.seeds import child_rng
from tactogram.validation import validated

RATE = 1000.0
AXES = ("x", "y")
COLOURS = {"cork": [1, -1.5, 0.8], "felt": [1, -0.9], "tile": [1, 0.3, 0.8]}
SMALL = {"channels": (12, 8, 4), "batch_size": 4, "latent": 6, "steps": 6, "repetition": "crossfade"}


def config(values=SMALL, **changes):
    return validated(Config, {**values, **changes}, where="test")


def examples(scale=1.0, length=1800, per_class=2):
    """Simulated: noise through a filter per material, each with its own level."""
    found = []
    for number, (name, taps) in enumerate(COLOURS.items()):
        for take in range(per_class):
            noise = np.random.default_rng(10 * number + take).standard_normal((2, length + 200))
            x = 0.3 * (number + 1) * lfilter([1], taps, noise)[:, 200:] + [[0.0], [9.81]]
            found.append(Example(f"{name}-{take}", Signal(scale * x, RATE, "m/s^2", AXES), name))
    return found


def learner(values=SMALL, **changes):
    kind = SignalKind(RATE, "m/s^2", AXES, tuple(COLOURS), simulated=True)
    return StrokeGANLearner(config(values, **changes), kind, seed=0)


def trained(values=SMALL, data=None, **changes):
    made = learner(values, **changes)
    fit(made, data or examples(), seed=0)
    return made


@cache
def once():
    """A trained model that no test changes."""
    return trained()


# -- training -----------------------------------------------------------------------------------------------


def test_an_epoch_crops_each_recording_once_and_a_longer_one_more_often():
    data = [*examples(length=1800), *examples(length=500)]  # a length is 1024 samples
    assert config().length == 1024
    long = [*data[:6], *(Example(f"long {i}", examples(length=3000)[i].signal, "cork") for i in range(2))]
    assert learner(steps=None, epochs=40).stages(data)[-1].steps == 40 * 12 / 4
    assert learner(steps=None, epochs=40).stages(long)[-1].steps == 40 * (6 + 2 * 2) / 4
    assert learner(steps=None, epochs=3, critic_updates=2).stages(data)[-1].steps == np.ceil(3 * 12 / 8)


@pytest.mark.parametrize(
    ("recipe", "critic"), [("paper", 113), ("variant-slices", 225), ("variant-all-crops", 2_656_913)]
)
def test_forty_epochs_are_as_many_updates_as_stated(recipe, critic):
    from tactogram.models import find

    recording = Signal(np.zeros((1, 4000)), RATE, "m/s^2", ("x",))
    kind = SignalKind(RATE, "m/s^2", ("x",), ("tile",), simulated=True)
    values = Recipe.load(find("stroke_gan").recipe(recipe)).config
    made = StrokeGANLearner(config(values, channels=(4, 2, 2, 2, 2)), kind, seed=0)
    stage = made.stages([Example(str(take), recording, "tile") for take in range(180)])[-1]
    assert stage.total_updates == {"critic": critic, "generator": 2 * critic}


@pytest.mark.parametrize(("recipe", "expected"), [("paper", "DGG"), ("variant-critic2", "DDG")])
def test_the_order_of_updates_is_that_of_the_recipe(recipe, expected):
    from tactogram.models import find

    values = Recipe.load(find("stroke_gan").recipe(recipe)).config
    made = learner(SMALL | values)
    data = examples()
    stage = made.stages(data)[-1]
    made.step(Stage("fit", 1), data)
    order = []
    for letter, optimiser in zip("GD", made.optimisers, strict=True):
        optimiser.register_step_post_hook(lambda *_, letter=letter: order.append(letter))
    made.step(stage, next(made.batches(stage, data, seed=0)))
    assert "".join(order) == expected


def test_an_update_of_one_network_leaves_the_other_alone():
    made = learner()
    data = examples()
    made.step(Stage("fit", 1), data)
    x, label = next(made.batches(made.stages(data)[-1], data, seed=0))
    real, label = torch.from_numpy(x), torch.from_numpy(label)
    for network, other, update in (
        (made.discriminator, made.generator, lambda: made.update_discriminator(real, label)),
        (made.generator, made.discriminator, lambda: made.update_generator(label)),
    ):
        before = [p.clone() for p in network.parameters()], [p.clone() for p in other.parameters()]
        update()
        assert not all(map(torch.equal, before[0], network.parameters()))
        assert all(map(torch.equal, before[1], other.parameters()))
        assert all(p.requires_grad for p in other.parameters())


def test_adam_and_its_numbers_are_the_papers():
    made = StrokeGANLearner(Config(channels=(4, 4)), SignalKind(RATE, "m/s^2", AXES, ("a",)), seed=0)
    for optimiser in made.optimisers:
        assert isinstance(optimiser, torch.optim.Adam)
        assert optimiser.defaults["lr"] == 1e-4
        assert optimiser.defaults["betas"] == (0.5, 0.9)
    assert (made.config.batch_size, made.config.penalty, made.config.epochs) == (64, 10, 40)


def test_on_lightning_fabric_as_without_it():
    from tactogram.recipe import TrainingSettings
    from tactogram.training.device import make_fabric

    made = learner()
    made.setup(make_fabric(TrainingSettings(), accelerator="cpu"))
    fit(made, examples(), seed=0)
    asked = {"material": {"cork": 0.5, "tile": 0.5}}
    expected = once().generate(asked, seed=1).samples
    np.testing.assert_array_equal(made.generate(asked, seed=1).samples, expected)


# -- level, unit, length --------------------------------------------------------------------------------------


def test_level_is_kept():
    """A hundredth of the signal in is a hundredth out, gravity and all."""
    models = (once(), trained(SMALL, examples(0.01)))
    one, other = (made.generate({"material": "cork"}, seconds=0.5, seed=3) for made in models)
    assert other.unit == "m/s^2"
    np.testing.assert_allclose(
        other.samples, 0.01 * one.samples, rtol=1e-2, atol=1e-3 * np.abs(other.samples).max()
    )
    assert one.samples[1].mean() == pytest.approx(9.81, abs=3)


def test_a_longer_signal_begins_as_the_shorter_one():
    made = once()
    asked = {"material": {"cork": 0.4, "tile": 0.6}}
    long = made.generate(asked, seconds=9.3, seed=5)
    assert len(long) == 9300
    for seconds in (0.001, 0.7, 3.0):
        short = made.generate(asked, seconds=seconds, seed=5)
        assert len(short) == round(seconds * RATE)
        np.testing.assert_allclose(short.samples, long.samples[:, : len(short)], rtol=1e-4, atol=1e-5)
    assert len(made.generate(asked, seed=5)) == made.config.length


def test_pieces_are_joined_without_a_seam():
    made = once()
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


def test_nothing_is_clipped_unless_asked_for_and_then_said():
    made = learner()
    figures = made.step(Stage("fit", 1), examples())
    assert figures["clipped_share"] == 0
    assert set(figures) == {"scale_x", "scale_y", "clipped_share"}
    largest = max(np.abs(e.signal.samples[0] - made.scaling.offset[0]).max() for e in examples())
    assert figures["scale_x"] == pytest.approx(largest)
    figures = learner(within_range=0.99).step(Stage("fit", 1), examples())
    assert figures["scale_x"] < largest
    assert 0.005 < figures["clipped_share"] <= 0.01


def test_scaling_goes_both_ways():
    made, (one, *_) = learner(), examples()
    made.step(Stage("fit", 1), examples())
    scaled = made.scaling.scaled(one.signal.samples)
    assert np.abs(scaled).max() <= 1
    np.testing.assert_allclose(made.scaling.unscaled(scaled).samples, one.signal.samples, atol=1e-5)


# -- labels -----------------------------------------------------------------------------------------------------


def test_labels_are_learned():
    made = trained(steps=40, learning_rate=2e-3)
    levels = {name: made.generate({"material": name}, seconds=3, seed=0).samples[0].std() for name in COLOURS}
    assert len({round(float(level), 4) for level in levels.values()}) == 3


def test_weights_go_in_as_given():
    made = once()
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
        ({"material": "cork", "speed_mm_s": 100}, "'speed_mm_s' is not one this model takes"),
        ({"material": "cork", "latent": np.zeros(5)}, "latent must be 6 numbers in -1 to 1, got shape"),
        ({"material": "cork", "latent": np.full(6, 1.5)}, "latent must be 6 numbers in -1 to 1"),
        ({"material": "cork", "latent": np.full(6, np.nan)}, "latent must be 6 numbers in -1 to 1"),
    ],
)
def test_broken_conditions_are_one_line(condition, message):
    made = learner()
    made.step(Stage("fit", 1), examples())
    with pytest.raises(ParameterError, match=message) as error:
        made.generate(condition, seed=0)
    assert "\n" not in str(error.value)


def test_latent_decides_the_first_piece():
    made = once()
    latent = np.linspace(-1, 1, 6)
    asked = {"material": "cork", "latent": latent}
    one, other = (made.generate(asked, seconds=2.5, seed=seed).samples for seed in (0, 1))
    hop = made.config.length - round(made.config.overlap * made.config.length)
    np.testing.assert_array_equal(one[:, :hop], other[:, :hop])
    assert not np.array_equal(one[:, hop:], other[:, hop:])


def test_the_same_seed_is_the_same_noise_under_any_condition():
    made = once()
    latent = child_rng(5, "latent", 0).uniform(-1, 1, made.config.latent)
    for material in ("cork", "tile"):
        by_seed = made.generate({"material": material}, seed=5).samples
        given = made.generate({"material": material, "latent": latent}, seed=5).samples
        np.testing.assert_array_equal(by_seed, given)


def test_what_cannot_be_learned_is_refused():
    with pytest.raises(ParameterError, match="needs recordings with a material"):
        StrokeGANLearner(config(), SignalKind(RATE, "N", ("z",)), seed=0)
    with pytest.raises(ParameterError, match="no training recording of felt, tile"):
        learner().stages(examples()[:2])
    with pytest.raises(ParameterError, match="kernel 3 must not be shorter than stride 4"):
        config(kernel=3)
    wrong = [Example(e.id, Signal(e.signal.samples, 500.0, "m/s^2", AXES), e.material) for e in examples()]
    with pytest.raises(ParameterError, match="signal must be 1000 Hz"):
        fit(learner(), wrong, seed=0)


def test_batches_hold_every_recording_once_an_epoch():
    made, data = once(), examples()
    stage = made.stages(data)[-1]
    labels = np.concatenate(
        [b[1] for b in islice(made.batches(stage, data, seed=7), 3)]
    )  # 12 crops: 2 epochs
    assert labels.sum(0).tolist() == [4, 4, 4]


# -- what was part of this model ----------------------------------------------------------------------------------


@pytest.mark.parametrize("name", TEXTURE_GAN)
def test_a_key_of_texture_gan_names_that_model(name):
    """Runs and recipes from before the two were separate."""
    from tactogram.models import find

    with pytest.raises(ParameterError, match=f"{name} belongs to the model texture_gan") as error:
        find("stroke_gan").config({"steps": 500, name: 1})
    assert "\n" not in str(error.value)


def test_a_state_from_before_texture_gan_was_separate_loads():
    made, other = once(), learner()
    former = {"conditions": {}, "spread": torch.ones(0), "bands": None, "average": None}
    other.load_state(made.state() | former)
    one, again = (m.generate({"material": "cork"}, seed=0).samples for m in (made, other))
    np.testing.assert_array_equal(one, again)
