"""Quality of generated colour images as a set: FID, and a distance that needs no download."""

from __future__ import annotations

from collections.abc import Callable

import torch
from torch import Tensor

from tactogram.errors import DataError, MissingExtraError, ParameterError
from tactogram.evaluation.pictures.networks import Fid, TrunkDistance

TITLES = {"fid": "FID", "efficientnet_lite0_frechet_distance": "Fréchet distance in EfficientNet-Lite0"}


class ImageQuality:
    """Both distances from one set of real images, their networks loaded once.

    Parameters
    ----------
    real : float tensor, shape (image, 3, rows, columns), -1 to 1
        At least 2.
    inception : str
        File of FID's weights; where empty, torch's cache.

    Attributes
    ----------
    missing : mapping from str to str
        Why a distance could not be had, in a line. None is given under the name of another.
    """

    def __init__(self, real: Tensor, *, inception: str = "") -> None:
        if len(real) < 2:
            raise ParameterError(f"at least 2 real images are needed, got {len(real)}")
        self.real = real
        self.missing: dict[str, str] = {}
        self._measures: dict[str, Callable[[Tensor, Tensor], float]] = {}
        builders: dict[str, Callable[[], Callable[[Tensor, Tensor], float]]] = {
            "fid": lambda: Fid(inception),
            "efficientnet_lite0_frechet_distance": lambda: TrunkDistance().frechet,
        }
        for name, build in builders.items():
            try:
                self._measures[name] = build()
            except (DataError, MissingExtraError) as error:
                self.missing[name] = str(error)

    def __call__(self, made: Tensor) -> dict[str, float]:
        """Return the distances of ``made`` from the real ones, by a name of `TITLES`; lower is better.

        Both are biased upwards by few images: compare only sets of one size.
        """
        with torch.no_grad():
            return {name: float(measure(self.real, made)) for name, measure in self._measures.items()}
