"""Generator: a waveform, gains of noise in bands, and sinusoids. Tensors are (batch * axis, channel, time)."""

from __future__ import annotations

import math
from itertools import pairwise

import torch
import torch.nn.functional as F
from torch import Tensor, nn

from tactogram.models.texture_gan.config import Config
from tactogram.nn import glorot_linear, strided_conv_transpose

MOST_GAIN = 3.0
"""Range of the log gain of a noise band, Np: ±26 dB."""
SLOWEST = 8.0
"""Cycles of the slowest sinusoid in a signal; the latent and the dense layer shape slower parts."""
FASTEST = 0.2
"""Cycles per sample of the fastest one."""


class Generator(nn.Module):
    """Latent, label and noise to a whitened signal. Each axis is convolved separately, with shared filters.

    A axes, and C labels: one per class, and one per numeric condition.
    """

    def __init__(self, config: Config, *, axes: int, labels: int) -> None:
        super().__init__()
        self.leak, self.plain = config.leak, config.latent
        self.shape = (axes, config.points, config.channels[0])
        self.dense = glorot_linear(config.latent + labels, axes * config.points * config.channels[0])
        layers = [
            strided_conv_transpose(coarse, fine, kernel=config.kernel, stride=config.stride)
            for coarse, fine in pairwise((*config.channels, 1 + config.noise_bands))
        ]
        self.periodic = Periodic(config, axes=axes, labels=labels) if config.sinusoids else None
        with torch.no_grad():  # begin as plain noise: a waveform near 0 and gains near 1
            layers[-1].weight.mul_(0.1)
        self.layers = nn.ModuleList(layers)

    def forward(self, latent: Tensor, label: Tensor, noise: Tensor) -> Tensor:
        """Return signals of about unit variance, (batch, axis, time).

        ``latent``, (batch, latent + 2 sinusoids), is uniform in -1 to 1; ``label`` has shape (batch, C); ``noise``,
        (batch, axis, time, band), is white in sum.
        """
        h = self.dense(torch.cat((latent[:, : self.plain], label), 1))  # B, A * 16 * 64
        h = h.unflatten(1, self.shape).flatten(0, 1).transpose(1, 2)  # B A, 64, 16
        for layer in self.layers:
            if self.periodic and layer is self.layers[-1]:
                hidden, tones = self.periodic(latent[:, self.plain :], label)
                h = h + hidden.repeat_interleave(self.shape[0], 0)  # B A, C, T / 4
            h = layer(F.leaky_relu(h, self.leak))  # B A, C / 2, 4 T; the last B A, 1 + bands, 4096
        h = h.unflatten(0, noise.shape[:2]).float()
        wave, gains = h[:, :, 0], MOST_GAIN * torch.tanh(h[:, :, 1:] / MOST_GAIN)
        shaped: Tensor = wave + (gains.exp() * noise.mT).sum(2)  # B, A, T
        return shaped + tones if self.periodic else shaped


class Periodic(nn.Module):
    """Sinusoids for periodic textures, as in the periodic spatial GAN (Bergmann et al. 2017).

    Ribs and weaves have longer periods than filters reach. Frequencies lie evenly on a logarithmic scale; the latent
    moves each within its step and sets its phase. The weights of each sinusoid, in the waveform of each axis and in
    each channel of the last hidden layer, which shapes the noise, are learned by label, so that labels mix here, too.

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
        """Return addends of the hidden layer, (batch, channel, time / 4), and of the output, (batch, axis, time)."""
        offset, phase = latent.float().chunk(2, 1)  # B, S
        frequency = (self.centres + self.step / 2 * offset).exp()  # cycles per sample
        samples = torch.arange(self.time, device=latent.device)
        angle = math.tau * frequency[:, :, None] * samples + math.pi * phase[:, :, None]  # B, S, T
        sine = angle.sin()
        hidden, wave = (torch.einsum("bl,lsc->bcs", label.float(), w) for w in (self.hidden, self.wave))
        both = torch.cat((sine, angle.cos()), 1)  # B, 2 S, T
        return hidden @ sine[:, :, :: self.stride], wave @ both


def split_bands(noise: Tensor, bands: int) -> Tensor:
    """Return ``noise`` in octaves, the top one half of the band: (…, time) -> (…, time, band).

    Neighbours cross over in the octave between their centres; all bands sum to ``noise``.
    """
    time = noise.shape[-1]
    spectrum = torch.fft.rfft(noise)
    frequency = torch.arange(spectrum.shape[-1], device=noise.device) / (time / 2)  # 0..1 of half the rate
    octave = torch.log2(frequency.clamp(min=2.0**-30)) + bands - 0.5  # 0 at the edge below band 1
    gains = torch.ones(bands + 1, len(frequency), device=noise.device)
    for edge in range(1, bands):
        across = (octave - edge + 1).clamp(0, 1) * (math.pi / 2)
        gains[edge - 1] *= across.cos() ** 2
        gains[edge] *= across.sin() ** 2
    return torch.stack([torch.fft.irfft(spectrum * gain, time) for gain in gains[:bands]], -1)
