"""What a training goes by when it keeps the weights that make the best pictures of unseen photographs."""

from __future__ import annotations

from collections.abc import Callable
from typing import Literal

from torch import Tensor

from tactogram.errors import DataError, MissingExtraError
from tactogram.evaluation.pictures.networks import Lpips
from tactogram.nn.photo_translation import row_statistics_distance

DistanceName = Literal["lpips", "row_statistics"]

Distance = Callable[[Tensor, Tensor], Tensor]


def picture_choice(by: DistanceName, weights: str = "") -> tuple[DistanceName, Distance]:
    """Return what weights are chosen by, and the distance of made from real pictures: lower is better.

    Parameters
    ----------
    by : {"lpips", "row_statistics"}
        LPIPS with AlexNet, as Neshov et al. 2026, Sec. 3.2; or `row_statistics_distance`, which needs no weights and
        also takes its place where AlexNet's are not at hand. The name that comes back is of what will be used.
    weights : str
        AlexNet's file; empty looks into torch's cache.
    """
    if by == "lpips":
        try:
            network = Lpips(weights)
        except (DataError, MissingExtraError):
            if weights:  # asked for by name: do not go by something else
                raise
        else:
            return "lpips", lambda made, real: network(real, made).mean()
    return "row_statistics", row_statistics_distance
