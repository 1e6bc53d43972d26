from importlib.util import find_spec

import numpy as np
import pytest
import torch
from torch import nn

from tactogram.errors import ParameterError
from tactogram.evaluation.pictures.attention_maps import (
    attention_layer,
    attention_maps,
    attention_note,
)

pytestmark = pytest.mark.skipif(find_spec("captum") is None, reason="the extra vision is not installed")


class Generator(nn.Module):
    """Two transposed convolutions and a label that shifts what lies between."""

    def __init__(self):
        super().__init__()
        self.down = nn.Conv2d(1, 4, 4, 2, 1)
        self.first = nn.ConvTranspose2d(4, 6, 3, 1, 1)
        self.last = nn.ConvTranspose2d(6, 1, 4, 2, 1)
        self.shift = nn.Embedding(3, 4)

    def forward(self, photo, label):
        self.maps = self.first(torch.relu(self.down(photo) + self.shift(label)[..., None, None]))
        return torch.tanh(self.last(torch.relu(self.maps)))


@pytest.fixture
def generator():
    with torch.random.fork_rng():
        torch.manual_seed(0)
        return Generator().eval()


PHOTO = torch.from_numpy(np.random.default_rng(0).uniform(-1, 1, (2, 1, 16, 16))).float()
LABEL = torch.tensor([0, 2])


def min_max(x):
    low, high = x.amin((1, 2), keepdim=True), x.amax((1, 2), keepdim=True)
    return (x - low) / (high - low)


def test_the_layer_is_the_last_transposed_convolution_of_several_channels_and_is_named(generator):
    """Neshov et al. 2026, Sec. 4.4: "extracted from the last transposed convolutional layer"."""
    assert attention_layer(generator) is generator.first
    assert attention_note(generator) == "transposed convolution 1 of 2, 6 channels"
    with pytest.raises(ParameterError, match=r"to several channels, ConvTranspose2d has none"):
        attention_layer(nn.ConvTranspose2d(6, 1, 4))


def test_it_is_grad_cam_written_out(generator):
    """Sec. 4.4: "Average pooling over the gradients is used to calculate importance weights"; from 0 to 1."""
    expected = []
    for one, label in zip(PHOTO, LABEL, strict=True):
        picture = generator(one[None], label[None])
        (gradient,) = torch.autograd.grad(picture.sum(), generator.maps)
        expected.append((gradient.mean((2, 3), keepdim=True) * generator.maps).sum(1)[0].detach())
    large = torch.nn.functional.interpolate(torch.stack(expected)[:, None], (16, 16), mode="bilinear")
    found = attention_maps(generator, PHOTO, LABEL)
    torch.testing.assert_close(found, min_max(large[:, 0]), rtol=1e-4, atol=1e-5)


def test_the_map_is_not_the_picture(generator):
    """The map of the last layer, of one channel, would be the picture up to sign and scale."""
    with torch.no_grad():
        picture = torch.atanh(generator(PHOTO, LABEL)[:, 0])
    for map_, one in zip(attention_maps(generator, PHOTO, LABEL), min_max(picture), strict=True):
        assert abs(np.corrcoef(map_.flatten(), one.flatten())[0, 1]) < 0.9


def test_maps_are_in_0_to_1_and_of_the_pictures_size(generator):
    found = attention_maps(generator, PHOTO, LABEL)
    assert found.shape == (2, 16, 16)
    assert found.amin((1, 2)).tolist() == [0, 0]
    assert found.amax((1, 2)).tolist() == [1, 1]


def test_the_label_counts(generator):
    one = attention_maps(generator, PHOTO, LABEL)
    other = attention_maps(generator, PHOTO, LABEL.flip(0))
    assert not torch.allclose(one, other, atol=1e-3)


def test_a_flat_map_is_0_and_weights_are_left_alone(generator):
    nn.init.zeros_(generator.last.weight)
    before = {name: value.clone() for name, value in generator.state_dict().items()}
    assert not attention_maps(generator, PHOTO, LABEL).any()
    assert all(torch.equal(value, before[name]) for name, value in generator.state_dict().items())
    assert all(parameter.grad is None for parameter in generator.parameters())
