import pytest
import torch
import torch.nn.functional as F
from torch.autograd import gradcheck, gradgradcheck

from tactogram.nn import StridedConv, StridedConvTranspose
from tactogram.nn import strided_convolution as module
from tactogram.nn.strided_convolution import constant_response, down, padding, up

SHAPES = [(25, 4, 3, 5), (25, 4, 1, 30), (5, 2, 3, 4), (5, 1, 2, 3), (4, 4, 2, 3), (6, 3, 2, 3)]
shapes = pytest.mark.parametrize(("kernel", "stride", "fine", "coarse"), SHAPES)


def drawn(*shape, seed=0):
    return torch.randn(shape, dtype=torch.double, generator=torch.Generator().manual_seed(seed))


def plain_down(x, w, stride):
    kernel = w.permute(2, 1, 0)[:, :, None]  # C, F, 1, K
    y = F.conv2d(
        x.transpose(1, 2)[:, :, None], kernel, stride=(1, stride), padding=(0, padding(len(w), stride))
    )
    return y[:, :, 0].transpose(1, 2)


def plain_up(y, w, stride):
    pad = padding(len(w), stride)
    kernel, more = w.permute(2, 1, 0)[:, :, None], stride + 2 * pad - len(w)
    x = F.conv_transpose2d(
        y.transpose(1, 2)[:, :, None], kernel, stride=(1, stride), padding=(0, pad), output_padding=(0, more)
    )
    return x[:, :, 0].transpose(1, 2)


@shapes
def test_down_is_a_strided_convolution(kernel, stride, fine, coarse):
    x, w = drawn(3, 8 * stride, fine), drawn(kernel, fine, coarse, seed=1)
    torch.testing.assert_close(down(x, w, stride=stride), plain_down(x, w, stride))


@shapes
@pytest.mark.parametrize("few", [0, 512])
def test_up_is_a_transposed_convolution(kernel, stride, fine, coarse, few, monkeypatch):
    monkeypatch.setattr(module, "FEW", few)
    y, w = drawn(3, 8, coarse), drawn(kernel, fine, coarse, seed=1)
    torch.testing.assert_close(up(y, w, stride=stride), plain_up(y, w, stride))


@shapes
def test_up_is_the_adjoint_of_down(kernel, stride, fine, coarse):
    x, y, w = drawn(2, 8 * stride, fine), drawn(2, 8, coarse, seed=2), drawn(kernel, fine, coarse, seed=1)
    torch.testing.assert_close((down(x, w, stride=stride) * y).sum(), (x * up(y, w, stride=stride)).sum())


@pytest.mark.parametrize("operation", [module._Down, module._Up, module._Weight])
@pytest.mark.parametrize("shape", [(25, 4, 2, 3), (5, 2, 1, 14)])
def test_first_and_second_derivatives(operation, shape):
    kernel, stride, fine, coarse = shape
    x, y, w = drawn(2, 4 * stride, fine), drawn(2, 4, coarse), drawn(kernel, fine, coarse, seed=1)
    rest = {module._Down: (x, w, stride), module._Up: (y, w, stride), module._Weight: (x, y, kernel, stride)}
    inputs = [v.requires_grad_() if torch.is_tensor(v) else v for v in rest[operation]]
    assert gradcheck(operation.apply, inputs)
    assert gradgradcheck(operation.apply, inputs)


def test_a_batch_is_its_items_in_whatever_portions(monkeypatch):
    x, y, w = drawn(5, 64, 3), drawn(5, 16, 4), drawn(25, 3, 4, seed=1)
    whole = down(x, w, stride=4), up(y, w, stride=4), module._weight(x, y, 25, 4)
    monkeypatch.setattr(module, "GATHERED", 1)
    torch.testing.assert_close((down(x, w, stride=4), up(y, w, stride=4), module._weight(x, y, 25, 4)), whole)


@pytest.mark.parametrize("time", [4, 8, 24, 28, 400])
def test_constant_channels_need_not_be_made(time):
    values, w = drawn(3, 5), drawn(25, 5, 2, seed=1)
    made = down(values[:, None].expand(-1, time, -1), w, stride=4)
    torch.testing.assert_close(constant_response(values, w, stride=4, time=time), made)


def test_layers_share_their_filters_over_all_items():
    conv, transposed = StridedConv(3, 5, kernel=25, stride=4), StridedConvTranspose(5, 3, kernel=25, stride=4)
    x, y = torch.randn(2, 4, 32, 3), torch.randn(2, 4, 8, 5)
    assert conv(x).shape == (2, 4, 8, 5)
    assert transposed(y).shape == (2, 4, 32, 3)
    torch.testing.assert_close(conv(x)[1, 2], conv(x[1, 2][None])[0])
    torch.testing.assert_close(transposed(y)[1, 2], transposed(y[1, 2][None])[0])


def test_layers_hold_the_weights_of_pytorchs_own():
    """One set of numbers, in the order (kernel, fine, coarse) in place of (coarse, fine, 1, kernel)."""
    conv, transposed = StridedConv(3, 5, kernel=25, stride=4), StridedConvTranspose(5, 3, kernel=25, stride=4)
    plain = torch.nn.Conv2d(3, 5, (1, 25), stride=(1, 4), padding=(0, 11))
    plain_transposed = torch.nn.ConvTranspose2d(
        5, 3, (1, 25), stride=(1, 4), padding=(0, 11), output_padding=(0, 1)
    )
    with torch.no_grad():
        for ours, theirs in ((conv, plain), (transposed, plain_transposed)):
            theirs.weight.copy_(ours.weight.permute(2, 1, 0)[:, :, None])
            theirs.bias.copy_(ours.bias.uniform_(-1, 1))
    x, y = torch.randn(2, 4, 32, 3), torch.randn(2, 4, 8, 5)  # B, A, T, C
    torch.testing.assert_close(conv(x), plain(x.permute(0, 3, 1, 2)).permute(0, 2, 3, 1))
    torch.testing.assert_close(transposed(y), plain_transposed(y.permute(0, 3, 1, 2)).permute(0, 2, 3, 1))


def test_the_way_of_other_devices_gives_the_same(monkeypatch):
    """On a GPU the vendor's convolutions are called; here the same calls on the processor."""
    x, y, w = drawn(2, 32, 3).float(), drawn(2, 8, 4).float(), drawn(25, 3, 4, seed=1).float()
    ours = down(x, w, stride=4), up(y, w, stride=4)
    monkeypatch.setattr(module, "_on_processor", lambda tensor: False)
    torch.testing.assert_close((down(x, w, stride=4), up(y, w, stride=4)), ours, atol=1e-4, rtol=1e-4)


def test_autocast_computes_in_its_precision():
    x, w = torch.randn(2, 32, 3), torch.randn(25, 3, 4, requires_grad=True)
    with torch.autocast("cpu", torch.bfloat16):
        y = down(x, w, stride=4)
    assert y.dtype == torch.bfloat16
    y.float().square().sum().backward()
    assert w.grad.dtype == torch.float32
    torch.testing.assert_close(y.float(), down(x, w, stride=4), atol=0.5, rtol=0.05)
