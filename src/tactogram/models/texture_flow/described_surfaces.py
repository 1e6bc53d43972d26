"""Surfaces described by a photograph, an English name and words: kernel ridge regression on a run's own materials.

Ridge regression is linear in what it predicts, so every principal component of a surface is the same weighted sum of
those of the materials, at any speed and force. The weights sum to 1; some may be negative. Widths of the kernels, ridge
and shares of the inputs are those of the least error on materials left out one by one (PRESS, in closed form; Allen
1974, Technometrics 16, 125-127). What the inputs explain is measured on materials that had no part in this choice;
where that may be nothing, the surface is the mean of all.

What no input explains is a material's own. A photograph so near to one of a known material that it must show it has
that, too: the material is recognised, and weighs the more.
"""

from __future__ import annotations

from collections.abc import Sequence
from functools import cache, lru_cache
from itertools import product
from typing import Any

import numpy as np
import torch
from numpy.typing import NDArray
from scipy.spatial import KDTree
from scipy.spatial.distance import cdist
from scipy.special import softmax
from scipy.stats import t as student

from tactogram.errors import MissingExtraError, ParameterError
from tactogram.features.photo_descriptor import check_photograph, descriptor
from tactogram.features.text_classifier import embedded
from tactogram.model import Saved
from tactogram.models.texture_flow.surfaces import Surface
from tactogram.nn.trunks import Trunk
from tactogram.signal import Image

Array = NDArray[np.float64]

BANDS = 20
"""Of the spectra that are predicted, evenly spaced in the logarithm."""
LEAST_MATERIALS = 10
"""Fewer do not tell what their photographs and names explain."""
WIDTHS = (0.5, 1.0, 2.0)
"""Of the Gaussian kernels, in median distances between materials."""
RIDGES = (0.01, 0.03, 0.1, 0.3, 1.0, 3.0)
SHARES = 4
"""Steps in which the inputs share the kernel."""
FOLDS = 10
CROP, CROPS = 224, 3
"""Side of the squares that a trunk sees of a photograph, in its own pixels, and how many are along each side."""
SAME, SHARPNESS = 0.8, 12
"""A photograph is as likely as not of a material if it is this share as far from one of it as the nearest of another
material. Of 100 real photographs, 95 halves were nearer than 0.78 to the other half; of the whole ones, with their own
material left out, 90 were farther than 0.82 from all others."""
LEAST_SIMILARITY = 0.3
"""Cosine of embeddings below which a text is like no material's name."""
LEAST = 1e-12
"""Squared distance, above 0."""

Prediction = tuple[Array, dict[str, Any]]
"""Weights of materials, float64, (material,), sum 1, and facts as of `tactogram.model.Model.prediction_facts`."""


