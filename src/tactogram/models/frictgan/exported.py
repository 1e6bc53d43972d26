"""FrictGAN's networks and its phase recovery for other runtimes, from photographs to magnitudes in their unit."""

from __future__ import annotations

import math
from typing import Any

import torch
from torch import Tensor, nn

from tactogram.features.phase_network import AmplitudePhaseRecovery
from tactogram.model import ExportedNetwork, Port, SignalKind
from tactogram.models.frictgan.config import Config
from tactogram.models.frictgan.networks import Generator, magnitudes_of
from tactogram.nn.bare_and_fixed import for_export
from tactogram.training.seeds import child_generator

DRAWN = 2
"""Photographs in a batch of typical inputs."""


def exported_networks(
    generator: Any, critic: Any, scale: Tensor, config: Config, kind: SignalKind
) -> dict[str, ExportedNetwork]:
    """Return generator, phase recovery of one axis, and critic."""
    channels, axes = 1 if config.grey else 3, len(kind.axes)
    spectrogram = config.spectrogram()
    photo = Port(("batch", "colour", "row", "column"), "photograph, -1 to 1")
    picture = ("batch", "axis", "bin", "frame")

    def draw(seed: int) -> tuple[Tensor, ...]:
        random = child_generator(seed, "export")
        side = config.pixels
        photos = 2 * torch.rand(DRAWN, channels, side, side, generator=random) - 1
        return photos, *((torch.randn(DRAWN, config.noise, generator=random),) if config.noise else ())

    def draw_spectra(seed: int, *shape: int) -> Tensor:
        size = (*shape, config.bins, config.frames)
        return torch.rand(size, generator=child_generator(seed, "spectra"))

    def draw_phase(seed: int) -> tuple[Tensor, Tensor]:
        samples = torch.rand(1, spectrogram.length, generator=child_generator(seed, "friction"))
        return spectrogram.encode(samples), math.tau * draw_spectra(seed, 1)

    noise = {"noise": Port(("batch", "noise"), "standard normal random numbers")} if config.noise else {}
    found = {
        "generator": ExportedNetwork(
            PhysicalGenerator(for_export(generator), scale.cpu(), config),
            draw,
            {"photo": photo, **noise},
            {"magnitude": Port(picture, "magnitudes of the transform", kind.unit)},
        )
    }
    if config.iterations:
        column = ("batch", "bin", "frame")
        found["phase_recovery"] = ExportedNetwork(
            AmplitudePhaseRecovery(spectrogram).eval(),
            draw_phase,
            {
                "magnitude": Port(column, "magnitudes of one axis", kind.unit),
                "phase": Port(column, "phase to start from: uniform noise", "rad"),
            },
            {"signal": Port(("batch", "time"), "signal of one axis", kind.unit)},
            free=(),
            reference=lambda magnitude, phase: spectrogram.decode(magnitude, phase=phase),
            convergence=lambda magnitude, phase, samples: distance_db(spectrogram.encode(samples), magnitude),
            facts={"iterations": config.iterations},
        )
    found["critic"] = ExportedNetwork(
        for_export(critic),
        lambda seed: (draw(seed)[0], draw_spectra(seed, DRAWN, axes)),
        {"photo": photo, "magnitude": Port(picture, "magnitudes, scaled as in training")},
        {"score": Port(("batch", "one", "patch_row", "patch_column"), "score of each patch, higher if real")},
    )
    return found


def distance_db(found: Tensor, wanted: Tensor) -> float:
    """Return the distance of magnitudes from those wanted, relative, dB."""
    return float(20 * torch.log10((found - wanted).norm() / wanted.norm()))


class PhysicalGenerator(nn.Module):
    """The generator with its outputs as magnitudes in the signals' unit."""

    scale: Tensor

    def __init__(self, network: Generator, scale: Tensor, config: Config) -> None:
        super().__init__()
        self.network, self.config = network, config
        self.register_buffer("scale", scale)

    def forward(self, photo: Tensor, noise: Tensor | None = None) -> Tensor:
        """Return magnitudes, (batch, axis, bin, frame)."""
        return magnitudes_of(self.network(photo, noise), self.scale, self.config)
