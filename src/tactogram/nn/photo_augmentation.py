"""Photograph augmentation, for classifiers trained on few photographs.

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
"""Area, and height by width, of erased rectangles: as in torchvision's RandomErasing, after Zhong et al."""


def moved(photo: Tensor, *, scale: float, rotation_deg: float, rng: np.random.Generator) -> Tensor:
    """Return photographs, (item, channel, row, column), scaled up, cropped to their size, flipped and rotated.

    Each has its own draw: factors are uniform in 1 to ``scale``, angles in plus or minus ``rotation_deg``, the crop is
    anywhere. One bilinear look-up does all; areas from outside the photograph are reflected.
    """
    count = len(photo)
    factor = rng.uniform(1, scale, count)
    angle = np.deg2rad(rng.uniform(-rotation_deg, rotation_deg, count))
    flip = rng.choice([-1.0, 1.0], (count, 2))
    shift = rng.uniform(-1, 1, (count, 2)) * (1 - 1 / factor)[:, None]
    theta = np.empty((count, 2, 3))  # from places of the result to places of the photograph
    theta[:, 0] = np.stack((flip[:, 0] * np.cos(angle), -flip[:, 0] * np.sin(angle), shift[:, 0] * factor), 1)
    theta[:, 1] = np.stack((flip[:, 1] * np.sin(angle), flip[:, 1] * np.cos(angle), shift[:, 1] * factor), 1)
    places = torch.from_numpy(theta / factor[:, None, None]).to(photo)
    grid = F.affine_grid(places, list(photo.shape), align_corners=False)  # item, row, column, 2
    return F.grid_sample(photo, grid, mode="bilinear", padding_mode="reflection", align_corners=False)


def erased(photo: Tensor, *, share: float, rng: np.random.Generator) -> Tensor:
    """Return photographs, (item, channel, row, column), -1 to 1, a ``share`` with a rectangle of mean gray (0)."""
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
    """Return ``l x + (1 - l) x'`` of photographs, (item, …), and of labels, (item, class), l from Beta(alpha, alpha).

    x' is another item. ``alpha`` 0 changes nothing.
    """
    if not alpha:
        return photo, label
    share = float(rng.beta(alpha, alpha))
    other = torch.from_numpy(rng.permutation(len(photo)))
    return share * photo + (1 - share) * photo[other], share * label + (1 - share) * label[other]
