import math

import pytest
import torch

from tactogram.nn import glorot_linear, strided_conv, strided_conv_transpose

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
