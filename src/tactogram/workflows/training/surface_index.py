"""Search index of a run: recordings as vectors, and the distance beyond which a surface is none of them.

The vector of a recording is its embedding by the classifier, averaged over its windows and scaled to length 1, and its
level in half octaves: the embedding keeps what tells the known materials apart, and the spectrum shows what is unlike
all of them. Both count alike, or the spectrum more if recordings that the classifier was not trained on are then more
often next to one of their material, as where each was stroked at several speeds. Distances are Euclidean after the
vectors were whitened by how recordings of one material differ (within-class covariance normalisation, Hatch, Kajarekar
and Stolcke 2006), so that a direction counts by what it says about the material. A recording is "none of these" when
its nearest neighbour (Sun et al. 2022, "Out-of-distribution detection with deep nearest neighbors") is beyond the
`prediction_limit` of recordings of known materials that the classifier was not trained on.
"""

from __future__ import annotations

from collections.abc import Sequence
from itertools import pairwise
from typing import Annotated, Any

import numpy as np
from numpy.typing import NDArray
from pydantic import Field
from scipy.linalg import solve_triangular
from scipy.signal import welch
from scipy.stats import t as student
from typing_extensions import TypedDict

from tactogram.errors import DataError, ParameterError, RunError
from tactogram.model import Example, Model
from tactogram.signal import Signal
from tactogram.signal.io.archives import decoding
from tactogram.signal.io.atomic import atomic_write
from tactogram.training.run import Run

INDEX_FILES = ("search-vectors.npy", "search-whitening.npy", "search.json")
KEPT = 0.95
"""Share of recordings of known materials that the threshold accepts."""
LEAST_DISTANCE = 0.01
"""Smaller distances set the threshold as this one: copies of a recording have the distance 0 and no logarithm."""
BANDS = 12
"""Half octaves below half the sampling rate whose levels are part of a vector."""
WINDOW = 256
"""Samples of a window of the spectrum."""
WEIGHTS = (1.0, 3.0, 10.0)
"""Lengths of a vector of levels beside an embedding of length 1, of which one is chosen."""
LEAST_LEVEL = 1e-12
"""Share of the power that counts as silence in a band."""
LEAST_SD_DB = 1.0
"""A band whose level varies less counts as if it varied so much."""


class _SearchFacts(TypedDict):
    ids: list[str]
    materials: list[str]
    threshold: Annotated[float, Field(gt=0)]
    calibrated_on: int


