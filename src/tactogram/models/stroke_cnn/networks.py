"""The 13-layer network of Saga et al., Sec. II-B and Figure 3."""

from __future__ import annotations

import torch
from torch import Tensor, nn

from tactogram.models.stroke_cnn.config import Config


class StrokeCNN(nn.Module):
    """Six 1 x 5 convolutions with three poolings, two dense layers, the output.

    Batch normalisation comes *after* each activation, as in the paper. The axes of the input share their filters and
    meet in the first dense layer.
    """

    def __init__(self, config: Config, *, axes: int, classes: int) -> None:
        super().__init__()
        layers: list[nn.Module] = []
        width = 1
        for number, filters in enumerate(config.filters):
            padding = (0, config.kernel // 2)
            layers += [nn.Conv2d(width, filters, (1, config.kernel), padding=padding), nn.ReLU()]
            layers += [nn.BatchNorm2d(filters)]
            width = filters
            if number % 2:
                layers += [nn.MaxPool2d((1, config.pool))]
        self.convolutions = nn.Sequential(*layers)
        first, second = config.dense
        self.dense = nn.Sequential(
            nn.Linear(width * axes * config.points(), first), nn.ReLU(), nn.BatchNorm1d(first),
            nn.Linear(first, second), nn.ReLU(), nn.BatchNorm1d(second),
        )  # fmt: skip
        self.output = nn.Sequential(nn.Dropout(config.dropout), nn.Linear(second, classes))

    def embed(self, x: Tensor) -> Tensor:
        """Return the last hidden layer: (window, axis, time) -> (window, feature)."""
        # Convolutions with 1 x 5 filters run a fifth faster with the channels of their input last in memory.
        h = self.convolutions[0](x[:, None]).contiguous(memory_format=torch.channels_last)
        h = self.convolutions[1:](h)  # B, 64, A, T -> B, F, A, T / 8
        embedded: Tensor = self.dense(h.flatten(1))  # B, D
        return embedded

    def forward(self, x: Tensor) -> Tensor:
        """Return the logits: (window, axis, time) -> (window, class)."""
        logits: Tensor = self.output(self.embed(x))  # B, C
        return logits


class Standardised(nn.Module):
    """The network on windows in the signals' unit, with probabilities; ``mean`` and ``scale`` are (axis, 1)."""

    mean: Tensor
    scale: Tensor

    def __init__(self, network: StrokeCNN, mean: Tensor, scale: Tensor) -> None:
        super().__init__()
        self.network = network
        self.register_buffer("mean", mean)
        self.register_buffer("scale", scale)

    def forward(self, x: Tensor) -> tuple[Tensor, Tensor]:
        """Return probabilities, (window, class), and embeddings, (window, feature), of (window, axis, time)."""
        embedded = self.network.embed((x - self.mean) / self.scale)
        return self.network.output(embedded).softmax(1), embedded
