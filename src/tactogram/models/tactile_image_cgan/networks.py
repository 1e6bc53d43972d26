"""Generator and discriminator of Tables 2 and 3: DCGAN's, with the scores as further inputs.

Letters in shapes: B batch, Z noise, W words, S rows and columns, C and D channels of the discriminator's first and last
hidden layer.
"""

from __future__ import annotations

from itertools import pairwise

import torch
import torch.nn.functional as F
from torch import Tensor, nn

from tactogram.models.tactile_image_cgan.config import Config
from tactogram.nn.initial_weights import normal_
from tactogram.nn.patch_discriminator import LabelProjection

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
    """Table 3: an image with its scores, each score as a plane, to one number; our variants by `label_input`.

    The final sigmoid of Table 3 is computed with the loss, where it loses no digits: `forward` returns its input.
    """

    def __init__(self, config: Config, words: int) -> None:
        super().__init__()
        first, *_, last = widths = config.widths[::-1]
        self.label_input, self.image_weight = config.label_input, config.image_weight
        inputs = [COLOURS, *widths[:-1]]  # channels
        if self.label_input == "planes":
            inputs[0] += words
        elif self.label_input == "normalised":
            inputs[1] += first
        layers: list[nn.Module] = [
            nn.Conv2d(inputs[0], first, KERNEL, 2, 1, bias=config.biases),
            nn.LeakyReLU(config.leak),
        ]
        for into, out in zip(inputs[1:], widths[1:], strict=True):
            layers += [
                nn.Conv2d(into, out, KERNEL, 2, 1, bias=config.biases),
                nn.BatchNorm2d(out),
                nn.LeakyReLU(config.leak),
            ]
        layers.append(nn.Conv2d(last, 1, KERNEL, 1, 0, bias=config.biases))
        self.layers = nn.Sequential(*layers)
        self.branch = nn.Linear(words, first) if self.label_input == "normalised" else None
        self.projection = LabelProjection(last, words) if self.label_input == "projection" else None
        self.regression = nn.Linear(last, words) if config.regression_weight else None
        normal_(self, config.gain)

    def forward(self, images: Tensor, scores: Tensor) -> tuple[Tensor, Tensor | None]:
        """Return the logit of being real, shape (batch,), and those of the predicted scores (batch, word), if any.

        ``images`` are (batch, 3, size, size), ``scores`` (batch, word). Real and generated images alike are weighted
        here (Sec. II-C).
        """
        x = self.image_weight * images  # B, 3, S, S
        if self.label_input == "planes":
            x = torch.cat((x, scores[:, :, None, None].expand(-1, -1, *x.shape[2:])), 1)  # B, 3 + W, S, S
        x = self.layers[:2](x)  # B, C, S/2, S/2
        if self.branch is not None:
            label = F.layer_norm(self.branch(scores), x.shape[1:2])[:, :, None, None]  # B, C, 1, 1
            x = torch.cat((F.group_norm(x, 1), label.expand_as(x)), 1)  # B, 2 C, S/2, S/2
        x = self.layers[2:-1](x)  # B, D, 4, 4
        logits = self.layers[-1](x).flatten()  # B
        features = x.mean((2, 3))  # B, D
        if self.projection is not None:
            logits = logits + self.projection(features, scores)
        return logits, None if self.regression is None else self.regression(features)
