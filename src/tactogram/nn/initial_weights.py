"""Weights: initial ones of pix2pix and TensorFlow (Glorot uniform), fixed ones, and their moving average.

References
----------
- Radford, A., Metz, L. & Chintala, S. (2016). Unsupervised representation learning with deep convolutional
  generative adversarial networks. ICLR. Sec. 4.
- Isola, P. et al. (2017). Image-to-image translation with conditional adversarial networks. CVPR. Sec. 6.2.
- Glorot, X. & Bengio, Y. (2010). Understanding the difficulty of training deep feedforward neural networks. AISTATS.
  Eq. 16.
- Yazıcı, Y. et al. (2019). The unusual effectiveness of averaging in GAN training. ICLR.
"""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from copy import deepcopy
from typing import Any, TypeVar

import torch
from torch import nn

from tactogram.model import Saved

Layer = TypeVar("Layer", nn.Linear, nn.Conv1d, nn.ConvTranspose1d)


def normal_(network: nn.Module, gain: float = 0.02) -> None:
    """Draw convolutions from N(0, gain), scales of batch normalisation from N(1, gain); biases become 0.

    Weights of a `ConditionalBatchNorm` and other dense layers are unchanged.
    """
    for module in network.modules():
        if isinstance(module, nn.Conv2d | nn.ConvTranspose2d):
            nn.init.normal_(module.weight, 0, gain)
        elif isinstance(module, nn.BatchNorm2d) and module.affine:
            nn.init.normal_(module.weight, 1, gain)
        else:
            continue
        if module.bias is not None:
            nn.init.zeros_(module.bias)


def padding(kernel: int, stride: int) -> int:
    """Return the zeros before the first sample, 11 for a kernel of 25 and a stride of 4."""
    return (kernel - stride + 1) // 2


def strided_conv(fine: int, coarse: int, *, kernel: int, stride: int) -> nn.Conv1d:
    """Return a convolution that shrinks time: (item, fine, time) -> (item, coarse, time / stride).

    ``time`` is a multiple of ``stride``; ``kernel`` >= ``stride``, and odd if ``stride`` is 1.
    """
    return _glorot(nn.Conv1d(fine, coarse, kernel, stride, padding(kernel, stride)))


def strided_conv_transpose(coarse: int, fine: int, *, kernel: int, stride: int) -> nn.ConvTranspose1d:
    """Return the adjoint of `strided_conv` but for its bias: (item, coarse, time) -> (item, fine, time * stride)."""
    pad = padding(kernel, stride)
    return _glorot(
        nn.ConvTranspose1d(coarse, fine, kernel, stride, pad, output_padding=stride + 2 * pad - kernel)
    )


def glorot_linear(inputs: int, outputs: int) -> nn.Linear:
    """Return a dense layer with these initial weights."""
    return _glorot(nn.Linear(inputs, outputs))


def _glorot(layer: Layer) -> Layer:
    nn.init.xavier_uniform_(layer.weight)
    if layer.bias is not None:
        nn.init.zeros_(layer.bias)
    return layer


def bare(network: Any) -> Any:
    """Return a network without Fabric's wrapper, if any: one process may use it while the others wait."""
    return getattr(network, "module", network)


def for_export(network: Any) -> Any:
    """Return a copy of a network in evaluation mode, on the CPU and without Fabric's wrapper."""
    return deepcopy(bare(network)).cpu().eval().requires_grad_(False)


@contextmanager
def fixed(network: nn.Module) -> Iterator[None]:
    """Skip the gradients of the weights of ``network`` while another one is updated.

    Afterwards all weights need gradients: not for networks with a frozen part (`tactogram.nn.trunks`).
    """
    network.requires_grad_(False)
    try:
        yield
    finally:
        network.requires_grad_(True)


class MovingAverage(Saved):
    """A copy of a network, not yet wrapped by Fabric, with the average of its weights.

    ``decay`` is the share of the average that remains at each update, 0 to 1. It starts lower, ``(1 + n) / (10 + n)``
    at update n, so that the initial weights soon lose influence.
    """

    saved = ("updates", "weights=network")

    def __init__(self, network: nn.Module, decay: float) -> None:
        self.network = deepcopy(network).requires_grad_(False)
        self.decay, self.updates = decay, 0

    @torch.no_grad()
    def update(self, network: nn.Module) -> None:
        """Move the average towards the weights of ``network``."""
        self.updates += 1
        decay = min(self.decay, (1 + self.updates) / (10 + self.updates))
        now = network.state_dict()
        for name, average in self.network.state_dict().items():
            average.lerp_(now[name], 1 - decay)
