"""Generator and critic of FrictGAN (Sec. 3.1, Fig. 2). Maps are (batch, channel, frequency, displacement)."""

from __future__ import annotations

import math

import torch
import torch.nn.functional as F
from torch import Tensor, nn

from tactogram.models.frictgan.config import Config, Size, column_strides, decoder_sizes, encoder_sizes
from tactogram.nn.initial_weights import normal_

LEAST = 0.01
"""Share of a frequency's mean above which ``scale = "log"`` is logarithmic."""


class Generator(nn.Module):
    """Photograph and noise to ``axes`` spectrograms, 1 in the paper: a U-Net between a square and a tall picture."""

    def __init__(self, config: Config, *, axes: int = 1) -> None:
        super().__init__()
        self.match_by, self.noise = config.match, config.noise
        widths = [1 if config.grey else 3, *config.channels]
        plain = len(config.channels) - config.encoder_dropout
        self.encoder = nn.ModuleList(
            nn.Sequential(
                SamePaddedConv(widths[i], widths[i + 1], 4, (stride, stride), bias=False),
                _norm(widths[i + 1], config.first_norm or i > 0),
                nn.ReLU(),
                nn.Dropout(config.dropout if i >= plain else 0),
            )
            for i, stride in enumerate(config.strides)
        )
        self.sizes = decoder_sizes(config)
        deepest, seed = config.channels[-1], self.sizes[0]
        self.squeeze = (
            nn.Linear(deepest * encoder_sizes(config)[-1] ** 2, config.latent) if config.latent else None
        )
        self.spread = (
            nn.Linear(config.latent + config.noise, deepest * seed[0] * seed[1]) if config.latent else None
        )
        skips = config.channels[: len(config.up_strides)][::-1]
        inputs = [deepest, *(2 * width for width in skips[:-1])]
        self.decoder = nn.ModuleList(
            nn.Sequential(
                CroppedTransposedConv(inputs[i], width, stride, self.sizes[i + 1]),
                nn.BatchNorm2d(width),
                nn.Dropout(config.dropout if i < config.decoder_dropout else 0),
                nn.ReLU(),
            )
            for i, (width, stride) in enumerate(zip(skips, column_strides(config), strict=True))
        )
        self.last = nn.Conv2d(2 * skips[-1], axes, 7, padding=3)
        normal_(self)
        self.to(memory_format=torch.channels_last)  # type: ignore[call-overload]
        if config.scale != "none" and self.last.bias is not None:  # start from the mean spectrum
            nn.init.constant_(self.last.bias, 1.0 if config.scale == "bins" else math.log1p(100))

    def forward(
        self,
        photo: Tensor,
        noise: Tensor | None = None,
        *,
        other: Tensor | None = None,
        share: float = 0.0,
    ) -> Tensor:
        """Return magnitudes >= 0 of photographs (batch, channel, pixels, pixels) in -1..1.

        ``noise``, standard normal, shape (batch, noise), is needed if the configuration has noise. With ``other``,
        photographs of the same shape, every map of the encoder is the mean of both, ``other`` counting ``share``.
        """
        maps = self._encoded(photo)
        if other is not None:
            maps = [one.lerp(two, share) for one, two in zip(maps, self._encoded(other), strict=True)]
        h = maps[-1]
        if self.squeeze is not None and self.spread is not None:
            latent = self.squeeze(h.flatten(1))  # B, 128
            if self.noise:
                if noise is None:
                    raise TypeError("this generator needs noise")
                latent = torch.cat((latent, noise), 1)  # B, 178
            h = self.spread(latent).unflatten(1, (h.shape[1], *self.sizes[0]))  # B, 512, 3, 3
        else:
            h = F.adaptive_avg_pool2d(h, self.sizes[0])  # B, 512, 3, 3
        for layer, skip in zip(self.decoder, reversed(maps[: len(self.decoder)]), strict=True):
            h = layer(h)  # B, C, rows, columns; the last B, 32, 257, 11
            h = torch.cat((h, match(skip, (h.shape[2], h.shape[3]), self.match_by)), 1)  # B, 2 C, …
        magnitude: Tensor = F.relu(self.last(h))  # B, 1, 257, 11
        return magnitude

    def _encoded(self, photo: Tensor) -> list[Tensor]:
        maps, h = [], photo  # B, 3, 1024, 1024
        for layer in self.encoder:
            h = layer(h)  # B, C, H / stride, W / stride; the last B, 512, 2, 2
            maps.append(h)
        return maps