class SurfaceIndex:
    """Recordings as vectors, and the distance beyond which something is none of them.

    ``vectors`` are float32, shape (recording, feature), as of `surface_vector`; ``whitening``, float32, shape (feature,
    feature), is that of `whitening_of`; ``threshold`` is a distance in its unit, set by ``calibrated_on`` recordings.
    """

    def __init__(
        self,
        vectors: NDArray[np.float32],
        ids: Sequence[str],
        materials: Sequence[str],
        *,
        whitening: NDArray[np.float32],
        threshold: float,
        calibrated_on: int,
    ) -> None:
        self.ids, self.materials = list(ids), list(materials)
        self.whitening, self.threshold, self.calibrated_on = whitening, threshold, calibrated_on
        self.whitened = vectors @ whitening

    def nearest(self, vector: NDArray[np.float32], count: int) -> list[dict[str, Any]]:
        """Return the ``count`` nearest recordings: ``id``, ``material``, ``distance`` in the unit of `whitening_of`."""
        distances = np.linalg.norm(self.whitened - vector @ self.whitening, axis=1)
        count = min(count, len(distances))
        places = np.argpartition(distances, count - 1)[:count]
        return [
            {"id": self.ids[index], "material": self.materials[index], "distance": float(distances[index])}
            for index in places[np.argsort(distances[places])]
        ]

    def novelty(self, vector: NDArray[np.float32]) -> float:
        """Return the distance to the nearest recording over the threshold: above 1 is none of these."""
        (nearest,) = self.nearest(vector, 1)
        return float(nearest["distance"] / self.threshold)

    def save(self, run: Run) -> None:
        """Write ``search-vectors.npy``, ``search-whitening.npy`` and ``search.json`` into the run."""
        for name, array in (("search-vectors.npy", self.whitened), ("search-whitening.npy", self.whitening)):
            with atomic_write(run.folder / name) as part, part.open("wb") as opened:
                np.save(opened, array, allow_pickle=False)
        run.write_json(
            "search.json",
            {
                "ids": self.ids,
                "materials": self.materials,
                "threshold": self.threshold,
                "kept": KEPT,
                "calibrated_on": self.calibrated_on,
            },
        )

    @classmethod
    def load(cls, run: Run) -> SurfaceIndex:
        """Return the index of ``run``.

        Raises
        ------
        RunError
            If the run has none, because only classifiers trained with `tactogram train` have one, or if it is damaged.
        """
        file = run.folder / "search.json"
        if not file.is_file():
            raise RunError(f"{run.folder}: has no search index; search needs a trained classifier")
        facts = run.read_json("search.json", _SearchFacts)
        index = cls.__new__(cls)
        index.ids, index.materials = facts["ids"], facts["materials"]
        index.threshold, index.calibrated_on = facts["threshold"], facts["calibrated_on"]
        for name, attribute in zip(INDEX_FILES, ("whitened", "whitening"), strict=False):
            with run.refusing(), decoding(run.folder / name, "not readable"):
                matrix = np.load(run.folder / name, allow_pickle=False)
                if matrix.ndim != 2 or matrix.dtype != np.float32 or not np.isfinite(matrix).all():
                    raise DataError("must be a matrix of finite numbers")
                setattr(index, attribute, matrix)
        count, features = index.whitened.shape
        if (
            not 0 < count == len(index.ids) == len(index.materials)
            or index.whitening.shape != (features,) * 2
        ):
            raise RunError(f"{run.folder / 'search-vectors.npy'}: does not match search.json")
        return index


def build_index(embedder: Model, known: Sequence[Example], validation: Sequence[Example]) -> SurfaceIndex:
    """Return an index over ``known``, with weight of the levels and threshold set by ``validation``.

    The latter are recordings of known materials that ``embedder`` was not trained on. If there are none, the levels
    count as the embedding, and each known recording is compared with the others, which is optimistic.

    Raises
    ------
    ParameterError
        If ``known`` is empty.
    """
    if not known:
        raise ParameterError("an index needs at least one recording, got none")
    vectors = surface_vectors(embedder, known)
    ids, materials = [e.id for e in known], [str(e.material) for e in known]
    held = list(surface_vectors(embedder, validation)) if len(validation) else []
    true = [str(example.material) for example in validation]

    def weighted(weight: float) -> SurfaceIndex:
        return SurfaceIndex(
            vectors,
            ids,
            materials,
            whitening=whitening_of(
                vectors, materials, levels=BANDS * len(known[0].signal.axes), weight=weight
            ),
            threshold=1.0,
            calibrated_on=len(validation),
        )

    def right(index: SurfaceIndex) -> int:
        return sum(index.nearest(v, 1)[0]["material"] == name for v, name in zip(held, true, strict=True))

    index = max(map(weighted, WEIGHTS), key=right)  # the first of equals
    if len(validation):
        distances = [index.novelty(vector) for vector in held]
    else:
        # The nearest of each is itself.
        distances = [index.nearest(vector, 2)[-1]["distance"] for vector in vectors]
    index.threshold = prediction_limit(distances)
    return index


