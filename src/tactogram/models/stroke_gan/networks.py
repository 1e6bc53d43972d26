"""Generator and discriminator of Saga et al., Table III. Tensors are (batch, axis, time, channel), as there."""

from __future__ import annotations

import math
from itertools import pairwise

import torch
import torch.nn.functional as F
from torch import Tensor, nn

from tactogram.models.stroke_gan.config import Config
from tactogram.nn import PhaseShuffle, StridedConv, StridedConvTranspose
from tactogram.nn.strided_convolution import constant_response, down, glorot_uniform_

MOST_GAIN = 3.0
"""Range of the log gain of a noise band, Np: ±26 dB."""


SLOWEST = 8.0
"""Cycles of the slowest sinusoid in a signal; the latent and the dense layer shape what is slower."""
FASTEST = 0.2
"""Cycles per sample of the fastest one."""


class Generator(nn.Module):
    """Latent and label to a signal. Each axis is convolved on its own, with shared filters.

    Parameters
    ----------
    config : Config
    axes : int
        A; 3 in the paper.
    labels : int
        C: one per class, and one per numeric condition.
    """

    def __init__(self, config: Config, *, axes: int, labels: int) -> None:
        super().__init__()
        self.leak, self.bands, self.plain = config.leak, config.noise_bands, config.latent
        self.shape = (axes, config.points, config.channels[0])
        self.dense = _dense(config.latent + labels, axes * config.points * config.channels[0])
        layers = [
            StridedConvTranspose(coarse, fine, kernel=config.kernel, stride=config.stride)
            for coarse, fine in pairwise((*config.channels, 1 + config.noise_bands))
        ]
        self.periodic = Periodic(config, axes=axes, labels=labels) if config.sinusoids else None
        if self.bands:  # begin as plain noise: a waveform near 0 and gains near 1
            with torch.no_grad():
                layers[-1].weight.mul_(0.1)
        self.layers = nn.ModuleList(layers)

    def forward(self, latent: Tensor, label: Tensor, noise: Tensor | None = None) -> Tensor:
        """Return signals.

        Parameters
        ----------
        latent : Tensor, shape (batch, latent); longer by two for each of ``sinusoids``
            Uniform in -1 to 1.
        label : Tensor, shape (batch, C)
        noise : Tensor, shape (batch, axis, time, band), optional
            Needed with ``noise_bands``.

        Returns
        -------
        Tensor, shape (batch, axis, time)
            Within -1 to 1; with ``noise_bands`` of about unit variance.
        """
        h = self.dense(torch.cat((latent[:, : self.plain], label), 1))  # B, A * 16 * 1024
        h = h.unflatten(1, self.shape)  # B, A, 16, 1024
        for layer in self.layers:
            if self.periodic and layer is self.layers[-1]:
                hidden, tones = self.periodic(latent[:, self.plain :], label)
                h = h + hidden  # B, A, T / 4, C
            h = layer(F.leaky_relu(h, self.leak))  # B, A, 4 T, C / 2; the last B, A, 16384, 1
        if not self.bands:
            return torch.tanh(h[..., 0])  # B, A, 16384
        if noise is None:
            raise TypeError("noise_bands need noise")
        wave, gains = h[..., 0].float(), MOST_GAIN * torch.tanh(h[..., 1:].float() / MOST_GAIN)
        shaped: Tensor = wave + (gains.exp() * noise).sum(3)  # B, A, T
        return shaped + tones if self.periodic else shaped


class Periodic(nn.Module):
    """Sinusoids over time, as in the periodic spatial GAN (Bergmann et al. 2017), for what repeats.

    Ribs and weaves repeat for longer than filters reach. Frequencies lie evenly on a logarithmic scale, each moved
    within its own step, and phases anywhere, by the latent. How much of each goes into the waveform of which axis,
    and into which channel of the last hidden layer, which shapes the noise, is learned by label: so labels mix
    here as well.

    References
    ----------
    - Bergmann, U., Jetchev, N. & Vollgraf, R. (2017). Learning texture manifolds with the periodic spatial GAN.
      ICML.
    """

    centres: Tensor

    def __init__(self, config: Config, *, axes: int, labels: int) -> None:
        super().__init__()
        self.time, self.stride, self.axes = config.length, config.stride, axes
        lowest, highest = math.log(SLOWEST / self.time), math.log(FASTEST)
        self.step = (highest - lowest) / config.sinusoids
        centres = lowest + self.step * (torch.arange(config.sinusoids) + 0.5)
        self.register_buffer("centres", centres, persistent=False)
        self.hidden = nn.Parameter(0.1 * torch.randn(labels, config.sinusoids, config.channels[-1]))
        self.wave = nn.Parameter(0.05 * torch.randn(labels, 2 * config.sinusoids, axes))

    def forward(self, latent: Tensor, label: Tensor) -> tuple[Tensor, Tensor]:
        """Return what is added to the hidden layer, (batch, 1, time / 4, channel), and out, (batch, axis, time)."""
        place, phase = latent.float().chunk(2, 1)  # B, S
        frequency = (self.centres + self.step / 2 * place).exp()  # cycles per sample
        samples = torch.arange(self.time, device=latent.device)
        angle = math.tau * frequency[:, :, None] * samples + math.pi * phase[:, :, None]  # B, S, T
        sine = angle.sin()
        hidden, wave = (torch.einsum("bl,lsc->bcs", label.float(), w) for w in (self.hidden, self.wave))
        both = torch.cat((sine, angle.cos()), 1)  # B, 2 S, T
        return (hidden @ sine[:, :, :: self.stride]).mT[:, None], wave @ both


class Discriminator(nn.Module):
    """Signal and label to a score, higher for a recording; the critic of a Wasserstein GAN.

    The label stands beside the signal as C constant channels (Table III, "1+C"). Their part of the first
    convolution is computed without making them: it is the same at every sample but near the ends.
    """

    def __init__(self, config: Config, *, axes: int, labels: int) -> None:
        super().__init__()
        self.leak = config.leak
        size = {"kernel": config.kernel, "stride": config.stride}
        widths = tuple(reversed(config.channels))
        self.first = StridedConv(1 + labels, widths[0], **size)
        self.layers = nn.ModuleList(StridedConv(fine, coarse, **size) for fine, coarse in pairwise(widths))
        self.shuffle = PhaseShuffle(config.phase_shuffle)
        self.dense = _dense(axes * config.points * config.channels[0], 1)

    def forward(self, x: Tensor, label: Tensor) -> Tensor:
        """Return scores: (batch, axis, time) and (batch, C) -> (batch, 1)."""
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


def _dense(inputs: int, outputs: int) -> nn.Linear:
    """Return a dense layer that begins as TensorFlow's do, which the paper used (Sec. II-B)."""
    layer = nn.Linear(inputs, outputs)
    glorot_uniform_(layer.weight, fan_in=inputs, fan_out=outputs)
    nn.init.zeros_(layer.bias)
    return layer
