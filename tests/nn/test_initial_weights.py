"""Moving averages, initial weights, and strided convolutions."""

import math

import pytest
import torch
from torch import nn

from tactogram.nn import MovingAverage, glorot_linear, strided_conv, strided_conv_transpose
from tactogram.nn.initial_weights import normal_


def constant(value):
    network = torch.nn.Linear(1, 1, bias=False)
    torch.nn.init.constant_(network.weight, value)
    return network


def test_average_by_hand():
    network = constant(0.0)
    average = MovingAverage(network, 0.5)
    expected = 0.0
    for update, value in enumerate((1.0, 1.0, 5.0, 5.0, 5.0, 5.0, 5.0, 5.0, 5.0, 5.0), start=1):
        torch.nn.init.constant_(network.weight, value)
        average.update(network)
        decay = min(0.5, (1 + update) / (10 + update))
        expected = decay * expected + (1 - decay) * value
    assert decay == 0.5
    assert average.network.weight.item() == pytest.approx(expected)


def test_state_is_restored():
    one, other = MovingAverage(constant(1.0), 0.9), MovingAverage(constant(7.0), 0.9)
    one.update(constant(2.0))
    other.load_state(one.state())
    for average in (one, other):
        average.update(constant(3.0))
    torch.testing.assert_close(other.network.weight, one.network.weight)
    assert other.updates == 2


def test_initial_weights_are_normal_with_the_given_gain():
    """Neshov et al. 2026, Sec. 3.2: "initialized using a normal distribution with a gain of 0.02"."""
    torch.manual_seed(0)
    network = nn.Sequential(nn.Conv2d(8, 64, 4), nn.BatchNorm2d(64), nn.ConvTranspose2d(64, 8, 4))
    normal_(network, 0.02)
    assert network[0].weight.std().item() == pytest.approx(0.02, rel=0.05)
    assert network[2].weight.mean().item() == pytest.approx(0, abs=0.001)
    assert network[1].weight.mean().item() == pytest.approx(1, abs=0.01)
    assert not network[0].bias.any()


SHAPES = [(25, 4, 3, 5), (25, 4, 1, 30), (5, 2, 3, 4), (5, 1, 2, 3), (4, 4, 2, 3), (6, 3, 2, 3)]


@pytest.mark.parametrize(("kernel", "stride", "fine", "coarse"), SHAPES)
def test_the_transposed_convolution_is_the_adjoint_of_the_convolution(kernel, stride, fine, coarse):
    size = {"kernel": kernel, "stride": stride}
    down, up = strided_conv(fine, coarse, **size), strided_conv_transpose(coarse, fine, **size)
    up.load_state_dict({"weight": down.weight, "bias": torch.zeros(fine)})
    x, y = torch.randn(2, fine, 8 * stride), torch.randn(2, coarse, 8)
    assert up(y).shape == x.shape
    torch.testing.assert_close((down(x) * y).sum(), (x * up(y)).sum(), atol=1e-3, rtol=1e-4)


def test_a_kernel_of_25_and_a_stride_of_4_reach_11_samples_back_and_13_ahead():
    layer = strided_conv(1, 1, kernel=25, stride=4)
    with torch.no_grad():
        layer.weight.copy_(torch.arange(25.0).view(1, 1, -1))
    moved = layer(torch.eye(64)[:, None])[:, 0, 8]  # of the ninth result, at sample 32
    assert moved[32 - 11 : 32 + 14].tolist() == list(range(25))
    assert not moved[: 32 - 11].any()
    assert not moved[32 + 14 :].any()


def test_initial_weights_are_glorot_s_and_biases_0():
    for layer, fans in (
        (strided_conv(16, 64, kernel=25, stride=4), 25 * (16 + 64)),
        (strided_conv_transpose(64, 16, kernel=25, stride=4), 25 * (16 + 64)),
        (glorot_linear(300, 200), 500),
    ):
        bound = math.sqrt(6 / fans)
        assert bound * 0.99 < layer.weight.abs().max().item() <= bound
        assert layer.weight.std().item() == pytest.approx(bound / math.sqrt(3), rel=0.03)
        assert not layer.bias.any()
