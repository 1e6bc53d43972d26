"""Scores that rated examples predict of what a generator makes: kernel ridge regression, fitted in closed form."""

from __future__ import annotations

import torch
from torch import Tensor

from tactogram.errors import ParameterError

RIDGE = 0.1
"""Added to the kernel of an example with itself, which is 1."""


class ScoreRegression:
    """Regression from features, (example, feature), to scores of 0 to 1, (example, word); differentiable.

    Its kernel is 1 / (1 + d^2 / 2), d the distance of standardised features in median distances of the examples (the
    rational quadratic one). What is unlike all examples gets nearly their mean scores, but has a gradient towards them.
    Features are in units of about what is noticed; one that varies less among the examples counts by its unit.

    Raises `ParameterError` if the examples do not differ in features and scores.
    """

    def __init__(self, features: Tensor, scores: Tensor) -> None:
        self.mean, self.spread = features.mean(0), features.std(0, correction=0).clamp_min(1.0)
        self.examples = (features - self.mean) / self.spread
        self.means, self.variance = scores.mean(0), scores.var(0, correction=0).mean()
        self.width = torch.pdist(self.examples).median()
        if not self.variance * self.width > 0:
            raise ParameterError(
                f"rated examples must differ in themselves and in their scores to predict these, got {len(scores)}"
            )
        kernel = self._kernel(features)
        ridge = RIDGE * torch.eye(len(kernel)).to(kernel)
        self.coefficients = torch.linalg.solve(kernel + ridge, scores - self.means)

    def __call__(self, features: Tensor) -> Tensor:
        """Return scores, (item, word), of features (item, feature)."""
        scores: Tensor = self._kernel(features) @ self.coefficients + self.means
        return scores

    def loss(self, features: Tensor, scores: Tensor) -> Tensor:
        """Return the mean squared error of the scores of ``features``, over the variance of the examples' scores."""
        return (self(features) - scores).square().mean() / self.variance

    def _kernel(self, features: Tensor) -> Tensor:
        x = (features - self.mean) / self.spread
        return 1 / (1 + (x[:, None] - self.examples).square().sum(2) / (2 * self.width**2))
