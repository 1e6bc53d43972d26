"""Distances of generated images from real ones: the paper's, and measures that need no network.

`PictureEvaluator` computes all of them for pictures of touch under one protocol and gives the reason for each that is
not available; none is replaced by another. Pictures are not signals: report distances of the signals
(`evaluation.generation`), too.

A generator that draws one image for all noises, or ignores its label, is recognised by the differences between its
images, relative to those between real images. The spread says nothing about the quality of an image.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass

import numpy as np
import torch
from numpy.typing import NDArray
from scipy.spatial.distance import pdist
from torch import Tensor

from tactogram.errors import DataError, MissingExtraError, ParameterError
from tactogram.evaluation.pictures.networks import PROTOCOL, Fid, Lpips, TrunkDistance, check_pictures
from tactogram.features.spectrogram_picture import SpectrogramPicture
from tactogram.nn.photo_translation import DistanceName, row_statistics_distance
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
"""Title, and whether lower or higher is better. PSNR and SSIM need an alignment that weak pairs lack (Neshov et al.
2026, 4.1)."""

MOST_PSNR_DB = 100.0
"""PSNR of equal pictures, in place of infinity."""

PictureMeasure = Callable[[Tensor, Tensor], float]
"""Measure of equally many real and generated pictures."""
_Groups = Mapping[tuple[str, ...], Callable[[], tuple[PictureMeasure, ...]]]
Distance = Callable[[Tensor, Tensor], Tensor]
COLLAPSED = 0.1
"""Share of the spread of real images below which generated images count as equal. Ours."""
Images = NDArray[np.float32]
"""Shape (image, 3, row, column), -1 to 1."""


@dataclass(frozen=True)
class PictureWeights:
    """Weight files of LPIPS (AlexNet) and FID (Inception); an empty one is read from torch's cache."""

    alexnet: str = ""
    inception: str = ""


@dataclass(frozen=True)
class PictureResult:
    """Distances of generated from real pictures."""

    values: Mapping[str, float]
    """By the names of `MEASURES`."""
    missing: Mapping[str, str]
    """Reason why a measure is not available, one line each."""
    pictures: int
    """Number of real and of generated pictures."""
    protocol: str = PROTOCOL
    """Size, channels and range of the networks' input."""


class PictureEvaluator:
    """Evaluation of spectrogram pictures by `MEASURES`, without ``networks`` by those that need none.

    Networks are loaded once. ``missing`` holds the reason for each measure that is not available, one line each.
    """

    def __init__(
        self, picture: SpectrogramPicture, *, weights: PictureWeights | None = None, networks: bool = True
    ) -> None:
        self.picture = picture
        files = weights or PictureWeights()
        groups: _Groups = {
            ("lpips",): lambda: (_mean_of(Lpips(files.alexnet)),),
            ("fid",): lambda: (Fid(files.inception),),
            ("efficientnet_lite0_distance", "efficientnet_lite0_frechet_distance"): _in_trunk,
        }
        plain: _Groups = {
            ("log_spectral_distance_db", "level_difference_db"): lambda: (self._shape, self._level),
            ("l1",): lambda: (_l1,),
            ("psnr_db", "ssim"): _classic,
        }
        self._measures, self.missing = _available({**(groups if networks else {}), **plain})

    def __call__(self, real: Tensor, made: Tensor) -> PictureResult:
        """Return the distances of ``made`` from ``real``, both of shape (pair, 1, rows, columns), in [-1, 1].

        Each pair is of one material. Raises `ParameterError` below 2 pairs, or for another shape or range.
        """
        check_pictures(real, made, paired=True)
        if len(real) < 2:
            raise ParameterError("at least 2 pairs are needed, got 1")
        with torch.no_grad():
            values = {name: float(measure(real, made)) for name, measure in self._measures.items()}
        return PictureResult(values, dict(self.missing), len(real))

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


