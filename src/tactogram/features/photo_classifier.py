"""Material of a photograph, by linear discriminant analysis of descriptors of random crops."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from tactogram.errors import ParameterError
from tactogram.features.photo_descriptor import SMALLEST, check_photograph, descriptor
from tactogram.model import Example
from tactogram.signal import Image

CROPS = 24
"""Crops of each photograph that is learned from."""
CROPS_IN_USE = 8
SMALLEST_SHARE = 0.4
"""Least side of a crop, as a share of the shorter side of its photograph."""
GAINS = (0.85, 1.18)
"""Range of the brightness of crops."""


class PhotoClassifier:
    """Probabilities of materials, learned from one photograph each or more.

    Attributes
    ----------
    coefficients : float64 array, shape (material, feature)
    intercepts : float64 array, shape (material,)
        -inf for a material without photographs. All 0 before a fit.
    """

    def __init__(self, materials: Sequence[str]) -> None:
        self.materials = tuple(materials)
        self.coefficients = np.zeros((len(self.materials), 0))
        self.intercepts = np.zeros(len(self.materials))

    @property
    def fitted(self) -> bool:
        """Whether it has seen photographs of at least two materials."""
        return self.coefficients.shape[1] > 0

    def fit(self, photographs: Mapping[str, Sequence[Image]], rng: np.random.Generator) -> None:
        """Learn photographs by material; of fewer than two materials nothing is learned."""
        from sklearn.discriminant_analysis import LinearDiscriminantAnalysis

        shown = [name for name in self.materials if photographs.get(name)]
        if len(shown) < 2:
            return
        rows = [_descriptors(image, CROPS, rng) for name in shown for image in photographs[name]]
        labels = [name for name in shown for _ in range(CROPS * len(photographs[name]))]
        prior = np.full(len(shown), 1 / len(shown))
        fitted = LinearDiscriminantAnalysis(solver="lsqr", shrinkage="auto", priors=prior)
        fitted.fit(np.concatenate(rows), labels)
        self.coefficients = np.zeros((len(self.materials), rows[0].shape[1]))
        self.intercepts = np.full(len(self.materials), -np.inf)
        places = [self.materials.index(name) for name in fitted.classes_]
        if len(shown) == 2:  # of two, scikit-learn gives the difference alone
            self.intercepts[places] = 0, fitted.intercept_[0]
            self.coefficients[places[1]] = fitted.coef_[0]
        else:
            self.intercepts[places], self.coefficients[places] = fitted.intercept_, fitted.coef_

    def probabilities(self, image: Image) -> NDArray[np.float64]:
        """Return the probability of each material, float64, shape (material,): the mean over crops."""
        if not self.fitted:
            raise ParameterError(
                "this run learned no photographs: train it on recordings with photographs of two materials or more"
            )
        rows = _descriptors(image, CROPS_IN_USE, np.random.default_rng(0))
        logits = rows @ self.coefficients.T + self.intercepts
        shares = np.exp(logits - logits.max(1, keepdims=True))
        probabilities: NDArray[np.float64] = (shares / shares.sum(1, keepdims=True)).mean(0)
        return probabilities

    def state(self) -> dict[str, Any]:
        """Return the coefficients."""
        return {"coefficients": self.coefficients, "intercepts": self.intercepts}

    def load_state(self, state: Mapping[str, Any]) -> None:
        """Continue from `state`."""
        self.coefficients, self.intercepts = (
            np.asarray(state[name], np.float64) for name in ("coefficients", "intercepts")
        )


def distinct_photographs(examples: Sequence[Example], most: int) -> list[Image]:
    """Return up to ``most`` photographs of examples, which many of them may share."""
    shared = {id(example.photographs): example.photographs for example in examples}
    found: dict[bytes, Image] = {}
    for photographs in shared.values():
        for k in range(len(photographs)):
            if len(found) == most:
                return list(found.values())
            image = photographs[k]
            found[image.pixels.tobytes()] = image
    return list(found.values())


def _descriptors(image: Image, count: int, rng: np.random.Generator) -> NDArray[np.float64]:
    """Return descriptors of square crops, turned, mirrored and brighter or darker, float64, shape (crop, feature)."""
    check_photograph(image)
    shorter, rows = min(image.size), []
    for _ in range(count):
        side = max(SMALLEST, int(shorter * rng.uniform(SMALLEST_SHARE, 1)))
        top, left = (int(rng.integers(length - side + 1)) for length in image.size)
        pixels = np.rot90(image.pixels[top : top + side, left : left + side], int(rng.integers(4)))
        if rng.random() < 0.5:
            pixels = pixels[:, ::-1]
        pixels = np.clip(pixels * rng.uniform(*GAINS), 0, 255).astype(np.uint8)
        rows.append(descriptor(Image(np.ascontiguousarray(pixels))))
    return np.array(rows)
