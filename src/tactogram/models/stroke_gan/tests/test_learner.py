from functools import cache

import numpy as np
import pytest
import torch
from scipy.signal import lfilter

from tactogram.errors import ParameterError
from tactogram.model import Example, SignalKind, Stage
from tactogram.models.stroke_gan.config import Config
from tactogram.models.stroke_gan.learner import Generator, StrokeGANLearner
from tactogram.recipe import Recipe
from tactogram.signal import Signal
from tactogram.training.loop import fit
from tactogram.validation import validated

RATE = 1000.0
AXES = ("x", "y")
COLOURS = {"cork": [1, -1.5, 0.8], "felt": [1, -0.9], "tile": [1, 0.3, 0.8]}
SMALL = {"channels": (12, 8, 4), "batch_size": 4, "latent": 6, "steps": 6, "repetition": "crossfade"}


def config(values=SMALL, **changes):
    return validated(Config, {**values, **changes}, where="test")


def examples(scale=1.0, length=1800, per_class=2):
    """Simulated: noise through a filter per material, each with its own level."""
    data = []
    for number, (name, taps) in enumerate(COLOURS.items()):
        for take in range(per_class):
            noise = np.random.default_rng(10 * number + take).standard_normal((2, length + 200))
            x = 0.3 * (number + 1) * lfilter([1], taps, noise)[:, 200:] + [[0.0], [9.81]]
            data.append(Example(f"{name}-{take}", Signal(scale * x, RATE, "m/s^2", AXES), name))
    return data


def learner(values=SMALL, **changes):
    kind = SignalKind(RATE, "m/s^2", AXES, tuple(COLOURS), simulated=True)
    return StrokeGANLearner(config(values, **changes), kind, seed=0)


def trained(values=SMALL, data=None, **changes):
    gan = learner(values, **changes)
    fit(gan, data or examples(), seed=0)
    return gan


@cache
def once():
    """A trained model that no test changes."""
    return trained()


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
    """Saga et al., Sec. III-B: "The learning amount was 40 epochs"; what an epoch is, is not stated."""
    from tactogram.models import find

    recording = Signal(np.zeros((1, 4000)), RATE, "m/s^2", ("x",))
    kind = SignalKind(RATE, "m/s^2", ("x",), ("tile",), simulated=True)
    values = Recipe.load(find("stroke_gan").recipe(recipe)).config
    gan = StrokeGANLearner(config(values, channels=(4, 2, 2, 2, 2)), kind, seed=0)
    stage = gan.stages([Example(str(take), recording, "tile") for take in range(180)])[-1]
    assert stage.total_updates == {"critic": critic, "generator": 2 * critic}


@pytest.mark.parametrize(("recipe", "expected"), [("paper", "DGG"), ("variant-critic2", "DDG")])
def test_the_order_of_updates_is_that_of_the_recipe(recipe, expected):
    from tactogram.models import find

    values = Recipe.load(find("stroke_gan").recipe(recipe)).config
    gan = learner(SMALL | values)
    data = examples()
    stage = gan.stages(data)[-1]
    gan.step(Stage("fit", 1), data)
    order = []
    for letter, optimiser in zip("GD", gan.optimisers, strict=True):
        optimiser.register_step_post_hook(lambda *_, letter=letter: order.append(letter))
    gan.step(stage, next(gan.batches(stage, data, seed=0)))
    assert "".join(order) == expected


def test_nothing_is_clipped_unless_asked_for_and_then_said():
    gan = learner()
    figures = gan.step(Stage("fit", 1), examples())
    assert figures["clipped_share"] == 0
    assert set(figures) == {"scale_x", "scale_y", "clipped_share"}
    largest = max(np.abs(e.signal.samples[0] - gan.scaling.offset[0]).max() for e in examples())
    assert figures["scale_x"] == pytest.approx(largest)
    figures = learner(within_range=0.99).step(Stage("fit", 1), examples())
    assert figures["scale_x"] < largest
    assert 0.005 < figures["clipped_share"] <= 0.01


def test_scaling_goes_both_ways():
    gan, (first, *_) = learner(), examples()
    gan.step(Stage("fit", 1), examples())
    scaled = gan.scaling.scaled(first.signal.samples)
    assert np.abs(scaled).max() <= 1
    np.testing.assert_allclose(gan.scaling.unscaled(scaled).samples, first.signal.samples, atol=1e-5)


