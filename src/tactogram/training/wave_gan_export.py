"""Networks of a conditional WaveGAN for other runtimes."""

from __future__ import annotations

from collections.abc import Callable, Sequence

import torch
from torch import Tensor, nn

from tactogram.model import ExportedNetwork, Port, SignalKind
from tactogram.nn.bare_and_fixed import for_export
from tactogram.training.seeds import child_generator

DRAWN = 2
"""Signals in a batch of typical inputs."""


def exported_generator(
    network: nn.Module,
    kind: SignalKind,
    *,
    latents: int,
    labels: Sequence[str],
    length: int,
    output: Port,
    noise: bool = False,
    note: str = "",
) -> ExportedNetwork:
    """Return a generator of signals, (batch, axis, time), from latent, label and, if wanted, noise.

    ``labels`` name the numbers of a label, materials first.
    """
    axes = len(kind.axes)

    def draw(seed: int) -> tuple[Tensor, ...]:
        random = child_generator(seed, "export")
        latent = 2 * torch.rand(DRAWN, latents, generator=random) - 1
        more = (torch.randn(DRAWN, axes, length, generator=random),) if noise else ()
        return latent, _labels(kind, labels, random), *more

    inputs = {
        "latent": Port(("batch", "latent"), "uniform random numbers, -1 to 1"),
        "label": Port(("batch", "label"), "1 for the material, 0 for the others; mixes are weights"),
    }
    if noise:
        inputs["noise"] = Port(("batch", "axis", "time"), "standard normal random numbers")
    return ExportedNetwork(
        for_export(network), draw, inputs, {"signal": output}, note=note, facts={"label": list(labels)}
    )


def _labels(kind: SignalKind, labels: Sequence[str], random: torch.Generator) -> Tensor:
    """Return a label of a random material, other numbers 0."""
    place = torch.randint(len(kind.materials), (DRAWN,), generator=random)
    return torch.eye(len(labels))[place]


class Scaled(nn.Module):
    """A generator whose signals, (batch, axis, time), are multiplied and moved per axis."""

    scale: Tensor
    offset: Tensor

    def __init__(self, network: nn.Module, scale: Tensor, offset: Tensor) -> None:
        super().__init__()
        self.network = network
        self.register_buffer("scale", scale.float()[:, None])
        self.register_buffer("offset", offset.float()[:, None])

    def forward(self, latent: Tensor, label: Tensor) -> Tensor:
        """Return signals in their unit, (batch, axis, time)."""
        y: Tensor = self.network(latent, label)
        return y * self.scale + self.offset


Noise = Callable[[Tensor], Tensor]


class Shaped(nn.Module):
    """A generator whose last input is white noise, which ``shape`` splits for it."""

    def __init__(self, network: nn.Module, shape: Noise) -> None:
        super().__init__()
        self.network, self.shape = network, shape

    def forward(self, latent: Tensor, label: Tensor, noise: Tensor) -> Tensor:
        """Return signals, (batch, axis, time)."""
        made: Tensor = self.network(latent, label, self.shape(noise))
        return made
