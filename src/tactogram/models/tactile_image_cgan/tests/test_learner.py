"""Layers of Tables 2 and 3, labels, weights, noise, and what a collapsed generator is called."""

import numpy as np
import pytest
import torch
from torch import nn

from tactogram.errors import ParameterError
from tactogram.model import ImageExample, ImageKind, ItemRatings
from tactogram.models.tactile_image_cgan.config import Config
from tactogram.models.tactile_image_cgan.learner import Discriminator, Generator, TactileImageLearner
from tactogram.nn.initial_weights import normal_
from tactogram.recipe import Recipe
from tactogram.signal import Image
from tactogram.training.loop import fit

WORDS = ("rough", "sleek")
TINY = Config(widths=(8, 4), noise=5, batch_size=4, updates=3)


def examples(count=6, side=20):
    rng = np.random.default_rng(0)
    return [
        ImageExample(
            f"p{n}",
            (Image(rng.integers(0, 256, (side, side + 4, 3), np.uint8)),),
            f"image{n}",
            ItemRatings(WORDS, ("ann", "bob", "eve", "kim"), rng.integers(0, 2, (4, 2)).astype(float)),
        )
        for n in range(count)
    ]


def learner(config=TINY, data=None):
    items = tuple(sorted(e.item for e in data or examples()))
    return TactileImageLearner(config, ImageKind(WORDS, (0.0, 1.0), items, simulated=True), seed=0)


def test_an_image_nobody_scored_in_a_word_is_refused_by_name():
    data = examples()
    data[2] = ImageExample(
        "p2", data[2].photographs, "image2", ItemRatings(WORDS, ("a",), np.array([[1, np.nan]]))
    )
    with pytest.raises(ParameterError, match="image2: nobody scored it in sleek"):
        learner().stages(data)


@pytest.mark.parametrize(
    ("words", "message"),
    [
        ({"rough": 0.5}, "a score is needed of sleek"),
        ({"rough": 0.5, "sleek": 6.0}, "sleek must be 0 to 1, got 6"),
        ({"rough": 0.5, "sleek": 0.1, "sour": 0.2}, "words must be of rough, sleek, got 'sour'"),
    ],
)
def test_words_that_make_no_sense_are_refused(words, message):
    with pytest.raises(ParameterError, match=message):
        learner().generate({"words": words}, seed=0)


def test_means_of_the_training_images_come_with_the_run():
    data, model, other = examples(), learner(), learner()
    fit(model, data, seed=0)
    other.load_state(model.state())
    for example in data:
        np.testing.assert_allclose(other.rated_means[example.item], example.rated.means, rtol=1e-6)


def test_collapse_is_named():
    model, data = learner(), examples()
    model.stages(data)
    torch.manual_seed(0)
    normal_(model.gan.bare_generator, 0.5)
    first = model.gan.bare_generator.layers[0].weight.data
    first[: TINY.noise] = 0.0
    assert model.image_spread().collapse == "one image per label, whatever the noise"
    first[:] = torch.randn_like(first)
    first[TINY.noise :] = 0.0
    assert model.image_spread().collapse == "the label makes no difference"
    first[:] = 0.0
    assert model.image_spread().collapse == "one image for all labels and noises"
    assert model.validate(data)["collapsed"] == 1.0


def test_an_example_without_a_label_leaves_the_spread_finite():
    data, model = examples(6), learner()
    model.stages(data)
    expected = model.validate(data[1:])
    data[0].rated.scores[:, 0] = np.nan
    assert model.validate(data) == expected


def test_the_four_weights_are_recipes():
    """Hatori et al. 2025, Sec. II-C: "weighting factors … were 1, 1,000, 5,000, and 10,000"."""
    from tactogram import models

    facts = models.find("tactile_image_cgan")
    for weight in (1, 1000, 5000, 10000):
        assert facts.config(Recipe.load(facts.recipe(f"weight-{weight}")).config).image_weight == weight
    assert facts.config(Recipe.load(facts.recipe("paper")).config) == facts.config()
    assert facts.config(Recipe.load(facts.recipe("weight-5000")).config) == facts.config()


