"""Distances of generated pictures of touch from real ones: the paper's, and measures that need no network.

`evaluate_pictures` computes all of them under one protocol, says of each that could not be computed why, and never
gives
one under the name of another. Pictures are not signals: distances of the signals (`evaluation.generation`) always
belong beside these.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from typing import Any

import torch
from torch import Tensor

from tactogram.errors import DataError, MissingExtraError, ParameterError
from tactogram.evaluation.pictures.networks import PROTOCOL, Fid, Lpips, TrunkDistance, check_pictures
from tactogram.features.spectrogram_picture import SpectrogramPicture
from tactogram.nn.vision_import import vision_module

MEASURES: Mapping[str, tuple[str, str]] = {
    "lpips": ("LPIPS (AlexNet)", "lower"),
    "fid": ("FID", "lower"),
    "efficientnet_lite0_distance": ("1 - cosine in EfficientNet-Lite0, paired", "lower"),
    "efficientnet_lite0_frechet_distance": ("Fréchet distance in EfficientNet-Lite0", "lower"),
    "log_spectral_distance_db": ("log-spectral distance of the mean spectra, paired, dB", "lower"),
    "level_difference_db": ("difference in level, paired, dB", "lower"),
    "l1": ("mean absolute difference, of values in -1..1", "lower"),
    "psnr_db": ("peak signal-to-noise ratio, dB", "higher"),
    "ssim": ("structural similarity", "higher"),
}
"""Title, and which is better. PSNR and SSIM ask for alignment that weak pairs have not (Neshov et al. 2026, 4.1)."""

MOST_PSNR_DB = 100.0
"""What equal pictures get: infinity is no number for a table."""

MEANINGLESS = "_with_random_weights"
"""What is added to the name of a measure whose network was not trained: the number means nothing."""

PictureMeasure = Callable[[Tensor, Tensor], float]
"""Of real and generated pictures, as many of each."""


@dataclass(frozen=True)
class PictureWeights:
    """Weight files of LPIPS and FID.

    Parameters
    ----------
    alexnet, inception : str
        Files; where empty, torch's cache.
    random : bool
        No trained weights at all: for tests. Names and values are marked as meaningless.
    """

    alexnet: str = ""
    inception: str = ""
    random: bool = False


@dataclass(frozen=True)
class PictureResult:
    """Distances of generated from real pictures.

    Parameters
    ----------
    values : mapping from str to float
        By a name of `MEASURES`, or that and `MEANINGLESS`.
    missing : mapping from str to str
        Why each that is not among them could not be computed, in a line.
    pictures : int
        How many of each.
    protocol : str
        Size, channels and range that networks were given.
    """

    values: Mapping[str, float]
    missing: Mapping[str, str] = field(default_factory=dict)
    pictures: int = 0
    protocol: str = PROTOCOL

    def as_dict(self) -> dict[str, Any]:
        """Return it as JSON types."""
        return {
            "values": dict(self.values),
            "missing": dict(self.missing),
            "pictures": self.pictures,
            "protocol": self.protocol,
        }


class PictureEvaluator:
    """All measures of `MEASURES`, their networks loaded once.

    Parameters
    ----------
    picture : SpectrogramPicture
    weights : PictureWeights, optional
    networks : bool
        Whether measures in networks are asked for at all.

    Attributes
    ----------
    missing : mapping from str to str
        Why each measure that is not there could not be had, in a line.
    """

    def __init__(
        self, picture: SpectrogramPicture, *, weights: PictureWeights | None = None, networks: bool = True
    ) -> None:
        self.picture = picture
        self.missing: dict[str, str] = {}
        self._measures: dict[str, PictureMeasure] = {}
        weights = PictureWeights() if weights is None else weights
        mark = MEANINGLESS if weights.random else ""
        if networks:
            self._add((f"lpips{mark}",), lambda: (_mean_of(Lpips(weights.alexnet, random=weights.random)),))
            self._add((f"fid{mark}",), lambda: (Fid(weights.inception, random=weights.random),))
            self._add(("efficientnet_lite0_distance", "efficientnet_lite0_frechet_distance"), _in_trunk)
        self._add(("log_spectral_distance_db", "level_difference_db"), lambda: (self._shape, self._level))
        self._add(("l1",), lambda: (_l1,))
        self._add(("psnr_db", "ssim"), _classic)

    def __call__(self, real: Tensor, made: Tensor) -> PictureResult:
        """Return how far ``made`` is from ``real``.

        Parameters
        ----------
        real, made : float tensor, shape (pair, 1, rows, columns), in [-1, 1]
            At least 2 pairs, each of one material.

        Raises
        ------
        ParameterError
            If they are not.
        """
        check_pictures(real, made, paired=True)
        if len(real) < 2:
            raise ParameterError("at least 2 pairs are needed, got 1")
        with torch.no_grad():
            values = {name: float(measure(real, made)) for name, measure in self._measures.items()}
        return PictureResult(values, dict(self.missing), len(real))

    def _add(self, names: tuple[str, ...], build: Callable[[], tuple[PictureMeasure, ...]]) -> None:
        try:
            self._measures |= dict(zip(names, build(), strict=True))
        except (DataError, MissingExtraError) as error:
            self.missing |= dict.fromkeys(names, str(error))

    def _shape(self, real: Tensor, made: Tensor) -> float:
        """Root mean square over bins of the difference of the mean levels over frames; mean over pairs."""
        return float((self._levels(real) - self._levels(made)).square().mean(1).sqrt().mean())

    def _level(self, real: Tensor, made: Tensor) -> float:
        """Difference of the levels, 10 log10 of the summed squared amplitudes; mean over pairs."""
        a, b = (self.picture.decode(p).square().sum((1, 2)) for p in (real, made))
        silent = 10 ** (self.picture.floor_db / 10)  # one bin of one frame at the floor
        return float((10 * torch.log10(a.clamp_min(silent) / b.clamp_min(silent))).abs().mean())

    def _levels(self, pictures: Tensor) -> Tensor:
        """Return the mean level over frames of each bin, dB, shape (picture, bin)."""
        least = 10 ** (self.picture.floor_db / 20)
        return (20 * torch.log10(self.picture.decode(pictures).clamp_min(least))).mean(2)


def evaluate_pictures(
    real: Tensor,
    made: Tensor,
    picture: SpectrogramPicture,
    *,
    weights: PictureWeights | None = None,
    networks: bool = True,
) -> PictureResult:
    """Return how far ``made`` is from ``real``; see `PictureEvaluator`, which is quicker more than once.

    Parameters
    ----------
    real, made : float tensors, shape (pair, 1, rows, columns), in [-1, 1]
        At least 2 pairs, each of one material.
    picture : SpectrogramPicture
        What they were made by.
    weights, networks
        As of `PictureEvaluator`.

    Raises
    ------
    ParameterError
        If the pictures are not what is said above.
    """
    return PictureEvaluator(picture, weights=weights, networks=networks)(real, made)


def _mean_of(paired: Callable[[Tensor, Tensor], Tensor]) -> PictureMeasure:
    return lambda real, made: float(paired(real, made).mean())


def _in_trunk() -> tuple[PictureMeasure, ...]:
    distance = TrunkDistance()
    return _mean_of(distance.paired), distance.frechet


def _l1(real: Tensor, made: Tensor) -> float:
    return float((real - made).abs().mean())


def _classic() -> tuple[PictureMeasure, ...]:
    library = vision_module("torchmetrics.functional.image")

    def psnr(real: Tensor, made: Tensor) -> float:
        value = library.peak_signal_noise_ratio(made, real, data_range=2.0, dim=(1, 2, 3), reduction="none")
        return float(value.clamp_max(MOST_PSNR_DB).mean())

    def ssim(real: Tensor, made: Tensor) -> float:
        return float(library.structural_similarity_index_measure(made, real, data_range=2.0))

    return psnr, ssim
