"""The networks of each cluster for other runtimes, from and to spectra in their units."""

from __future__ import annotations

from collections.abc import Sequence
from functools import partial

import numpy as np
import torch
from numpy.typing import NDArray
from torch import Tensor, nn

from tactogram.model import ExportedNetwork, Port, SignalKind
from tactogram.models.ultrasonic_cgan.networks import Discriminator, Generator
from tactogram.models.ultrasonic_cgan.surfaces import SurfaceTable
from tactogram.models.ultrasonic_cgan.trained import TrainedCluster
from tactogram.nn.bare_and_fixed import for_export
from tactogram.training.seeds import child_generator

DRAWN = 4
"""Spectra in a batch of typical inputs."""


def exported_networks(
    surfaces: SurfaceTable, trained: Sequence[TrainedCluster], kind: SignalKind
) -> dict[str, ExportedNetwork]:
    """Return generator and discriminator of each cluster whose training succeeded."""
    found: dict[str, ExportedNetwork] = {}
    for number, cluster in enumerate(trained):
        if cluster.generator is None or cluster.discriminator is None:
            continue
        members = list(surfaces.members(number))
        facts = {"surfaces": members, "word": list(kind.words), "scale": kind.scale and list(kind.scale)}
        scores = Port(("batch", "word"), "scores, 0 to 1")
        spectrum = ("batch", "bin")
        drive = Port(spectrum, "amplitude spectrum of the display's drive, 1 Hz, 2 Hz, …", kind.unit)
        found[f"generator_{number + 1}"] = ExportedNetwork(
            ScaledGenerator(for_export(cluster.generator), surfaces.sensor_scale, surfaces.display_scale),
            partial(_drawn, surfaces.stored.mean(1), len(kind.words)),
            {
                "sensor": Port(
                    spectrum, "amplitude spectrum of a sensor over 1 s, 1 Hz, 2 Hz, …", "of the sensor"
                ),
                "scores": scores,
            },
            {"drive": drive},
            note="phases of a low crest factor, which make a drive of the spectrum, are not a network",
            facts=facts,
        )
        found[f"discriminator_{number + 1}"] = ExportedNetwork(
            ScaledDiscriminator(for_export(cluster.discriminator), surfaces.display_scale),
            partial(_drawn, surfaces.display, len(kind.words)),
            {"drive": drive, "scores": scores},
            {"probability": Port(("batch", "one"), "probability of training data")},
            facts=facts,
        )
    return found


def _drawn(spectra: NDArray[np.float32], words: int, seed: int) -> tuple[Tensor, Tensor]:
    """Return spectra and scores drawn by a seed."""
    random = child_generator(seed, "export")
    rows = torch.randint(len(spectra), (DRAWN,), generator=random)
    return torch.from_numpy(spectra).float()[rows], torch.rand(DRAWN, words, generator=random)


class ScaledGenerator(nn.Module):
    """Spectra in the sensor's unit to those of the drive, none below 0."""

    def __init__(self, network: Generator, sensor_scale: float, display_scale: float) -> None:
        super().__init__()
        self.network, self.sensor_scale, self.display_scale = network, sensor_scale, display_scale

    def forward(self, spectrum: Tensor, scores: Tensor) -> Tensor:
        """Return drive spectra, (batch, bin), of sensor spectra and scores, (batch, word)."""
        made: Tensor = self.network(torch.cat((spectrum / self.sensor_scale, scores), 1))
        return made.clamp_min(0) * self.display_scale


class ScaledDiscriminator(nn.Module):
    """Probability that a drive spectrum is training data."""

    def __init__(self, network: Discriminator, display_scale: float) -> None:
        super().__init__()
        self.network, self.display_scale = network, display_scale

    def forward(self, spectrum: Tensor, scores: Tensor) -> Tensor:
        """Return probabilities, (batch, 1)."""
        return self.network.probability(torch.cat((spectrum / self.display_scale, scores), 1))