class DescribedSurfaces(Saved):
    """Photographs, names and spectra of materials, and the regression from the former to the latter."""

    saved = ("spectra", "photographs", "shown", "trunk")

    def __init__(self, materials: Sequence[str]) -> None:
        self.materials = tuple(materials)
        self.spectra = np.zeros((0, 0))
        """dB, shape (material, axis and band)."""
        self.photographs, self.shown = np.zeros((0, 0), np.float32), np.zeros(0, np.int64)
        """Features, shape (photograph, feature), and the number of the material that each photograph shows."""
        self.trunk = False
        """Whether the features are a network's; they are `descriptor`'s without the extra ``vision``."""
        self._last: tuple[Any, Prediction] | None = None

    def fit(self, surfaces: Sequence[Surface], photographs: Sequence[Sequence[Image]]) -> None:
        """Learn the surfaces of the materials, and their photographs, if they are of two or more."""
        self.spectra = np.array([_spectrum(surface) for surface in surfaces])
        shown = [(number, image) for number, members in enumerate(photographs) for image in members]
        if len({number for number, _ in shown}) < 2:
            return
        try:
            self.trunk = _trunk().frozen
        except MissingExtraError:
            self.trunk = False
        self.shown = np.array([number for number, _ in shown])
        self.photographs = np.array([_features(image, self.trunk) for _, image in shown])

    def recognised(self, image: Image) -> Array:
        """Return how likely a photograph shows the material of the nearest, float64, shape (material,), others 0."""
        if not len(self.shown):
            raise ParameterError("this run learned no photographs of two materials or more")
        known, seen = self._scaled(image)
        ratios = np.full(len(self.materials), np.inf)
        for number in np.unique(self.shown):
            own = self.shown == number
            ratios[number] = cdist(seen, known[own]).min() / max(cdist(known[own], known[~own]).min(), LEAST)
        return np.asarray(np.eye(len(ratios))[ratios.argmin()] / (1 + (ratios.min() / SAME) ** SHARPNESS))

    def predict(self, image: Image | None, text: str | None, rated: Array, scores: Array) -> Prediction:
        """Return the weights of the materials in the surface that a photograph, a text, scores, or some describe.

        ``rated``, (material, word), and ``scores``, (word,), are 0 to 1, NaN if unknown.
        """
        asked = image, text, scores.tobytes(), id(self.spectra)
        if self._last is not None and self._last[0] == asked:
            return self._last[1]
        count, inputs = len(self.materials), dict[str, Array]()  # by material; in the last row, as asked
        if image is not None:
            known, seen = self._scaled(image)
            inputs["image"] = np.full((count + 1, known.shape[1]), np.nan)
            inputs["image"][-1] = seen[0]
            for number in np.unique(self.shown):
                inputs["image"][number] = known[self.shown == number].mean(0)
        if text is not None:
            inputs["text"] = embedded([*self.materials, text]).astype(np.float64)
            unlike = bool((inputs["text"][:-1] @ inputs["text"][-1]).max() < LEAST_SIMILARITY)
        if (given := np.isfinite(scores)).any():
            inputs["words"] = np.vstack((rated[:, given], scores[given]))
        whole = np.all([np.isfinite(table).all(1) for table in inputs.values()], axis=0)
        regression, facts = _regression([table[whole] for table in inputs.values()], self.spectra[whole[:-1]])
        weights = np.full(count, 1 / count if facts["mean"] else 0.0)
        if not facts["mean"]:
            weights[whole[:-1]] = regression
        if image is not None:
            likely = self.recognised(image)
            if count < LEAST_MATERIALS:  # too few for a regression: a photograph is of the nearest of them
                likely, facts = likely / likely.sum(), {"mean": False, "nearest": True}
            weights = likely + (1 - likely.sum()) * weights
        facts = {"given": list(inputs), "materials": int(whole.sum()) - 1, **facts}
        facts |= {"unlike": unlike} if text is not None else {}
        self._last = asked, (weights, facts)
        return weights, facts

    def _scaled(self, image: Image) -> tuple[Array, Array]:
        """Return the features of known photographs, and of one, upright and turned; descriptors by their spread."""
        spread = np.float64(1) if self.trunk else self.photographs.std(0, dtype=np.float64).clip(1e-6)
        return self.photographs / spread, _seen(image, self.trunk) / spread


def _regression(inputs: Sequence[Array], spectra: Array) -> tuple[Array, dict[str, Any]]:
    """Return weights of materials, (material,), and facts; of each input the last row, after materials, is asked."""
    if len(spectra) < LEAST_MATERIALS:
        return np.zeros(len(spectra)), {"mean": True}
    squares = [cdist(table[:-1], table, "sqeuclidean") for table in inputs]
    squares = [each / max(np.median(each[np.triu_indices(len(each), 1)]), LEAST) for each in squares]
    shares = [each for each in product(range(SHARES + 1), repeat=len(inputs)) if sum(each) == SHARES]
    gaussians = [np.exp(np.divide(squares, -2 * width**2)) for width in WIDTHS]
    kernels = [np.tensordot(np.divide(share, SHARES), each, 1) for each in gaussians for share in shares]
    errors, every = np.empty((2, len(spectra))), np.arange(len(spectra))
    for fold in range(FOLDS):
        left, rest = every[every % FOLDS == fold], every[every % FOLDS != fold]
        kernel, ridge = _chosen(kernels, spectra, rest)
        predicted = _weights(kernel[np.ix_(rest, rest)], kernel[np.ix_(rest, left)], ridge) @ spectra[rest]
        for row, estimate in zip(errors, (spectra[rest].mean(0), predicted), strict=True):
            row[left] = np.square(spectra[left] - estimate).mean(1)
    gain = (errors[0] - errors[1]) / errors[0].mean().clip(LEAST)
    reach = student.ppf(0.975, len(gain) - 1) * gain.std(ddof=1) / len(gain) ** 0.5
    mean = bool(gain.mean() <= reach)
    kernel, ridge = _chosen(kernels, spectra, every)
    return _weights(kernel[:, :-1], kernel[:, -1:], ridge)[0], {
        "mean": mean,
        "explained": round(float(gain.mean()), 3),
        "explained_range": [round(float(gain.mean() + side), 3) for side in (-reach, reach)],
        "error_db": round(float(errors[int(not mean)].mean() ** 0.5), 2),
    }