class ImageQuality:
    """Fréchet distances of sets of colour images from one set of real ones, their networks loaded once.

    ``real`` has shape (image, 3, rows, columns), -1 to 1; below 2 images, `ParameterError` is raised. ``missing`` is as
    in `PictureEvaluator`.
    """

    def __init__(self, real: Tensor) -> None:
        if len(real) < 2:
            raise ParameterError(f"at least 2 real images are needed, got {len(real)}")
        self.real = real
        self._measures, self.missing = _available(
            {
                ("fid",): lambda: (Fid(),),
                ("efficientnet_lite0_frechet_distance",): lambda: (TrunkDistance().frechet,),
            }
        )

    def __call__(self, made: Tensor) -> dict[str, float]:
        """Return the distances of ``made``, shape (image, 3, rows, columns), by the names of `MEASURES`.

        Both are biased upwards by few images: compare only sets of one size.
        """
        with torch.no_grad():
            return {name: float(measure(self.real, made)) for name, measure in self._measures.items()}


def _available(groups: _Groups) -> tuple[dict[str, PictureMeasure], dict[str, str]]:
    """Return the measures whose libraries and weights are present, and the reasons why the others are missing."""
    measures: dict[str, PictureMeasure] = {}
    missing: dict[str, str] = {}
    for names, build in groups.items():
        try:
            measures |= dict(zip(names, build(), strict=True))
        except (DataError, MissingExtraError) as error:
            missing |= dict.fromkeys(names, str(error))
    return measures, missing


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


@dataclass(frozen=True)
class ImageSpread:
    """Mean distance of two images, root mean square over pixels of values in -1 to 1."""

    real: float
    """Of real images."""
    by_noise: float
    """Of generated images of one label."""
    by_label: float
    """Of generated images of one noise."""

    @property
    def noise_share(self) -> float:
        """``by_noise`` as a share of ``real``."""
        return self.by_noise / self.real

    @property
    def label_share(self) -> float:
        """``by_label`` as a share of ``real``."""
        return self.by_label / self.real

    @property
    def collapse(self) -> str:
        """Kind of collapse, in words; empty without one."""
        same_noise, same_label = (share < COLLAPSED for share in (self.noise_share, self.label_share))
        if same_noise and same_label:
            return "one image for all labels and noises"
        if same_noise:
            return "one image per label, whatever the noise"
        return "the label makes no difference" if same_label else ""

    def as_dict(self) -> dict[str, float]:
        """Return the three distances, the two shares, and ``collapsed`` (1 or 0)."""
        return {
            "real_spread": self.real,
            "noise_spread": self.by_noise,
            "label_spread": self.by_label,
            "noise_share": self.noise_share,
            "label_share": self.label_share,
            "collapsed": float(bool(self.collapse)),
        }


def mean_distance(images: Images) -> float:
    """Return the root mean square difference of two images, mean over all pairs; `ParameterError` below 2 images."""
    if len(images) < 2:
        raise ParameterError.must("images", "be at least 2 to differ", len(images))
    flat = images.reshape(len(images), -1)
    return float(pdist(flat).mean() / np.sqrt(flat.shape[1]))


def image_spread(
    make: Callable[[NDArray[np.float32], NDArray[np.float32]], Images],
    labels: NDArray[np.float32],
    noises: NDArray[np.float32],
    *,
    real: float,
) -> ImageSpread:
    """Return the spread of a generator's images over all pairings of labels and noises.

    ``make`` is called with noises, shape (image, noise), and labels, shape (image, word). At least 2 ``labels`` (label,
    word) and ``noises`` (draw, noise) are needed; ``real`` is the `mean_distance` of real images, > 0.
    """
    images = np.stack([make(noises, np.repeat(label[None], len(noises), 0)) for label in labels])
    by_noise = np.mean([mean_distance(row) for row in images])
    by_label = np.mean([mean_distance(images[:, column]) for column in range(len(noises))])
    return ImageSpread(real, float(by_noise), float(by_label))