class Critic(nn.Module):
    """Photograph and spectrogram to scores of patches, higher for real ones (PatchGAN, Isola et al. 2017)."""

    def __init__(self, config: Config, *, axes: int = 1) -> None:
        super().__init__()
        self.match_by, self.leak = config.match, config.leak
        a, b, c, d = config.critic_channels
        plain = not config.first_norm
        self.layers = nn.Sequential(
            SamePaddedConv((1 if config.grey else 3) + axes, a, 4, (2, 2), bias=plain), _norm(a, not plain),
            nn.LeakyReLU(config.leak),
            SamePaddedConv(a, b, 4, (2, 2), bias=False), nn.BatchNorm2d(b), nn.LeakyReLU(config.leak),
            SamePaddedConv(b, c, 4, (2, 1), bias=False), nn.BatchNorm2d(c), nn.LeakyReLU(config.leak),
            nn.Conv2d(c, d, (5, 4), padding=1, bias=False), nn.BatchNorm2d(d), nn.LeakyReLU(config.leak),
            nn.Conv2d(d, 1, 4, padding=1),
        )  # fmt: skip
        normal_(self)
        self.to(memory_format=torch.channels_last)  # type: ignore[call-overload]

    def forward(self, photo: Tensor, magnitude: Tensor) -> Tensor:
        """Return scores: (B, 3, 1024, 1024) and (B, 1, 257, 11) to (B, 1, 30, 1)."""
        seen = match(photo, (magnitude.shape[2], magnitude.shape[3]), self.match_by)  # B, 3, 257, 11
        scores: Tensor = self.layers(torch.cat((seen, magnitude), 1))  # B, 4, 257, 11 -> 129, 6 -> 65, 3
        return scores  # -> 33, 3 -> 31, 2 -> 30, 1


class SamePaddedConv(nn.Conv2d):
    """A strided convolution with TensorFlow's padding "same": ceil(n / stride) long, the odd zero last."""

    def __init__(self, inputs: int, outputs: int, kernel: int, stride: Size, *, bias: bool = True) -> None:
        super().__init__(inputs, outputs, kernel, stride=stride, bias=bias)

    def forward(self, x: Tensor) -> Tensor:
        rows, columns = (
            max(0, (-(-n // stride) - 1) * stride + kernel - n)
            for n, kernel, stride in zip(x.shape[2:], self.kernel_size, self.stride, strict=True)
        )
        if rows % 2 or columns % 2:
            x = F.pad(x, (0, columns % 2, 0, rows % 2))
        return F.conv2d(x, self.weight, self.bias, self.stride, (rows // 2, columns // 2))


class CroppedTransposedConv(nn.ConvTranspose2d):
    """A transposed convolution, cut to ``size``."""

    def __init__(self, inputs: int, outputs: int, stride: Size, size: Size) -> None:
        kernel = (4, 4 if stride[1] == 2 else 3)
        super().__init__(
            inputs, outputs, kernel, stride=stride, padding=(1 if stride[0] == 2 else 0, 1), bias=False
        )
        self.size = size

    def forward(self, x: Tensor, output_size: list[int] | None = None) -> Tensor:
        return super().forward(x)[:, :, : self.size[0], : self.size[1]]


def magnitudes_of(inside: Tensor, scale: Tensor, config: Config) -> Tensor:
    """Return the magnitudes of the network's outputs, (batch, axis, bin, frame); ``scale`` is (axis, bin, 1)."""
    return scale * (LEAST * torch.expm1(inside) if config.scale == "log" else inside)


def match(x: Tensor, size: Size, by: str) -> Tensor:
    """Return a map (…, row, column) resized to ``size``: its middle (``crop``), or means over areas (``pool``)."""
    if by == "pool":
        return F.adaptive_avg_pool2d(x, size)
    top, left = ((have - want) // 2 for have, want in zip(x.shape[2:], size, strict=True))
    return x[:, :, top : top + size[0], left : left + size[1]]


def _norm(channels: int, normalised: bool) -> nn.Module:
    return nn.BatchNorm2d(channels) if normalised else nn.Identity()
