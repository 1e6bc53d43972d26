"""PatchGAN: a discriminator that scores each patch of a picture; and several of them at decreasing resolution.

References
----------
- Isola, P. et al. (2017). Image-to-image translation with conditional adversarial networks. CVPR. Sec. 3.2.2.
- Wang, T.-C. et al. (2018). High-resolution image synthesis and semantic manipulation with conditional GANs.
  CVPR. Sec. 3.2 and 9.
"""

from __future__ import annotations

from collections.abc import Sequence
from itertools import pairwise
from typing import Literal

import torch.nn.functional as F
from torch import Tensor, nn

from tactogram.errors import ParameterError

Norm = Literal["batch", "instance", "none"]

LEAK = 0.2
"""Slope of LeakyReLU below 0. Both publications."""
WIDEST = 8
"""Most channels, in multiples of the first convolution's."""


class PatchDiscriminator(nn.Module):
    """Convolutions of 4 x 4: ``layers`` of stride 2, one of stride 1, and one to a score per patch.

    ``into`` is the number of channels of photograph and picture together. 3 ``layers`` make patches of 70 x 70. The
    first convolution has ``width`` channels; each further one doubles them, up to eight times. ``norm`` follows every
    convolution but the first and the last. ``padding`` is 1 in pix2pix, 2 in pix2pixHD. ``bias`` of normalised
    convolutions is superfluous, but as in pix2pixHD.
    """

    def __init__(
        self,
        *,
        into: int,
        layers: int = 3,
        width: int = 64,
        norm: Norm = "batch",
        padding: int = 2,
        bias: bool = True,
    ) -> None:
        super().__init__()
        if layers < 1:
            raise ParameterError.must("layers", "be >= 1", layers)
        widths = [width * min(2**number, WIDEST) for number in range(layers + 1)]
        self.convs = nn.ModuleList([nn.Conv2d(into, width, 4, stride=2, padding=padding)])
        for number, (fine, coarse) in enumerate(pairwise(widths), start=1):
            stride = 2 if number < layers else 1
            self.convs.append(
                nn.Conv2d(fine, coarse, 4, stride=stride, padding=padding, bias=bias or norm == "none")
            )
        self.norms = nn.ModuleList(_norm(norm, width) for width in widths[1:])
        self.score = nn.Conv2d(widths[-1], 1, 4, stride=1, padding=padding)

    def forward(self, x: Tensor) -> list[Tensor]:
        """Return the features after each convolution, L + 1 of them, and last the score of each patch.

        ``x`` are photograph and picture, joined in the channels: shape (batch, into, row, column).
        """
        features = [F.leaky_relu(self.convs[0](x), LEAK)]  # B, W, R/2, C/2
        for conv, norm in zip(list(self.convs)[1:], self.norms, strict=True):
            features.append(F.leaky_relu(norm(conv(features[-1])), LEAK))  # B, 2 W, R/4, C/4 …
        return [*features, self.score(features[-1])]  # …; B, 1, rows, columns of patches


class MultiScaleDiscriminator(nn.Module):
    """``count`` separate `PatchDiscriminator` of the same settings, each at half the resolution of the last."""

    def __init__(self, *, count: int, **discriminator: object) -> None:
        super().__init__()
        if count < 1:
            raise ParameterError(f"count of discriminators must be >= 1, got {count}")
        self.discriminators = nn.ModuleList(
            PatchDiscriminator(**discriminator)  # type: ignore[arg-type]
            for _ in range(count)
        )

    def forward(self, x: Tensor) -> list[list[Tensor]]:
        """Return the output of each `PatchDiscriminator`, finest resolution first."""
        outputs: list[list[Tensor]] = []
        for discriminator in self.discriminators:
            if outputs:  # as in pix2pixHD: padding does not count in the mean
                x = F.avg_pool2d(x, 3, stride=2, padding=1, count_include_pad=False)  # B, C, R/2, C/2
            outputs.append(discriminator(x))
        return outputs


def scores(outputs: Sequence[Sequence[Tensor]]) -> list[Tensor]:
    """Return the scores in the output of a `MultiScaleDiscriminator`."""
    return [features[-1] for features in outputs]


def _norm(norm: Norm, width: int) -> nn.Module:
    if norm == "batch":
        return nn.BatchNorm2d(width)
    return nn.InstanceNorm2d(width) if norm == "instance" else nn.Identity()
