"""Choice of a training's weights by the distance of its pictures of validation photographs."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

from torch import Tensor

from tactogram.errors import DataError, MissingExtraError
from tactogram.evaluation.pictures.networks import Lpips
from tactogram.nn.photo_translation import DistanceName, row_statistics_distance

Distance = Callable[[Tensor, Tensor], Tensor]


@dataclass(frozen=True)
class PictureChoice:
    """Distance by which weights are chosen."""

    name: DistanceName
    distance: Distance
    """Mean distance of generated and real pictures, shape (picture, 1, row, column); lower is better."""
    note: str = ""
    """Reason why it is not the configured distance, one line; else empty."""


def picture_choice(by: DistanceName, weights: str = "") -> PictureChoice:
    """Return the distance by which weights are chosen.

    ``lpips`` is LPIPS with AlexNet, as in Neshov et al. 2026, Sec. 3.2; ``weights`` is AlexNet's file, by default in
    torch's cache. ``row_statistics`` needs no weights and replaces LPIPS, with a note, if they are missing; for a named
    file, `DataError` or `MissingExtraError` is raised instead.
    """
    note = ""
    if by == "lpips":
        try:
            network = Lpips(weights, option="config.lpips_weights")
        except (DataError, MissingExtraError) as error:
            if weights:  # an explicit file is never replaced
                raise
            note = f"weights are chosen by row_statistics in place of LPIPS: {error}"
        else:
            return PictureChoice("lpips", lambda made, real: network(real, made).mean())
    return PictureChoice("row_statistics", row_statistics_distance, note)
