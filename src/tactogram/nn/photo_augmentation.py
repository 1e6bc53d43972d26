"""Photograph augmentation, for classifiers that must learn the surface from few pictures.

References
----------
- Zhong, Z. et al. (2020). Random erasing data augmentation. AAAI.
- Zhang, H. et al. (2018). mixup: beyond empirical risk minimization. ICLR.
"""

from __future__ import annotations

import math

import numpy as np
import torch
import torch.nn.functional as F
from torch import Tensor

ERASED_SHARE, ERASED_RATIO = (0.02, 0.33), (0.3, 3.3)
"""Area, and height by width, of what is erased: as torchvision's RandomErasing has them, after Zhong et al."""


def moved(photo: Tensor, *, scale: float, rotation_deg: float, rng: np.random.Generator) -> Tensor:
    """Return photographs scaled up, cropped back to their size, flipped and rotated, each by its own draw.

    One bilinear look-up for all of it; what a rotation brings in from outside is reflected.

    Parameters
    ----------
    photo : float Tensor, shape (item, channel, row, column)
    scale : float
        Factors are uniform in 1 to ``scale``; the crop is anywhere in what was scaled.
    rotation_deg : float
        Angles are uniform in plus or minus so much.
    """
    count = len(photo)
    factor = rng.uniform(1, scale, count)
    angle = np.deg2rad(rng.uniform(-rotation_deg, rotation_deg, count))
    flip = rng.choice([-1.0, 1.0], (count, 2))
    shift = rng.uniform(-1, 1, (count, 2)) * (1 - 1 / factor)[:, None]
    theta = np.empty((count, 2, 3))  # where in the photograph each place of the result is looked up
    theta[:, 0] = np.stack((flip[:, 0] * np.cos(angle), -flip[:, 0] * np.sin(angle), shift[:, 0] * factor), 1)
    theta[:, 1] = np.stack((flip[:, 1] * np.sin(angle), flip[:, 1] * np.cos(angle), shift[:, 1] * factor), 1)
    places = torch.from_numpy(theta / factor[:, None, None]).to(photo)
    grid = F.affine_grid(places, list(photo.shape), align_corners=False)  # item, row, column, 2
    return F.grid_sample(photo, grid, mode="bilinear", padding_mode="reflection", align_corners=False)


def erased(photo: Tensor, *, share: float, rng: np.random.Generator) -> Tensor:
    """Return photographs of which a ``share`` have a rectangle of mean gray (0) somewhere.

    Parameters
    ----------
    photo : float Tensor, shape (item, channel, row, column), -1 to 1
    """
    photo = photo.clone()
    rows, columns = photo.shape[-2:]
    for item in photo:
        area = rng.uniform(*ERASED_SHARE) * rows * columns
        ratio = math.exp(rng.uniform(*np.log(ERASED_RATIO)))
        height, width = (
            min(max(1, round(side)), most)
            for side, most in ((math.sqrt(area * ratio), rows), (math.sqrt(area / ratio), columns))
        )
        top, left = int(rng.integers(rows - height + 1)), int(rng.integers(columns - width + 1))
        if rng.random() < share:
            item[:, top : top + height, left : left + width] = 0
    return photo


def mixed(photo: Tensor, label: Tensor, *, alpha: float, rng: np.random.Generator) -> tuple[Tensor, Tensor]:
    """Return ``l x + (1 - l) x'`` of photographs and of labels, x' another item, l of Beta(alpha, alpha).

    Parameters
    ----------
    photo : float Tensor, shape (item, …)
    label : float Tensor, shape (item, class)
        One-hot, or shares that sum to 1.
    alpha : float
        0 leaves all as it is.
    """
    if not alpha:
        return photo, label
    share = float(rng.beta(alpha, alpha))
    other = torch.from_numpy(rng.permutation(len(photo)))
    return share * photo + (1 - share) * photo[other], share * label + (1 - share) * label[other]
