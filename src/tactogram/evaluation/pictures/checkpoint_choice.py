"""Choice of the weights that make the best pictures of unseen photographs: by LPIPS, or without its network."""

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
    """Distance that weights are chosen by.

    Parameters
    ----------
    name : {"lpips", "row_statistics"}
        Of the distance that is used.
    distance : callable
        Made and real pictures, (picture, 1, row, column), to their mean distance: lower is better.
    note : str
        One line where it is not the distance that was asked for, and why; else empty.
    """

    name: DistanceName
    distance: Distance
    note: str = ""


def picture_choice(by: DistanceName, weights: str = "") -> PictureChoice:
    """Return what weights are chosen by.

    Parameters
    ----------
    by : {"lpips", "row_statistics"}
        LPIPS with AlexNet, as Neshov et al. 2026, Sec. 3.2; or `row_statistics_distance`, which needs no weights and
        also takes its place, with a note, where AlexNet's are not at hand.
    weights : str
        AlexNet's file; empty looks into torch's cache.

    Raises
    ------
    DataError, MissingExtraError
        If ``weights`` names a file and LPIPS cannot be had.
    """
    note = ""
    if by == "lpips":
        try:
            network = Lpips(weights, option="config.lpips_weights")
        except (DataError, MissingExtraError) as error:
            if weights:  # asked for by name: do not go by something else
                raise
            note = f"weights are chosen by row_statistics in place of LPIPS: {error}"
        else:
            return PictureChoice("lpips", lambda made, real: network(real, made).mean())
    return PictureChoice("row_statistics", row_statistics_distance, note)
