"""Tables 2 and 3: every layer's shape and number of parameters."""

import pytest
import torch
from torch import nn

from tactogram.models.tactile_image_cgan.config import Config
from tactogram.models.tactile_image_cgan.learner import Discriminator, Generator

WORDS = 10
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


def layers_of(network, given):
    found, x = [], given
    for layer in network.layers:
        x = layer(x)
        kernel = (
            (layer.kernel_size, layer.stride, layer.padding) if hasattr(layer, "kernel_size") else (None,) * 3
        )
        found.append((type(layer).__name__, *kernel, tuple(x.shape[1:]), count(layer)))
    return found


def count(network):
    return sum(p.numel() for p in network.parameters())


def test_every_layer_is_that_of_tables_2_and_3():
    with torch.device("meta"):
        generator, discriminator = Generator(Config(), WORDS), Discriminator(Config(), WORDS)
        assert layers_of(generator, torch.empty(2, 110, 1, 1)) == GENERATOR
        assert layers_of(discriminator, torch.empty(2, 13, 64, 64)) == DISCRIMINATOR
        assert count(generator) == 3_659_587
        assert count(discriminator) == 2_776_769
        assert count(Generator(Config(biases=False), WORDS)) == 3_659_587 - 963
        images = generator(torch.empty(2, 100), torch.empty(2, WORDS))
        assert images.shape == (2, 3, 64, 64)
        assert discriminator(images, torch.empty(2, WORDS))[0].shape == (2,)


def test_leaks_and_initial_weights_are_as_stated():
    torch.manual_seed(0)
    network = Discriminator(Config(widths=(64, 32)), WORDS)
    leaks = {layer.negative_slope for layer in network.layers if isinstance(layer, nn.LeakyReLU)}
    assert leaks == {0.2}
    assert abs(network.layers[0].weight.std().item() - 0.02) < 0.001


def test_scores_are_planes_and_only_images_are_weighted():
    """The discriminator's first layer sees weight times image, then each score over all pixels."""
    network = Discriminator(Config(widths=(4, 4), image_weight=1000), 3)
    seen = []
    network.layers[0].register_forward_pre_hook(lambda layer, given: seen.append(given[0]))
    images, scores = torch.rand(2, 3, 16, 16) * 2 - 1, torch.tensor([[0.0, 0.5, 1.0], [1.0, 0.2, 0.0]])
    network(images, scores)
    torch.testing.assert_close(seen[0][:, :3], 1000 * images)
    torch.testing.assert_close(seen[0][:, 3:], scores[:, :, None, None].expand(2, 3, 16, 16))


SMALL = {"widths": (6, 4), "image_weight": 1.0, "gain": 0.5}


def verdicts(config, images, scores):
    torch.manual_seed(0)
    return Discriminator(config, 3).eval()(images, scores)


def test_a_projection_meets_the_scores_in_an_inner_product():
    """Miyato & Koyama 2018, Eq. 3: the logit is linear in the label, by the image's features."""
    config = Config(**SMALL, label_input="projection")
    torch.manual_seed(0)
    network = Discriminator(config, 3).eval()
    images = torch.rand(2, 3, 16, 16)
    none, one, two, mixed = (
        network(images, torch.tensor([scores] * 2))[0]
        for scores in ((0.0, 0, 0), (1.0, 0, 0), (0, 1.0, 0), (0.25, 0.5, 0))
    )
    torch.testing.assert_close(mixed - none, 0.25 * (one - none) + 0.5 * (two - none))
    features = network.layers[:-1](images).mean((2, 3))
    torch.testing.assert_close(one - none, features @ network.projection.embedding.weight[:, 0])


def test_a_normalised_branch_makes_the_units_of_images_and_scores_irrelevant():
    images, scores = torch.rand(2, 3, 16, 16) * 2 - 1, torch.rand(2, 3)
    config = Config(**SMALL, label_input="normalised")
    plain, _ = verdicts(config, images, scores)
    weighted, _ = verdicts(config.model_copy(update={"image_weight": 1000.0}), images, scores)
    torch.testing.assert_close(weighted, plain, rtol=1e-3, atol=1e-4)
    assert (verdicts(config, images, scores.flip(1))[0] - plain).abs().min() > 1e-3


@pytest.mark.parametrize("label_input", ["projection", "none"])
def test_scores_are_predicted_from_the_image_alone(label_input):
    config = Config(**SMALL, label_input=label_input, regression_weight=1.0)
    images = torch.rand(2, 3, 16, 16)
    one, other = (verdicts(config, images, scores)[1] for scores in (torch.zeros(2, 3), torch.ones(2, 3)))
    torch.testing.assert_close(one, other)
    assert one.shape == (2, 3)
    assert not torch.equal(one, verdicts(config, -images, torch.zeros(2, 3))[1])


@pytest.mark.parametrize(
    ("changes", "message"),
    [
        ({"regression_weight": 1.0}, "must be 0 unless label_input is 'projection' or 'none'"),
        ({"label_input": "none"}, "regression_weight must be > 0 with label_input 'none'"),
    ],
)
def test_a_regression_that_would_see_its_answer_is_refused(changes, message):
    with pytest.raises(ValueError, match=message):
        Config(**changes)
