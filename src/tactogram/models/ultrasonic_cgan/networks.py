"""The networks of Tables 2 and 3."""

from __future__ import annotations

import torch
from torch import Tensor, nn

from tactogram.models.ultrasonic_cgan.config import Config


class Generator(nn.Module):
    """A sensor spectrum and the scores of ``words`` to a display spectrum. Table 2."""

    def __init__(self, config: Config, *, words: int) -> None:
        super().__init__()
        layers: list[nn.Module] = []
        width = config.bins + words
        for layer, wider in enumerate(config.generator_widths, start=1):
            layers += [nn.Linear(width, wider), nn.LeakyReLU(config.leak), nn.BatchNorm1d(wider)]
            if layer in config.dropout_after:
                layers.append(nn.Dropout(config.dropout))
            width = wider
        layers += [nn.Linear(width, config.bins), nn.LeakyReLU(config.leak)]
        self.layers = nn.Sequential(*layers)

    def forward(self, x: Tensor) -> Tensor:
        """Return spectra, (batch, bin), which the last LeakyReLU allows below 0.

        ``x`` are scaled sensor spectra, then scores of 0 to 1: float32, shape (batch, bin + word).
        """
        y: Tensor = self.layers(x)  # B, bins + words -> B, bins
        return y


class Discriminator(nn.Module):
    """Discriminator of a spectrum with its scores: display training data or generated. Table 3.

    The sigmoid of Table 3 is in `probability`; training computes the cross-entropy from its input, the same function
    without the overflow.
    """

    def __init__(self, config: Config, *, words: int) -> None:
        super().__init__()
        layers: list[nn.Module] = []
        width = config.bins + words
        for wider in config.discriminator_widths:
            layers += [nn.Linear(width, wider), nn.LeakyReLU(config.leak)]
            width = wider
        self.layers = nn.Sequential(*layers, nn.Linear(width, 1))

    def forward(self, x: Tensor) -> Tensor:
        """Return the logit of "training data", (batch, 1), of spectra with scores, (batch, bin + word)."""
        y: Tensor = self.layers(x)  # B, bins + words -> B, 1
        return y

    def probability(self, x: Tensor) -> Tensor:
        """Return the output of Table 3, (batch, 1), 0 to 1."""
        return torch.sigmoid(self(x))
