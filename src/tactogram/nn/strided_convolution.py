"""Strided convolution along time, its transpose, and what both are differentiated to, as matrix products.

Tensors are (item, time, channel): the channels last, as the layers of Saga et al. 2020, Table III, are
written down. A window of ``kernel`` samples is then one run of memory, so that a convolution is a gather of
windows and one matrix product. The transpose is computed in its polyphase form (Vaidyanathan 1993, Sec. 4.3):
a stride-4 transposed convolution of 25 taps is a plain one of 7 taps that gives 4 times the channels, which
lie in memory in just the order of the 4 times as many samples.

``down(x, w)``, ``up(y, w)`` and the weight's gradient are one trilinear form <y, w, x>, each linear in two of
the three: the derivative of any is made of the others. So a gradient of a gradient (WGAN-GP) costs what a
gradient does. On a GPU the vendor's convolutions do the same.

References
----------
- Vaidyanathan, P. P. (1993). Multirate Systems and Filter Banks. Prentice Hall.
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from typing import Any

import torch
import torch.nn.functional as F
from torch import Tensor, nn
from torch.autograd import Function

GATHERED = 1 << 21
"""Numbers of windows gathered at once (8 MiB): they stay in the cache between the gather and the product."""


SPREAD = 12
"""Coarse channels per fine one beyond which spreading products costs less than gathering windows."""
FEW = 512
"""Coarse samples below which putting the weights in order costs more than it saves."""


def down(x: Tensor, weight: Tensor, *, stride: int) -> Tensor:
    """Return the convolution of ``x`` with ``weight`` at every ``stride``-th sample.

    As ``conv1d`` with a padding of ``(kernel - stride + 1) // 2``, so that the time shrinks by ``stride``.

    Parameters
    ----------
    x : Tensor, shape (item, time, fine)
        ``time`` is a multiple of ``stride``.
    weight : Tensor, shape (kernel, fine, coarse)
        ``kernel`` >= ``stride``, and odd if ``stride`` is 1.

    Returns
    -------
    Tensor, shape (item, time / stride, coarse)
    """
    x, weight = _in_one_precision(x, weight)
    if _on_processor(x):
        result: Tensor = _Down.apply(x, weight, stride)  # type: ignore[no-untyped-call]
        return result
    pad = padding(weight.shape[0], stride)
    y = F.conv1d(x.transpose(1, 2), weight.permute(2, 1, 0), stride=stride, padding=pad)
    return y.transpose(1, 2)


def up(y: Tensor, weight: Tensor, *, stride: int) -> Tensor:
    """Return the transposed convolution: the adjoint of `down` in ``x``.

    As ``conv_transpose1d`` with the padding of `down`.

    Parameters
    ----------
    y : Tensor, shape (item, time, coarse)
    weight : Tensor, shape (kernel, fine, coarse)

    Returns
    -------
    Tensor, shape (item, time * stride, fine)
    """
    y, weight = _in_one_precision(y, weight)
    if _on_processor(y):
        result: Tensor = _Up.apply(y, weight, stride)  # type: ignore[no-untyped-call]
        return result
    kernel = weight.shape[0]
    pad = padding(kernel, stride)
    x = F.conv_transpose1d(
        y.transpose(1, 2),
        weight.permute(2, 1, 0),
        stride=stride,
        padding=pad,
        output_padding=stride + 2 * pad - kernel,
    )
    return x.transpose(1, 2)


def padding(kernel: int, stride: int) -> int:
    """Return the zeros before the first sample, 11 for a kernel of 25 and a stride of 4."""
    return (kernel - stride + 1) // 2


def constant_response(values: Tensor, weight: Tensor, *, stride: int, time: int) -> Tensor:
    """Return `down` of channels that are constant over time, without making them.

    They are the same at every sample but the few whose window reaches over an end.

    Parameters
    ----------
    values : Tensor, shape (item, fine)
    weight : Tensor, shape (kernel, fine, coarse)
    stride : int
    time : int
        Samples that the constant channels would have.

    Returns
    -------
    Tensor, shape (item, time / stride, coarse)
    """
    values, weight = _in_one_precision(values, weight)
    kernel, out = weight.shape[0], time // stride
    edge = -(-kernel // stride)
    places = torch.arange(out, device=values.device)
    if out > 2 * edge:
        places = torch.cat((places[: edge + 1], places[-edge:]))  # the ends, and one for all between
    taps = stride * places[:, None] + torch.arange(kernel, device=values.device) - padding(kernel, stride)
    inside = ((taps >= 0) & (taps < time)).to(weight.dtype)  # P, K
    unit = torch.einsum("pk,kfc->fpc", inside, weight)  # F, P, C
    response = (values @ unit.flatten(1)).view(len(values), len(places), -1)  # B, P, C
    if out == len(places):
        return response
    between = response[:, edge : edge + 1].expand(-1, out - 2 * edge, -1)
    return torch.cat((response[:, :edge], between, response[:, -edge:]), 1)


class StridedConv(nn.Module):
    """A convolution along time that shrinks it by ``stride``: (…, time, fine) -> (…, time / stride, coarse).

    All dimensions before the last two are items that share the filters, for example (batch, axis).
    """

    def __init__(self, fine: int, coarse: int, *, kernel: int, stride: int) -> None:
        super().__init__()
        self.stride = stride
        self.weight = nn.Parameter(torch.empty(kernel, fine, coarse))
        self.bias = nn.Parameter(torch.zeros(coarse))
        glorot_uniform_(self.weight, fan_in=kernel * fine, fan_out=kernel * coarse)

    def forward(self, x: Tensor) -> Tensor:
        """Return the convolution: (…, time, fine) -> (…, time / stride, coarse)."""
        y = down(x.flatten(0, -3), self.weight, stride=self.stride)
        return (y + self.bias).view(*x.shape[:-2], *y.shape[1:])


class StridedConvTranspose(nn.Module):
    """A transposed convolution that stretches time: (…, time, coarse) -> (…, time * stride, fine)."""

    def __init__(self, coarse: int, fine: int, *, kernel: int, stride: int) -> None:
        super().__init__()
        self.stride = stride
        self.weight = nn.Parameter(torch.empty(kernel, fine, coarse))
        self.bias = nn.Parameter(torch.zeros(fine))
        glorot_uniform_(self.weight, fan_in=kernel * fine, fan_out=kernel * coarse)

    def forward(self, y: Tensor) -> Tensor:
        """Return the transposed convolution: (…, time, coarse) -> (…, time * stride, fine)."""
        x = up(y.flatten(0, -3), self.weight, stride=self.stride)
        return (x + self.bias).view(*y.shape[:-2], *x.shape[1:])


def glorot_uniform_(weight: Tensor, *, fan_in: int, fan_out: int) -> None:
    """Fill with uniform numbers within the square root of 6 over both fans (Glorot & Bengio 2010, Eq. 16)."""
    bound = math.sqrt(6 / (fan_in + fan_out))
    nn.init.uniform_(weight, -bound, bound)


def glorot_linear(inputs: int, outputs: int) -> nn.Linear:
    """Return a dense layer with the initial weights of TensorFlow: Glorot uniform weights, biases of 0."""
    layer = nn.Linear(inputs, outputs)
    glorot_uniform_(layer.weight, fan_in=inputs, fan_out=outputs)
    nn.init.zeros_(layer.bias)
    return layer


# -- the trilinear form, on the processor --------------------------------------------------------------------


class _Down(Function):
    @staticmethod
    def forward(ctx: Any, x: Tensor, weight: Tensor, stride: int) -> Tensor:
        ctx.save_for_backward(x, weight)
        ctx.stride = stride
        return _down(x.contiguous(), weight, stride)

    @staticmethod
    def backward(ctx: Any, grad: Tensor) -> tuple[Tensor | None, Tensor | None, None]:
        x, weight = ctx.saved_tensors
        gx = _Up.apply(grad, weight, ctx.stride) if ctx.needs_input_grad[0] else None  # type: ignore[no-untyped-call]
        gw = _Weight.apply(x, grad, len(weight), ctx.stride) if ctx.needs_input_grad[1] else None  # type: ignore[no-untyped-call]
        return gx, gw, None


class _Up(Function):
    @staticmethod
    def forward(ctx: Any, y: Tensor, weight: Tensor, stride: int) -> Tensor:
        ctx.save_for_backward(y, weight)
        ctx.stride = stride
        return _up(y.contiguous(), weight, stride)

    @staticmethod
    def backward(ctx: Any, grad: Tensor) -> tuple[Tensor | None, Tensor | None, None]:
        y, weight = ctx.saved_tensors
        gy = _Down.apply(grad, weight, ctx.stride) if ctx.needs_input_grad[0] else None  # type: ignore[no-untyped-call]
        gw = _Weight.apply(grad, y, len(weight), ctx.stride) if ctx.needs_input_grad[1] else None  # type: ignore[no-untyped-call]
        return gy, gw, None


class _Weight(Function):
    @staticmethod
    def forward(ctx: Any, x: Tensor, y: Tensor, kernel: int, stride: int) -> Tensor:
        ctx.save_for_backward(x, y)
        ctx.stride = stride
        return _weight(x.contiguous(), y.contiguous(), kernel, stride)

    @staticmethod
    def backward(ctx: Any, grad: Tensor) -> tuple[Tensor | None, Tensor | None, None, None]:
        x, y = ctx.saved_tensors
        gx = _Up.apply(y, grad, ctx.stride) if ctx.needs_input_grad[0] else None  # type: ignore[no-untyped-call]
        gy = _Down.apply(x, grad, ctx.stride) if ctx.needs_input_grad[1] else None  # type: ignore[no-untyped-call]
        return gx, gy, None, None


def _down(x: Tensor, weight: Tensor, stride: int) -> Tensor:
    kernel, _, coarse = weight.shape
    y = x.new_empty(x.shape[0], x.shape[1] // stride, coarse)
    matrix = weight.reshape(-1, coarse)  # K F, C
    for part, windows in _windows(x, kernel, stride):
        torch.mm(windows, matrix, out=y[part].view(-1, coarse))
    return y


def _weight(x: Tensor, y: Tensor, kernel: int, stride: int) -> Tensor:
    fine, coarse = x.shape[2], y.shape[2]
    weight = x.new_zeros(kernel * fine, coarse)
    for part, windows in _windows(x, kernel, stride):
        weight.addmm_(windows.T, y[part].reshape(-1, coarse))
    return weight.view(kernel, fine, coarse)


def _windows(x: Tensor, kernel: int, stride: int) -> Iterator[tuple[slice, Tensor]]:
    """Yield which items, and their windows side by side: (item * time / stride, kernel * fine)."""
    items, time, fine = x.shape
    left = padding(kernel, stride)
    right = kernel - stride - left
    out, width = time // stride, kernel * fine
    at_once = max(1, GATHERED // (out * width))
    for start in range(0, items, at_once):
        part = slice(start, min(items, start + at_once))
        padded = F.pad(x[part], (0, 0, left, right))
        count = len(padded)
        view = padded.as_strided((count, out, width), (padded.stride(0), stride * fine, 1))
        yield part, view.reshape(count * out, width)


def _up(y: Tensor, weight: Tensor, stride: int) -> Tensor:
    kernel, fine, coarse = weight.shape
    left = padding(kernel, stride)
    before = (kernel - 1 - left) // stride  # blocks of `stride` samples that a coarse sample reaches ahead
    after = (stride - 1 + left) // stride  # … and back
    blocks = before + 1 + after
    lead = stride * after - left
    margin = (0, 0, lead, blocks * stride - kernel - lead)  # makes whole blocks of the taps
    items, time, _ = y.shape
    x = y.new_empty(items, time, stride * fine)
    if coarse > SPREAD * fine or items * time < FEW:
        matrix = weight.reshape(-1, coarse).T  # C, K F
        at_once = max(1, GATHERED // (time * blocks * stride * fine))
        for start in range(0, items, at_once):
            part = y[start : start + at_once]
            products = (part.reshape(-1, coarse) @ matrix).view(-1, kernel, fine)
            products = F.pad(products, margin).view(len(part), time, blocks, stride * fine)
            spread = products.new_zeros(len(part), time + blocks - 1, stride * fine)
            for j in range(blocks):
                spread[:, j : j + time] += products[:, :, j]
            x[start : start + len(part)] = spread[:, after : after + time]
    else:
        taps = F.pad(weight.transpose(1, 2), (0, 0, 0, 0, *margin[2:]))  # K.., C, F
        taps = taps.view(blocks, stride, coarse, fine).flip(0).transpose(1, 2)
        matrix = taps.reshape(blocks * coarse, stride * fine)  # J C, S F
        for portion, windows in _blocks(y, before, after):
            torch.mm(windows, matrix, out=x[portion].view(-1, stride * fine))
    return x.view(items, time * stride, fine)


def _blocks(y: Tensor, before: int, after: int) -> Iterator[tuple[slice, Tensor]]:
    """Yield which items, and for each sample the ``before`` ones before it to the ``after`` ones after it."""
    items, time, coarse = y.shape
    width = (before + 1 + after) * coarse
    at_once = max(1, GATHERED // (time * width))
    for start in range(0, items, at_once):
        part = slice(start, min(items, start + at_once))
        padded = F.pad(y[part], (0, 0, before, after))
        count = len(padded)
        view = padded.as_strided((count, time, width), (padded.stride(0), coarse, 1))
        yield part, view.reshape(count * time, width)


def _on_processor(x: Tensor) -> bool:
    return x.device.type == "cpu"


def _in_one_precision(x: Tensor, weight: Tensor) -> tuple[Tensor, Tensor]:
    """Return both in autocast's precision where it is on, else in the weight's."""
    kind = x.device.type
    dtype = torch.get_autocast_dtype(kind) if torch.is_autocast_enabled(kind) else weight.dtype
    return x.to(dtype), weight.to(dtype)