def test_labels_are_learned():
    gan = trained(steps=40, learning_rate=2e-3)
    levels = {name: gan.generate({"material": name}, seconds=3, seed=0).samples[0].std() for name in COLOURS}
    assert len({round(float(level), 4) for level in levels.values()}) == 3


def test_latent_decides_the_first_piece():
    gan = once()
    latent = np.linspace(-1, 1, 6)
    asked = {"material": "cork", "latent": latent}
    one, other = (gan.generate(asked, seconds=2.5, seed=seed).samples for seed in (0, 1))
    hop = gan.config.length - round(gan.config.overlap * gan.config.length)
    np.testing.assert_array_equal(one[:, :hop], other[:, :hop])
    assert not np.array_equal(one[:, hop:], other[:, hop:])


def test_what_cannot_be_learned_is_refused():
    with pytest.raises(ParameterError, match="needs recordings with a material"):
        StrokeGANLearner(config(), SignalKind(RATE, "N", ("z",)), seed=0)
    with pytest.raises(ParameterError, match="no training recording of felt, tile"):
        learner().stages(examples()[:2])
    wrong = [Example(e.id, Signal(e.signal.samples, 500.0, "m/s^2", AXES), e.material) for e in examples()]
    with pytest.raises(ParameterError, match="signal must be 1000 Hz"):
        fit(learner(), wrong, seed=0)


NARROW = Config(channels=(16, 8, 4, 2, 1))  # the published layout, a 64th of its channels
THREE, CLASSES = 3, 9


def as_in_table_iii(y):
    """The shape as (batch, axis, time, channel); a dense layer's as it is."""
    return tuple(y.shape if y.dim() == 2 else y.reshape(-1, THREE, *y.shape[-2:]).mT.shape)


def shapes_of(network, *inputs):
    """The output shape of each convolution and dense layer, in order."""
    seen = []
    for name, module in network.named_modules():
        if name and not isinstance(module, torch.nn.ModuleList):
            module.register_forward_hook(lambda m, x, y: seen.append(as_in_table_iii(y)))
    with torch.no_grad():
        out = network(*inputs)
    return seen, tuple(out.shape)


def one_hot(index=0, count=1):
    return torch.eye(CLASSES)[index].expand(count, -1)