SCORES = 10
GENERATOR = [
    ("ConvTranspose2d", (4, 4), (1, 1), (0, 0), (512, 4, 4), 110 * 512 * 16 + 512),
    ("BatchNorm2d", None, None, None, (512, 4, 4), 1024),
    ("LeakyReLU", None, None, None, (512, 4, 4), 0),
    ("ConvTranspose2d", (4, 4), (2, 2), (1, 1), (256, 8, 8), 2_097_408),
    ("BatchNorm2d", None, None, None, (256, 8, 8), 512),
    ("LeakyReLU", None, None, None, (256, 8, 8), 0),
    ("ConvTranspose2d", (4, 4), (2, 2), (1, 1), (128, 16, 16), 524_416),
    ("BatchNorm2d", None, None, None, (128, 16, 16), 256),
    ("LeakyReLU", None, None, None, (128, 16, 16), 0),
    ("ConvTranspose2d", (4, 4), (2, 2), (1, 1), (64, 32, 32), 131_136),
    ("BatchNorm2d", None, None, None, (64, 32, 32), 128),
    ("LeakyReLU", None, None, None, (64, 32, 32), 0),
    ("ConvTranspose2d", (4, 4), (2, 2), (1, 1), (3, 64, 64), 3_075),
    ("Tanh", None, None, None, (3, 64, 64), 0),
]
"""Table 2, and the parameters that it comes to with biases."""
DISCRIMINATOR = [
    ("Conv2d", (4, 4), (2, 2), (1, 1), (64, 32, 32), 13 * 64 * 16 + 64),
    ("LeakyReLU", None, None, None, (64, 32, 32), 0),
    ("Conv2d", (4, 4), (2, 2), (1, 1), (128, 16, 16), 131_200),
    ("BatchNorm2d", None, None, None, (128, 16, 16), 256),
    ("LeakyReLU", None, None, None, (128, 16, 16), 0),
    ("Conv2d", (4, 4), (2, 2), (1, 1), (256, 8, 8), 524_544),
    ("BatchNorm2d", None, None, None, (256, 8, 8), 512),
    ("LeakyReLU", None, None, None, (256, 8, 8), 0),
    ("Conv2d", (4, 4), (2, 2), (1, 1), (512, 4, 4), 2_097_664),
    ("BatchNorm2d", None, None, None, (512, 4, 4), 1024),
    ("LeakyReLU", None, None, None, (512, 4, 4), 0),
    ("Conv2d", (4, 4), (1, 1), (0, 0), (1, 1, 1), 8_193),
]
"""Table 3; the sigmoid is in the loss."""


def layers_of(network, inputs):
    layers, x = [], inputs
    for layer in network.layers:
        x = layer(x)
        kernel = (
            (layer.kernel_size, layer.stride, layer.padding) if hasattr(layer, "kernel_size") else (None,) * 3
        )
        layers.append((type(layer).__name__, *kernel, tuple(x.shape[1:]), count(layer)))
    return layers


def count(network):
    return sum(p.numel() for p in network.parameters())


def test_every_layer_is_that_of_tables_2_and_3():
    with torch.device("meta"):
        generator, discriminator = Generator(Config(), SCORES), Discriminator(Config(), SCORES)
        assert layers_of(generator, torch.empty(2, 110, 1, 1)) == GENERATOR
        assert layers_of(discriminator, torch.empty(2, 13, 64, 64)) == DISCRIMINATOR
        assert count(generator) == 3_659_587
        assert count(discriminator) == 2_776_769
        images = generator(torch.empty(2, 100), torch.empty(2, SCORES))
        assert images.shape == (2, 3, 64, 64)
        assert discriminator(images, torch.empty(2, SCORES)).shape == (2,)


def test_leaks_and_initial_weights_are_as_stated():
    torch.manual_seed(0)
    network = Discriminator(Config(widths=(64, 32)), SCORES)
    leaks = {layer.negative_slope for layer in network.layers if isinstance(layer, nn.LeakyReLU)}
    assert leaks == {0.2}
    assert abs(network.layers[0].weight.std().item() - 0.02) < 0.001


def test_scores_are_planes_and_only_images_are_weighted():
    """The discriminator's first layer sees weight times image, then each score over all pixels."""
    network = Discriminator(Config(widths=(4, 4), image_weight=1000), 3)
    seen = []
    network.layers[0].register_forward_pre_hook(lambda layer, inputs: seen.append(inputs[0]))
    images, scores = torch.rand(2, 3, 16, 16) * 2 - 1, torch.tensor([[0.0, 0.5, 1.0], [1.0, 0.2, 0.0]])
    network(images, scores)
    torch.testing.assert_close(seen[0][:, :3], 1000 * images)
    torch.testing.assert_close(seen[0][:, 3:], scores[:, :, None, None].expand(2, 3, 16, 16))


def test_with_words_weight_images_follow_their_scores():
    """Real images are the lighter the rougher."""
    rng = np.random.default_rng(0)
    shares = np.linspace(0.1, 0.9, 9)
    data = [
        ImageExample(
            f"p{n}",
            (Image(rng.normal(255 * share, 20, (16, 16, 3)).clip(0, 255).astype(np.uint8)),),
            f"image{n}",
            ItemRatings(WORDS, ("ann",), np.array([[share, 0.5]])),
        )
        for n, share in enumerate(shares)
    ]
    steps = []
    for weight in (0.0, 100.0):
        model = learner(TINY.model_copy(update={"updates": 240, "words_weight": weight}), data)
        fit(model, data, seed=0)
        noise = np.repeat(rng.standard_normal((8, TINY.noise)).astype(np.float32), 2, 0)
        scores = np.tile(np.array([[0.2, 0.5], [0.8, 0.5]], np.float32), (8, 1))
        dark, light = model.make(noise, scores).reshape(8, 2, -1).mean((0, 2))
        steps.append(light - dark)
    assert steps[0] < 0.05 < 0.1 < steps[1], steps
