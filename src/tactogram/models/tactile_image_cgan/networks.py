"""Generator and discriminator of Tables 2 and 3: DCGAN's, with the scores as further inputs.

Letters in shapes: B batch, Z noise, W words, S rows and columns.
"""

from __future__ import annotations

from itertools import pairwise

import torch
from torch import Tensor, nn

from tactogram.models.tactile_image_cgan.config import Config
from tactogram.nn.initial_weights import normal_

KERNEL = 4
"""Rows and columns of every kernel. Tables 2 and 3."""
COLOURS = 3
"""Red, green, blue."""


class Generator(nn.Module):
    """Table 2: noise and scores to an image in -1 to 1."""

    def __init__(self, config: Config, words: int) -> None:
        super().__init__()
        first, *_, last = config.widths
        layers: list[nn.Module] = [
            nn.ConvTranspose2d(config.noise + words, first, KERNEL, 1, 0, bias=config.biases)
        ]
        for into, out in pairwise(config.widths):
            layers += [
                nn.BatchNorm2d(into),
                nn.LeakyReLU(config.leak),
                nn.ConvTranspose2d(into, out, KERNEL, 2, 1, bias=config.biases),
            ]
        layers += [
            nn.BatchNorm2d(last),
            nn.LeakyReLU(config.leak),
            nn.ConvTranspose2d(last, COLOURS, KERNEL, 2, 1, bias=config.biases),
            nn.Tanh(),
        ]
        self.layers = nn.Sequential(*layers)
        normal_(self, config.gain)

    def forward(self, noise: Tensor, scores: Tensor) -> Tensor:
        """Return images, -1 to 1: (batch, noise) and scores (batch, word), 0 to 1 -> (batch, 3, size, size)."""
        inputs = torch.cat((noise, scores), 1)[:, :, None, None]  # B, Z + W, 1, 1
        images: Tensor = self.layers(inputs)  # B, 3, S, S
        return images


class Discriminator(nn.Module):
    """Table 3: an image with its scores, each score as a plane, to one number.

    The final sigmoid of Table 3 is computed with the loss, where it loses no digits: `forward` returns its input.
    """

    def __init__(self, config: Config, words: int) -> None:
        super().__init__()
        first, *_ = widths = config.widths[::-1]
        layers: list[nn.Module] = [
            nn.Conv2d(COLOURS + words, first, KERNEL, 2, 1, bias=config.biases),
            nn.LeakyReLU(config.leak),
        ]
        for into, out in pairwise(widths):
            layers += [
                nn.Conv2d(into, out, KERNEL, 2, 1, bias=config.biases),
                nn.BatchNorm2d(out),
                nn.LeakyReLU(config.leak),
            ]
        layers.append(nn.Conv2d(widths[-1], 1, KERNEL, 1, 0, bias=config.biases))
        self.layers = nn.Sequential(*layers)
        self.image_weight = config.image_weight
        normal_(self, config.gain)

    def forward(self, images: Tensor, scores: Tensor) -> Tensor:
        """Return the logit of being real, shape (batch,), of images (batch, 3, size, size) and scores (batch, word).

        Real and generated images alike are weighted here (Sec. II-C).
        """
        planes = scores[:, :, None, None].expand(-1, -1, *images.shape[2:])  # B, W, S, S
        outputs: Tensor = self.layers(torch.cat((self.image_weight * images, planes), 1))  # B, 1, 1, 1
        return outputs.flatten()
