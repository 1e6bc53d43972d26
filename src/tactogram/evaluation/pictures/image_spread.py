"""Spread of generated images by noise and by label, which reveals a collapsed generator.

A generator that draws one image for all noises, or ignores its label, is recognised by the differences between its
images, relative to those between real images. The spread says nothing about the quality of an image.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.spatial.distance import pdist

from tactogram.errors import ParameterError

COLLAPSED = 0.1
"""Share of the spread of real images below which generated images count as equal. Ours."""

Images = NDArray[np.float32]
"""Shape (image, 3, row, column), -1 to 1."""


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
        raise ParameterError(f"images must be at least 2 to differ, got {len(images)}")
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
    made = np.stack([make(noises, np.repeat(label[None], len(noises), 0)) for label in labels])
    by_noise = np.mean([mean_distance(row) for row in made])
    by_label = np.mean([mean_distance(made[:, place]) for place in range(len(noises))])
    return ImageSpread(real, float(by_noise), float(by_label))