def test_generator_has_the_shapes_of_table_iii():
    network = Generator(NARROW, axes=THREE, labels=CLASSES)
    seen, out = shapes_of(network, torch.zeros(2, 100), one_hot(count=2))
    assert seen == [
        (2, 49152 // 64),
        (2, 3, 64, 512 // 64), (2, 3, 256, 256 // 64), (2, 3, 1024, 128 // 64), (2, 3, 4096, 64 // 64),
        (2, 3, 16384, 1),
    ]  # fmt: skip
    assert out == (2, 3, 16384)


def test_discriminator_has_the_shapes_of_table_iii_with_its_typing_error_mended():
    """Table III says (n, 64, 4096, 64) and so on where the axes must stand: (n, 3, 4096, 64)."""
    network = NARROW.discriminator(axes=THREE, labels=CLASSES)
    seen, out = shapes_of(network, torch.zeros(2, 3, 16384), one_hot(count=2))
    shuffled = [
        (2, 3, 4096, 64 // 64),
        (2, 3, 1024, 128 // 64),
        (2, 3, 256, 256 // 64),
        (2, 3, 64, 512 // 64),
    ]
    convolved = [*shuffled[1:], (2, 3, 16, 1024 // 64)]
    assert seen == [s for pair in zip(shuffled, convolved, strict=True) for s in pair] + [(2, 1)]
    assert out == (2, 1)


def test_published_networks_have_the_weights_of_table_iii():
    config = Config()
    assert config.length == 16384
    with torch.device("meta"):
        generator = Generator(config, axes=THREE, labels=CLASSES)
        critic = config.discriminator(axes=THREE, labels=CLASSES)
    kernels = [(512, 1024), (256, 512), (128, 256), (64, 128)]
    shared = sum(25 * a * b for a, b in kernels)
    by_hand = (100 + 9) * 49152 + 49152 + shared + 25 * 1 * 64 + (512 + 256 + 128 + 64 + 1)
    assert sum(p.numel() for p in generator.parameters()) == by_hand == 22_817_281
    by_hand = 25 * (1 + 9) * 64 + shared + (64 + 128 + 256 + 512 + 1024) + 49152 + 1
    assert sum(p.numel() for p in critic.parameters()) == by_hand == 17_475_137
    assert tuple(generator.layers[0].weight.shape) == (1024, 512, 25)
    assert tuple(critic.first.weight.shape) == (64, 1 + 9, 25)


def test_activations_and_their_places():
    """Leaky before each transposed convolution, tanh at the end; negative slopes of 0.2."""
    network = Generator(NARROW, axes=1, labels=1)
    seen = []
    network.layers[0].register_forward_pre_hook(lambda m, x: seen.append(x[0]))
    network.dense.register_forward_hook(lambda m, x, y: seen.append(y))
    out = network(torch.rand(1, 100), torch.ones(1, 1))
    before, after = seen[0].view(1, 16, 16).mT, seen[1]
    torch.testing.assert_close(after, torch.where(before > 0, before, 0.2 * before))
    assert out.abs().max() < 1


def test_axes_share_their_filters_and_are_not_convolved_together():
    """Saga et al., Sec. III-A: "each axis was set to be convolved independently in the time direction"."""
    network = Generator(NARROW, axes=3, labels=1)
    latent, label = torch.rand(2, 100), torch.ones(2, 1)
    whole = network(latent, label)
    with torch.no_grad():
        network.dense.weight.view(3, 16 * 16, -1)[0] = 0  # the first axis begins with nothing
    without = network(latent, label)
    torch.testing.assert_close(without[:, 1:], whole[:, 1:])
    assert not torch.allclose(without[:, 0], whole[:, 0])
    with torch.no_grad():
        network.dense.weight.view(3, 16 * 16, -1)[:] = network.dense.weight.view(3, 16 * 16, -1)[1].clone()
    same = network(latent, label)
    torch.testing.assert_close(same[:, 0], same[:, 2])


def test_label_channels_are_constant_channels_beside_the_signal():
    """Saga et al., Sec. III-A: "we used one-hot vectors"; Table III, "(n, 3, 16384, 1+C)"."""
    network = NARROW.discriminator(axes=2, labels=CLASSES)
    with torch.no_grad():
        network.first.bias.uniform_(-1, 1)
    x, label = torch.randn(3, 2, 16384), torch.rand(3, CLASSES)
    channels = label.repeat_interleave(2, 0)[:, :, None].expand(-1, -1, 16384)
    plain = network.first(torch.cat((x.view(6, 1, -1), channels), 1))  # B A, 1 + C, T
    torch.testing.assert_close(network._first(x, label), plain, atol=1e-4, rtol=1e-4)


def test_half_a_label_is_half_its_part_of_the_first_layer():
    """What mixing rests on: the label enters linearly."""
    network = Generator(NARROW, axes=1, labels=CLASSES)
    latent, zero = torch.rand(1, 100), torch.zeros(1, CLASSES)

    def first(label):
        return network.dense(torch.cat((latent, label), 1)) - network.dense(torch.cat((latent, zero), 1))

    both = 0.3 * first(one_hot(0)) + 0.7 * first(one_hot(4))
    torch.testing.assert_close(first(0.3 * one_hot(0) + 0.7 * one_hot(4)), both, atol=1e-5, rtol=1e-4)


def test_whitening_takes_the_mean_spectrum_out_and_puts_it_back():
    data = examples(length=6000)
    plain, white = learner().scaling, learner(whitening=24).scaling
    for scaling in (plain, white):
        scaling.fit(data)

    def unevenness_db(scaling):
        seen = [scaling.scaled(scaling.whitened(example.signal).samples) for example in data]
        powers = np.mean([np.abs(np.fft.rfft(x)) ** 2 for x in seen], axis=0)[:, 1:]
        return np.ptp(10 * np.log10(powers.reshape(2, 60, -1).mean(2)))

    assert unevenness_db(plain) > 18
    assert unevenness_db(white) < 4
    signal = data[0].signal
    restored = white.unscaled(white.scaled(white.whitened(signal).samples))
    np.testing.assert_allclose(restored.samples[:, 200:], signal.samples[:, 200:], atol=2e-3)


def test_a_whitened_run_is_the_same_once_loaded():
    gan, again = trained(whitening=8), learner(whitening=8)
    again.load_state(gan.state())
    one, two = (each.generate({"material": "cork"}, seconds=1, seed=3) for each in (gan, again))
    np.testing.assert_array_equal(one.samples, two.samples)
    assert one.samples.std(axis=1).min() > 0
