from importlib.util import find_spec

import numpy as np
import pytest
import torch
from torch import nn

from tactogram.errors import ParameterError
from tactogram.evaluation.pictures.attention_maps import (
    attention_maps,
    attention_note,
    last_transposed_convolution,
)

pytestmark = pytest.mark.skipif(find_spec("captum") is None, reason="the extra vision is not installed")


class Generator(nn.Module):
    """Two transposed convolutions and a label that shifts what lies between."""

    def __init__(self):
        super().__init__()
        self.down = nn.Conv2d(1, 4, 4, 2, 1)
        self.first = nn.ConvTranspose2d(4, 6, 3, 1, 1)
        self.last = nn.ConvTranspose2d(6, 1, 4, 2, 1)
        self.shift = nn.Embedding(3, 6)

    def forward(self, photo, label):
        self.maps = torch.relu(self.first(self.down(photo)) + self.shift(label)[..., None, None])
        self.result = self.last(self.maps)
        return torch.tanh(self.result)


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


def test_the_layer_is_the_last_transposed_convolution(generator):
    assert last_transposed_convolution(generator) is generator.last
    with pytest.raises(ParameterError, match=r"need a transposed convolution, Linear has none"):
        last_transposed_convolution(nn.Linear(1, 1))


@pytest.mark.parametrize("activations", ["output", "input"])
def test_it_is_grad_cam_written_out(generator, activations):
    """Weights are the gradients' mean over places; the map is the weighted sum, brought to 0..1."""
    expected = []
    for one, label in zip(PHOTO, LABEL, strict=True):
        picture = generator(one[None], label[None])
        maps = generator.result if activations == "output" else generator.maps
        (gradient,) = torch.autograd.grad(picture.sum(), maps)
        expected.append((gradient.mean((2, 3), keepdim=True) * maps).sum(1)[0].detach())
    expected = min_max(torch.stack(expected))
    if activations == "input":
        expected = torch.nn.functional.interpolate(expected[:, None], (16, 16), mode="bilinear")[:, 0]
        expected = min_max(expected)
    found = attention_maps(generator, PHOTO, LABEL, activations=activations)
    torch.testing.assert_close(found, expected, rtol=1e-4, atol=1e-5)


def test_the_map_of_one_channel_is_the_picture_and_it_is_said(generator):
    with torch.no_grad():
        generator(PHOTO, LABEL)
    found = attention_maps(generator, PHOTO, LABEL)
    same, opposite = (min_max(sign * generator.result[:, 0]) for sign in (1, -1))
    for map_, one, other in zip(found, same, opposite, strict=True):
        assert torch.allclose(map_, one, atol=1e-5) or torch.allclose(map_, other, atol=1e-5)
    assert "one channel" in attention_note(generator)
    assert attention_note(nn.Sequential(nn.ConvTranspose2d(4, 6, 4), nn.Conv2d(6, 1, 3))) == ""


def test_maps_are_in_0_to_1_and_of_the_pictures_size(generator):
    found = attention_maps(generator, PHOTO, LABEL)
    assert found.shape == (2, 16, 16)
    assert found.amin((1, 2)).tolist() == [0, 0]
    assert found.amax((1, 2)).tolist() == [1, 1]


def test_the_label_counts(generator):
    one = attention_maps(generator, PHOTO, LABEL, activations="input")
    other = attention_maps(generator, PHOTO, LABEL.flip(0), activations="input")
    assert not torch.allclose(one, other, atol=1e-3)


def test_a_flat_map_is_0_and_weights_are_left_alone(generator):
    nn.init.zeros_(generator.last.weight)
    before = {name: value.clone() for name, value in generator.state_dict().items()}
    assert not attention_maps(generator, PHOTO, LABEL).any()
    assert all(torch.equal(value, before[name]) for name, value in generator.state_dict().items())
    assert all(parameter.grad is None for parameter in generator.parameters())


def test_bad_input_is_one_line(generator):
    with pytest.raises(ParameterError, match=r"activations must be"):
        attention_maps(generator, PHOTO, LABEL, activations="both")
