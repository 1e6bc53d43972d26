"""Label of a projection discriminator: it meets the features in an inner product, not among the inputs.

References
----------
- Miyato, T. & Koyama, M. (2018). cGANs with projection discriminator. ICLR. Eq. 3 and Fig. 1d.
"""

from __future__ import annotations

from torch import Tensor, nn


class LabelProjection(nn.Module):
    """``y^T V phi(x)``, to be added to the logit ``psi(phi(x))``; without the paper's spectral normalisation.

    The paper's labels are one-hot; scores of several words at once are a weighted sum of V's rows.
    """

    def __init__(self, features: int, labels: int) -> None:
        super().__init__()
        self.embedding = nn.Linear(labels, features, bias=False)

    def forward(self, features: Tensor, label: Tensor) -> Tensor:
        """Return the products, shape (batch,), of features (batch, feature) and labels (batch, label)."""
        products: Tensor = (self.embedding(label) * features).sum(1)  # B, F -> B
        return products
