"""Layers that take a label: batch normalisation of a generator, projection of a discriminator.

References
----------
- De Vries, H. et al. (2017). Modulating early visual processing by language. NeurIPS 30.
- Miyato, T. & Koyama, M. (2018). cGANs with projection discriminator. ICLR. Eq. 3 and Fig. 1d.
- Neshov, N. et al. (2026). Visual-to-tactile cross-modal generation … Sensors 26, 426. Sec. 3.1.
"""

from __future__ import annotations

import torch
from torch import Tensor, nn


class ConditionalBatchNorm(nn.Module):
    """Batch normalisation whose scale and shift are linear in a label.

    ``gamma(y) (x - mu) / sigma + beta(y)`` with ``gamma(y) = y Wg + bg`` and ``beta(y) = y Wb + bb``.

    mu and sigma are those of each channel over the batch and all places; in use, the running ones of training.
    ``channels`` is the paper's F, ``labels`` its C. Initial weights of the label are from N(0, ``gain``), bg = 1 and
    bb = 0: with a small gain it starts as plain batch normalisation.
    """

    def __init__(self, channels: int, labels: int, *, gain: float = 0.02) -> None:
        super().__init__()
        self.norm = nn.BatchNorm2d(channels, affine=False)
        self.scale = nn.Linear(labels, channels)
        self.shift = nn.Linear(labels, channels)
        nn.init.normal_(self.scale.weight, 0, gain)
        nn.init.ones_(self.scale.bias)
        nn.init.normal_(self.shift.weight, 0, gain)
        nn.init.zeros_(self.shift.bias)

    def forward(self, x: Tensor, label: Tensor) -> Tensor:
        """Return ``x``, (batch, channel, row, column), normalised, scaled and shifted.

        ``label``, (batch, C), is one-hot, or weights of several classes, of which scale and shift are weighted means.
        """
        gamma, beta = self.scale(label), self.shift(label)  # B, F
        normal: Tensor = self.norm(x)
        return torch.addcmul(beta[..., None, None], gamma[..., None, None], normal)


class LabelProjection(nn.Module):
    """Label of a projection discriminator: it meets the features in an inner product, not among the inputs.

    ``y^T V phi(x)``, to be added to the logit ``psi(phi(x))``; without the paper's spectral normalisation.

    The paper's labels are one-hot; scores of several words at once are a weighted sum of V's rows.
    """

    def __init__(self, features: int, labels: int) -> None:
        super().__init__()
        self.embedding = nn.Linear(labels, features, bias=False)

    def forward(self, features: Tensor, label: Tensor) -> Tensor:
        """Return the products, shape (batch,), of features (batch, feature) and labels (batch, label)."""
        products: Tensor = (self.embedding(label) * features).sum(1)  # B, F -> B
        return products
