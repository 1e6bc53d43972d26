"""WaveGAN's discriminator for several axes, with labels and phase shuffle. Tensors are (batch * axis, channel, time).

References
----------
- Donahue, C., McAuley, J. & Puckette, M. (2019). Adversarial audio synthesis. ICLR. Sec. 3.3: phase shuffle.
- Saga, S. et al. (2020). Machine learning-based classification and generation of vibrotactile information. Int. J.
  Adv. Networks and Services 13(3-4), 115-124. Table III.
"""

from __future__ import annotations

from collections.abc import Sequence
from itertools import pairwise

import torch
import torch.nn.functional as F
from torch import Tensor, nn

from tactogram.errors import ParameterError
from tactogram.nn.initial_weights import glorot_linear, padding, strided_conv


class PhaseShuffle(nn.Module):
    """Move each item by a whole number of samples drawn from -``reach`` to ``reach``.

    One draw per item keeps its axes aligned. Ends are filled by reflection. It also shifts in evaluation mode, as in
    the publication. ``reach`` is 2 in Saga et al. 2020, Table IV; 0 shifts nothing.
    """

    def __init__(self, reach: int) -> None:
        super().__init__()
        self.reach = reach

    def forward(self, x: Tensor) -> Tensor:
        """Return ``x``, shape (item, axis, channel, time), moved; draws from torch's own generator."""
        if self.reach == 0:
            return x
        return shift(x, torch.randint(-self.reach, self.reach + 1, (len(x),)))


def shift(x: Tensor, shifts: Tensor) -> Tensor:
    """Return item k of ``x``, (item, axis, channel, time), moved by ``shifts[k]`` samples, later if positive.

    ``y[t] = x[r(t - shift)]`` with ``r`` the reflection about the first and the last sample. ``shifts``, int64,
    (item,), are on the CPU and shorter than ``time``.
    """
    time, most = x.shape[-1], int(shifts.abs().max())
    if most >= time:
        raise ParameterError(f"phase shuffle moves by up to {most} samples, of {time}; shorten it")
    padded = F.pad(x.flatten(1, 2), (most, most), mode="reflect").view(*x.shape[:-1], time + 2 * most)
    return torch.stack(
        [item[..., most - k : most - k + time] for item, k in zip(padded, shifts.tolist(), strict=True)]
    )


class WaveDiscriminator(nn.Module):
    """Signal and label to a score, higher for a recording: the critic of a Wasserstein GAN.

    Each axis is convolved separately, with shared filters; the dense layer sees all of them. The label is joined to the
    signal as constant channels, which are not stored: their part of the first convolution is the same at every sample
    but near the ends.

    ``channels`` are ordered as in the generator, from the last layer to the first; ``points`` are the samples per axis
    before the dense layer; ``phase_shuffle`` is the most samples by which activations move.
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
        self.leak, self.kernel, self.stride = leak, kernel, stride
        size = {"kernel": kernel, "stride": stride}
        widths = tuple(reversed(channels))
        self.first = strided_conv(1 + labels, widths[0], **size)
        self.layers = nn.ModuleList(strided_conv(fine, coarse, **size) for fine, coarse in pairwise(widths))
        self.shuffle = PhaseShuffle(phase_shuffle)
        self.dense = glorot_linear(axes * points * channels[0], 1)

    def forward(self, x: Tensor, label: Tensor) -> Tensor:
        """Return scores: (batch, axis, time) and (batch, C) -> (batch, 1). Sizes are those of Table III."""
        h = self._first(x, label)  # B A, 64, 4096
        for layer in self.layers:
            h = F.leaky_relu(h, self.leak)
            h = self.shuffle(h.view(*x.shape[:2], *h.shape[1:])).flatten(0, 1)
            h = layer(h)  # B A, 2 C, T / 4; the last B A, 1024, 16
        h = F.leaky_relu(h, self.leak).mT.reshape(len(x), -1)  # B, A * 16 * 1024
        score: Tensor = self.dense(h)  # B, 1
        return score

    def _first(self, x: Tensor, label: Tensor) -> Tensor:
        """Return the first convolution of the signal and its label's constant channels."""
        kernel, stride, pad = self.kernel, self.stride, padding(self.kernel, self.stride)
        signal, constant = self.first.weight[:, :1], self.first.weight[:, 1:]
        h = F.conv1d(x.flatten(0, 1)[:, None], signal, self.first.bias, stride, pad)  # B A, 64, T / 4
        # Constant channels contribute the same to every sample but the few whose window exceeds an end.
        edge = -(-kernel // stride)
        time = min(x.shape[2], (2 * edge + 1) * stride)
        ends = F.conv1d(label[:, :, None].expand(-1, -1, time), constant, None, stride, pad)
        if time < x.shape[2]:
            between = ends[..., edge : edge + 1].expand(-1, -1, h.shape[2] - 2 * edge)
            ends = torch.cat((ends[..., :edge], between, ends[..., -edge:]), 2)  # B, 64, T / 4
        return h + ends.repeat_interleave(x.shape[1], 0)