def whitening_of(
    vectors: NDArray[np.float32], materials: Sequence[str], *, levels: int = 0, weight: float = 1.0
) -> NDArray[np.float32]:
    """Return the matrix, float32, shape (feature, feature), after which distances compare recordings with materials.

    The last ``levels`` features are in dB; together they count as a vector of length ``weight``, the others as one of
    length 1.

    ``vectors @ matrix`` have equal variance within materials in all directions, as far as few recordings can tell:
    half of the covariance is that of the recordings about the mean of their material, the other half is a multiple of
    the identity. Distance 1 is the root mean square distance of two of these recordings of one material; of any two, if
    no material has several.
    """
    names, of = np.unique(materials, return_inverse=True)
    scale = np.ones(vectors.shape[1])
    if levels:
        scale[-levels:] = weight / np.sqrt(levels) / np.maximum(vectors[:, -levels:].std(axis=0), LEAST_SD_DB)
    wide = vectors.astype(np.float64) * scale
    freedom = len(wide) - len(names)
    if freedom < 1:
        of, freedom = np.zeros_like(of), max(len(wide) - 1, 1)
    means = np.stack([wide[of == each].mean(axis=0) for each in range(of.max() + 1)])
    residuals = wide - means[of]
    covariance = residuals.T @ residuals / freedom
    variance = np.trace(covariance) / len(covariance)
    if variance == 0:
        return np.diag(scale).astype(np.float32)
    triangle = np.linalg.cholesky(covariance + variance * np.eye(len(covariance)))
    whitening = solve_triangular(triangle, np.eye(len(covariance)), lower=True).T
    unit = np.sqrt(2 * np.sum((residuals @ whitening) ** 2) / freedom)
    matrix: NDArray[np.float32] = (scale[:, None] * whitening / unit).astype(np.float32)
    return matrix


def prediction_limit(distances: Sequence[float]) -> float:
    """Return the distance within which a new recording is with probability `KEPT`.

    The one-sided prediction limit of one more draw from a log-normal distribution (Hahn and Meeker, "Statistical
    Intervals", 1991). Of the few dozen recordings in a validation part, the quantile is one of the greatest distances,
    which varies much more, and it cannot keep `KEPT` of new recordings if there are fewer than 19. A single distance
    is its own limit.
    """
    count = len(distances)
    if count < 2:
        return float(distances[0])
    logs = np.log(np.maximum(distances, LEAST_DISTANCE))
    spread = np.std(logs, ddof=1) * np.sqrt(1 + 1 / count)
    return float(np.exp(np.mean(logs) + student.ppf(KEPT, count - 1) * spread))


def calibration_text(recordings: int) -> str:
    """Return a sentence on the calibration of "none of these"."""
    if recordings:
        return f"The threshold was set on {recordings} recordings that were not trained on."
    return "The threshold was set on the training recordings, each against the others, which is optimistic."


def surface_vectors(embedder: Model, examples: Sequence[Example]) -> NDArray[np.float32]:
    """Return the vector of each example: float32, shape (example, feature)."""
    return np.stack([surface_vector(embedder, example.signal) for example in examples])


def surface_vector(embedder: Model, signal: Signal) -> NDArray[np.float32]:
    """Return the embedding of a signal, scaled to length 1, and the levels of its bands: float32, shape (feature,)."""
    embedded = embedder.embed(signal)
    unit = embedded / max(float(np.linalg.norm(embedded)), 1e-12)
    return np.concatenate([unit, band_levels(signal)]).astype(np.float32)


def band_levels(signal: Signal) -> NDArray[np.float64]:
    """Return the level of each axis in `BANDS` half octaves below half the rate, highest first, dB: shape (level,)."""
    length = min(WINDOW, len(signal))
    frequency, power = welch(signal.samples.astype(np.float64), nperseg=length, nfft=WINDOW)
    edges = 0.5 * 2.0 ** (-np.arange(BANDS + 1) / 2)
    sums = [power[:, (low < frequency) & (frequency <= high)].sum(axis=1) for high, low in pairwise(edges)]
    bands = np.stack(sums, axis=1)
    least = LEAST_LEVEL * bands.sum(axis=1, keepdims=True) + np.finfo(float).tiny
    levels: NDArray[np.float64] = 10 * np.log10(np.maximum(bands, least)).ravel()
    return levels
