"""U-Net: an encoder and a decoder of equal depth, with a skip connection at each stage.

References
----------
- Ronneberger, O., Fischer, P. & Brox, T. (2015). U-Net: convolutional networks for biomedical image
  segmentation. MICCAI, 234-241.
- Isola, P., Zhu, J.-Y., Zhou, T. & Efros, A. A. (2017). Image-to-image translation with conditional adversarial
  networks. CVPR. Sec. 3.2.1 and 6.1.1.
"""

from __future__ import annotations

from collections.abc import Sequence
from itertools import pairwise

import torch
import torch.nn.functional as F
from torch import Tensor, nn

from tactogram.errors import ParameterError

LEAK = 0.2
"""Slope of LeakyReLU below 0 in the encoder. Isola et al., Sec. 6.1.1."""


class UNet(nn.Module):
    """The generator of pix2pix; each stage halves or doubles rows and columns by a 4 x 4 kernel.

    Convolutions but the last have no bias, as batch normalisation follows; the first has neither. ``widths`` are the
    channels after each stage of the encoder, finest first; rows and columns of the input are multiples of 2 **
    len(widths). ``bottleneck`` maps the coarsest features and the condition of `forward` to features of the same shape.
    ``dropout`` stages of the decoder, coarsest first, drop half of their values in training, and if `noise` is on.
    """

    def __init__(
        self,
        *,
        into: int,
        out: int,
        widths: Sequence[int],
        bottleneck: nn.Module | None = None,
        dropout: int = 0,
    ) -> None:
        super().__init__()
        if len(widths) < 2 or not 0 <= dropout < len(widths):
            raise ParameterError.must("widths", f"be >= 2 stages, {dropout} of them with dropout", widths)
        self.scale, self.dropout, self.noise = 2 ** len(widths), dropout, False
        self.down = nn.ModuleList(
            nn.Conv2d(fine, coarse, 4, stride=2, padding=1, bias=False)
            for fine, coarse in pairwise((into, *widths))
        )
        self.down_norms = nn.ModuleList(nn.BatchNorm2d(width) for width in widths[1:-1])
        self.bottleneck = bottleneck
        # A stage takes twice its width, from below and from the skip connection; the coarsest takes it once.
        self.up = nn.ModuleList(
            nn.ConvTranspose2d(
                coarse * (1 if number == 0 else 2), fine, 4, stride=2, padding=1, bias=fine_is_out
            )
            for number, (coarse, fine, fine_is_out) in enumerate(_up_stages(widths, out))
        )
        self.up_norms = nn.ModuleList(nn.BatchNorm2d(width) for width in reversed(widths[:-1]))

    def check_size(self, rows: int, columns: int) -> None:
        """Refuse pictures that cannot be halved at every stage."""
        if rows % self.scale or columns % self.scale:
            raise ParameterError(
                f"rows and columns must be multiples of {self.scale} for {len(self.down)} stages, "
                f"got {(rows, columns)}"
            )

    def forward(self, photo: Tensor, condition: Tensor | None = None) -> Tensor:
        """Return the picture of ``photo``: (batch, into, row, column) -> (batch, out, row, column), both -1 to 1.

        ``condition`` is passed to the bottleneck, e.g. a label.
        """
        self.check_size(photo.shape[-2], photo.shape[-1])
        skips = [self.down[0](photo)]  # B, W0, R/2, C/2
        for conv, norm in zip(list(self.down)[1:-1], self.down_norms, strict=True):
            skips.append(norm(conv(F.leaky_relu(skips[-1], LEAK))))  # B, Wk, R/2^k, C/2^k
        h = self.down[-1](F.leaky_relu(skips[-1], LEAK))  # B, Wn, R/2^n, C/2^n
        if self.bottleneck is not None:
            h = self.bottleneck(h, condition)
        for number, (conv, norm) in enumerate(zip(list(self.up)[:-1], self.up_norms, strict=True)):
            h = norm(conv(F.relu(h)))  # B, Wk, twice the rows and columns
            if number < self.dropout:
                h = F.dropout(h, 0.5, training=self.training or self.noise)
            h = torch.cat((skips.pop(), h), 1)  # B, 2 Wk, …
        return torch.tanh(self.up[-1](F.relu(h)))  # B, out, R, C


def _up_stages(widths: Sequence[int], out: int) -> list[tuple[int, int, bool]]:
    """Return input channels, output channels and whether it is the last, of each stage of the decoder."""
    pairs = list(pairwise((*reversed(widths), out)))
    return [(coarse, fine, number == len(pairs) - 1) for number, (coarse, fine) in enumerate(pairs)]
