"""The published generator layer by layer; feature matching in the authors' weights."""

import pytest
import torch
from torch import nn

from tactogram.errors import ParameterError
from tactogram.models.pix2pixhd.config import Config
from tactogram.models.pix2pixhd.learner import discriminator, generator


def test_generator_is_the_published_one():
    """c7s1-64, d128, d256, d512, d1024, R1024 nine times, u512, u256, u128, u64, c7s1-1."""
    shapes = []
    with torch.device("meta"):
        network = generator(Config())
        for layer in network.modules():
            if isinstance(layer, nn.Conv2d | nn.ConvTranspose2d):
                layer.register_forward_hook(lambda module, args, out: shapes.append(tuple(out.shape[1:])))
        network(torch.empty(1, 1, 256, 256))
    down = [(64, 256, 256), (128, 128, 128), (256, 64, 64), (512, 32, 32), (1024, 16, 16)]
    assert shapes == [*down, *[(1024, 16, 16)] * 18, *reversed(down[:-1]), (1, 256, 256)]
    pairs = [(1, 64, 49), (64, 128, 9), (128, 256, 9), (256, 512, 9), (512, 1024, 9), *[(1024, 1024, 9)] * 18]
    pairs += [(1024, 512, 9), (512, 256, 9), (256, 128, 9), (128, 64, 9), (64, 1, 49)]
    assert sum(p.numel() for p in network.parameters()) == sum(a * b * k + b for a, b, k in pairs)


def test_discriminators_have_no_learned_normalisation():
    with torch.device("meta"):
        network = discriminator(Config())
    # convolutions of Table 2 of Neshov et al., without the scales and shifts of batch normalisation
    assert sum(p.numel() for p in network.parameters()) == 3 * (2112 + 131_200 + 524_544 + 2_097_664 + 8193)


def test_small_pictures_are_one_line():
    with pytest.raises(ParameterError, match="multiples of 4, two at least"):
        generator(Config(generator_width=2, downsamplings=2, blocks=1))(torch.rand(1, 1, 10, 12))
