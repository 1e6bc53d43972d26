"""Networks of a model that turns photographs into spectrogram pictures, for other runtimes."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Any

import torch
from torch import Tensor, nn

from tactogram.features.phase_network import PicturePhaseRecovery
from tactogram.features.spectrogram_picture import SpectrogramPicture
from tactogram.model import ExportedNetwork, Port
from tactogram.nn.bare_and_fixed import for_export
from tactogram.training.seeds import child_generator

DRAWN = 2
"""Photographs in a batch of typical inputs."""
BELOW_DB = 20.0
"""Level of the noise whose picture is recovered, below the ceiling."""
IMAGE = ("batch", "one", "row", "column")
PHOTO = Port(IMAGE, "gray photograph, -1 to 1")
PICTURE = Port(IMAGE, "spectrogram picture, -1 (floor) to 1 (ceiling), row 0 is 0 Hz")


def drawn_images(seed: int, size: int, count: int = 1) -> list[Tensor]:
    """Return ``count`` batches of typical photographs or pictures: smooth, -1 to 1."""
    random = child_generator(seed, "export")
    coarse = torch.rand(count, DRAWN, 1, max(2, size // 8), max(2, size // 8), generator=random)
    fine = nn.functional.interpolate(coarse.flatten(0, 1), (size, size), mode="bilinear")
    return list((2 * fine - 1).view(count, DRAWN, 1, size, size))


def exported_picture_generator(
    network: nn.Module, size: int, *, masks: Sequence[Sequence[int]] = ()
) -> ExportedNetwork:
    """Return a generator of pictures from photographs; ``masks`` are the shapes of those of its dropout."""

    def draw(seed: int) -> tuple[Tensor, ...]:
        random = child_generator(seed, "masks")
        drops = [2.0 * torch.randint(2, (1, *shape), generator=random) for shape in masks]
        return *(photo[:1] if drops else photo for photo in drawn_images(seed, size)), *drops

    ports = {
        f"mask_{k}": Port(
            ("batch", f"channel_{k}", f"row_{k}", f"column_{k}"), "factors of the dropout, 0 or 2 at random"
        )
        for k in range(len(masks))
    }
    free = () if masks else ("batch",)
    return ExportedNetwork(
        for_export(network), draw, {"photo": PHOTO, **ports}, {"picture": PICTURE}, free=free
    )


def exported_phase_recovery(picture: SpectrogramPicture) -> ExportedNetwork:
    """Return the recovery of a signal from a picture and a starting phase."""
    network = PicturePhaseRecovery(picture)
    shape = 1, picture.bins, picture.frames

    def draw(seed: int) -> tuple[Tensor, ...]:
        random = child_generator(seed, "phase")
        noise = 10 ** ((picture.ceiling_db - BELOW_DB) / 20) * torch.randn(
            1, picture.length, generator=random
        )
        return picture.encode(noise), math.tau * torch.rand(shape, generator=random)

    return ExportedNetwork(
        network.eval(),
        draw,
        {"picture": PICTURE, "phase": Port(("batch", "bin", "frame"), "phase to start from", "rad")},
        {"signal": Port(("batch", "time"), "signal", picture.unit)},
        free=(),
        reference=network.reference,
        convergence=network.convergence_db,
        note="the package starts from phase gradient heap integration, which has no graph: draw phases at random",
        facts={
            "floor_db": picture.floor_db,
            "ceiling_db": picture.ceiling_db,
            "iterations": picture.iterations,
        },
    )


def exported_discriminator(network: nn.Module, size: int) -> ExportedNetwork:
    """Return a discriminator of photographs with pictures."""
    found = DiscriminatorScores(for_export(network))
    photo, picture = drawn_images(0, size, 2)
    count = len(found(photo, picture))
    return ExportedNetwork(
        found,
        lambda seed: tuple(drawn_images(seed, size, 2)),
        {"photo": PHOTO, "picture": PICTURE},
        {
            f"score_{k}": Port(
                ("batch", "one", f"row_{k}", f"column_{k}"), "score of each patch, higher if real"
            )
            for k in range(count)
        },
    )


def exported_predictor(network: nn.Module, size: int, materials: Sequence[str]) -> ExportedNetwork:
    """Return a classifier of photographs."""
    return ExportedNetwork(
        nn.Sequential(for_export(network), nn.Softmax(1)),
        lambda seed: tuple(drawn_images(seed, size)),
        {"photo": PHOTO},
        {"probability": Port(("batch", "material"), "probability of each material")},
        facts={"material": list(materials)},
    )


class DiscriminatorScores(nn.Module):
    """The scores of a discriminator, one output per scale."""

    def __init__(self, network: nn.Module) -> None:
        super().__init__()
        self.network = network

    def forward(self, photo: Tensor, picture: Tensor) -> tuple[Tensor, ...]:
        """Return the scores of patches."""
        found: Any = self.network(torch.cat((photo, picture), 1))
        scales = found if isinstance(found[0], list) else [found]
        return tuple(features[-1] for features in scales)