def _chosen(kernels: Sequence[Array], spectra: Array, places: NDArray[np.intp]) -> tuple[Array, float]:
    """Return the kernel and ridge whose squared residuals of materials left out one by one are least."""
    centred, best = spectra[places] - spectra[places].mean(0), (np.inf, 0, RIDGES[-1])
    for number, kernel in enumerate(kernels):
        own = kernel[np.ix_(places, places)]
        values, vectors = np.linalg.eigh(own - own.mean(0) - own.mean(1)[:, None] + own.mean())
        projected = vectors.T @ centred
        for ridge in RIDGES:
            inverse = 1 / (values.clip(0) + ridge)
            diagonal = vectors**2 @ inverse - 1 / (len(places) * ridge)  # the mean is not penalised
            residuals = vectors @ (inverse[:, None] * projected) / diagonal[:, None]
            best = min(best, (float(np.square(residuals).sum()), number, ridge))
    return kernels[best[1]], best[2]


def _weights(known: Array, asked: Array, ridge: float) -> Array:
    """Return weights, (asked, material), each summing to 1, from kernels (material, material), (material, asked)."""
    ones = np.ones((len(known), 1))
    solution, ones = np.split(
        np.linalg.solve(known + ridge * np.eye(len(known)), np.hstack((asked, ones))), [-1], 1
    )
    return np.asarray((solution + ones * (1 - solution.sum(0)) / ones.sum()).T)


def _spectrum(surface: Surface) -> Array:
    """Return the power of each axis in bands, dB, shape (axis and band,)."""
    power = surface.root.abs().square().sum(2).double().numpy()  # K, A
    edges = np.unique(np.geomspace(1, len(power) + 1, BANDS + 1).round().astype(int)) - 1
    means = np.add.reduceat(power, edges[:-1]) / np.diff(edges)[:, None]
    return np.asarray(10 * np.log10(means.clip(np.finfo(float).tiny)).ravel())


@lru_cache(maxsize=2)
def _seen(image: Image, trunk: bool) -> NDArray[np.float32]:
    turned = Image(np.rot90(image.pixels))
    return np.array([_features(each, trunk) for each in (image, turned)])


def _features(image: Image, trunk: bool) -> NDArray[np.float32]:
    """Return features of a photograph, float32, (feature,): of a trunk, the roots of their means over crops."""
    check_photograph(image)
    if not trunk:
        return descriptor(image).astype(np.float32)
    side = min(CROP, *image.size)
    rows, columns = (np.unique(np.linspace(0, n - side, CROPS).astype(int)) for n in image.size)
    crops = np.array([image.pixels[a : a + side, b : b + side] for a in rows for b in columns])
    with torch.inference_mode():
        maps = _trunk()(torch.from_numpy(crops).permute(0, 3, 1, 2).float() / 127.5 - 1)
    return np.asarray(maps.mean(0).clamp_min(0).sqrt())


@cache
def _trunk() -> Trunk:
    trunk = Trunk("efficientnet_lite0")
    trunk.load()
    return trunk


WIDTH = 0.5
"""Of the kernel, as a share of the median distance of rated surfaces from their nearest neighbour in words."""


def word_weights(rated: NDArray[np.float64], scores: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return a weight of each rated surface, float64, shape (surface,), by its distance in words; they sum to 1.

    The weights are those of kernel regression (Nadaraya 1964; Watson 1964) with a Gaussian: narrow, as surfaces of like
    scores can be unlike each other, and a mix of them like none.

    Parameters
    ----------
    rated : float64 array, shape (surface, word)
        Mean scores, 0 to 1; NaN where nobody gave any. Surfaces that lack one of the words asked weigh nothing.
    scores : float64 array, shape (word,)
        Those asked, 0 to 1; NaN if any will do.

    Raises
    ------
    ParameterError
        If no score is asked, or no surface was rated in all the words.
    """
    asked = np.isfinite(scores)
    whole = np.isfinite(rated[:, asked]).all(1)
    if not asked.any() or not whole.any():
        raise ParameterError.must("words", "be at least one that a surface was rated in, got none")
    known = rated[np.ix_(whole, asked)]
    nearest = np.median(KDTree(known).query(known, k=2)[0][:, 1])
    width = max(WIDTH * float(nearest), np.finfo(float).eps)
    weights = np.zeros(len(rated))
    weights[whole] = softmax(-np.sum((known - scores[asked]) ** 2, axis=1) / (2 * width**2))
    return weights
