"""WaveGAN's discriminator for several axes, with labels. Tensors are (batch, axis, time, channel).

References
----------
- Donahue, C., McAuley, J. & Puckette, M. (2019). Adversarial audio synthesis. ICLR.
- Saga, S. et al. (2020). Machine learning-based classification and generation of vibrotactile information. Int. J.
  Adv. Networks and Services 13(3-4), 115-124. Table III.
"""

from __future__ import annotations

from collections.abc import Sequence
from itertools import pairwise

import torch.nn.functional as F
from torch import Tensor, nn

from tactogram.nn.phase_shuffle import PhaseShuffle
from tactogram.nn.strided_convolution import (
    StridedConv,
    constant_response,
    down,
    glorot_linear,
)


class WaveDiscriminator(nn.Module):
    """Signal and label to a score, higher for a recording: the critic of a Wasserstein GAN.

    Each axis is convolved on its own, with shared filters; the dense layer sees all of them. The label stands
    beside the signal as constant channels, which are not made: their part of the first convolution is the same at
    every sample but near the ends.

    Parameters
    ----------
    channels : sequence of int
        From the last layer to the first, in the order of the generator.
    points : int
        Samples per axis before the dense layer.
    kernel, stride : int
        Along time.
    leak : float
        Slope of LeakyReLU below 0.
    phase_shuffle : int
        Samples by which activations move, at most.
    axes : int
        A.
    labels : int
        C.
    """

    def __init__(
        self,
        *,
        channels: Sequence[int],
        points: int,
        kernel: int,
        stride: int,
        leak: float,
        phase_shuffle: int,
        axes: int,
        labels: int,
    ) -> None:
        super().__init__()
        self.leak = leak
        size = {"kernel": kernel, "stride": stride}
        widths = tuple(reversed(channels))
        self.first = StridedConv(1 + labels, widths[0], **size)
        self.layers = nn.ModuleList(StridedConv(fine, coarse, **size) for fine, coarse in pairwise(widths))
        self.shuffle = PhaseShuffle(phase_shuffle)
        self.dense = glorot_linear(axes * points * channels[0], 1)

    def forward(self, x: Tensor, label: Tensor) -> Tensor:
        """Return scores: (batch, axis, time) and (batch, C) -> (batch, 1). Sizes are those of Table III."""
        h = self._first(x, label)  # B, A, 4096, 64
        for layer in self.layers:
            h = self.shuffle(F.leaky_relu(h, self.leak))
            h = layer(h)  # B, A, T / 4, 2 C; the last B, A, 16, 1024
        h = F.leaky_relu(h, self.leak).flatten(1)  # B, A * 16 * 1024
        score: Tensor = self.dense(h)  # B, 1
        return score

    def _first(self, x: Tensor, label: Tensor) -> Tensor:
        """Return the first convolution of the signal and its label's constant channels."""
        weight, stride = self.first.weight, self.first.stride
        h = down(x.flatten(0, 1)[..., None], weight[:, :1], stride=stride)  # B A, T / 4, 64
        constant = constant_response(label, weight[:, 1:], stride=stride, time=x.shape[2])  # B, T / 4, 64
        return h.view(*x.shape[:2], *h.shape[1:]) + (constant + self.first.bias)[:, None]  # B, A, T / 4, 64
