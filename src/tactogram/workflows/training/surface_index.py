"""Search index of a run: embedded recordings, and the distances beyond which a surface is none of them.

A recording is embedded as the last hidden layer of the classifier averaged over its windows, scaled to length 1.
Distances are Euclidean after the embeddings were whitened by how recordings of one material differ (within-class
covariance normalisation, Hatch, Kajarekar and Stolcke 2006), so that a direction counts by what it says about the
material. A recording is "none of these" when its nearest neighbour (Sun et al. 2022, "Out-of-distribution detection
with deep nearest neighbors") is too far for a recording of that neighbour's material: relative to how far apart the
material's own recordings are, it is beyond the `prediction_limit` of recordings of known materials that the network was
not trained on.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from statistics import mean
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy.linalg import solve_triangular
from scipy.stats import t as student
from usearch.index import Index

from tactogram.errors import ParameterError, RunError
from tactogram.model import Embedder, Example
from tactogram.signal.io.atomic import atomic_write
from tactogram.training.run import Run

VERSION = 2
KEPT = 0.95
"""Share of recordings of known materials that the thresholds accept."""
LEAST_DISTANCE = 0.01
"""Smaller distances set a threshold as this one: copies of a recording have the distance 0 and no logarithm."""
EXACT_BELOW = 20_000
"""Largest number of recordings for exact search; beyond it the index's graph is searched."""


class SurfaceIndex:
    """Embedded recordings, and the distances beyond which something is none of them.

    ``vectors`` are float32, shape (recording, feature), of length 1; ``whitening``, float32, shape (feature, feature),
    is that of `whitening_of`; ``thresholds`` are distances in its unit, by material, set by ``calibrated_on``
    recordings.
    """

    def __init__(
        self,
        vectors: NDArray[np.float32],
        ids: Sequence[str],
        materials: Sequence[str],
        *,
        whitening: NDArray[np.float32],
        thresholds: Mapping[str, float],
        calibrated_on: int,
    ) -> None:
        self.ids, self.materials = list(ids), list(materials)
        self.whitening, self.thresholds, self.calibrated_on = whitening, dict(thresholds), calibrated_on
        self.index: Any = Index(ndim=vectors.shape[1], metric="l2sq", dtype="f32")
        self.index.add(np.arange(len(vectors)), vectors @ whitening)

    def nearest(self, vector: NDArray[np.float32], count: int) -> list[dict[str, Any]]:
        """Return the ``count`` nearest recordings: ``id``, ``material``, ``distance``, ``threshold``.

        The last two are in the unit of `whitening_of`. What is farther from the nearest recording than ``threshold``
        is none of these. A material that was not trained on, in the index of another store, has their mean.
        """
        exact = len(self.ids) <= EXACT_BELOW
        found: Any = self.index.search(_unit(vector) @ self.whitening, min(count, len(self.ids)), exact=exact)
        other = mean(self.thresholds.values())
        return [
            {
                "id": self.ids[int(key)],
                "material": (material := self.materials[int(key)]),
                "distance": float(distance),
                "threshold": self.thresholds.get(material, other),
            }
            for key, distance in zip(found.keys, np.sqrt(found.distances), strict=True)
        ]

    def novelty(self, vector: NDArray[np.float32]) -> float:
        """Return the distance to the nearest recording over its threshold: above 1 is none of these."""
        (nearest,) = self.nearest(vector, 1)
        return float(nearest["distance"] / nearest["threshold"])

    def save(self, run: Run) -> None:
        """Write ``search.usearch``, ``search-whitening.npy`` and ``search.json`` into the run."""
        with atomic_write(run.folder / "search.usearch") as part:
            self.index.save(str(part))
        with atomic_write(run.folder / "search-whitening.npy") as part, part.open("wb") as opened:
            np.save(opened, self.whitening, allow_pickle=False)
        run.write_json(
            "search.json",
            {
                "version": VERSION,
                "ids": self.ids,
                "materials": self.materials,
                "thresholds": self.thresholds,
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
            If the run has none, because only classifiers trained with `tactogram train` have one, or if it is damaged
            or of another version.
        """
        file = run.folder / "search.json"
        if not file.is_file():
            raise RunError(f"{run.folder}: has no search index; search needs a trained classifier")
        facts = run.read_json("search.json")
        if facts["version"] != VERSION:
            raise RunError(f"{file}: must be of version {VERSION}, got {facts['version']}; train again")
        found = cls.__new__(cls)
        found.ids, found.materials = facts["ids"], facts["materials"]
        found.thresholds, found.calibrated_on = facts["thresholds"], facts["calibrated_on"]
        for name in ("search.usearch", "search-whitening.npy"):
            try:
                if name == "search.usearch":
                    found.index = Index.restore(str(run.folder / name))
                else:
                    found.whitening = np.load(run.folder / name, allow_pickle=False)
            except (OSError, RuntimeError, ValueError, EOFError) as error:
                raise RunError(f"{run.folder / name}: not readable: {error}") from error
        if found.index is None or len(found.index) != len(found.ids):
            raise RunError(f"{run.folder / 'search.usearch'}: does not match search.json")
        return found


def build_index(embedder: Embedder, known: Sequence[Example], validation: Sequence[Example]) -> SurfaceIndex:
    """Return an index over ``known``, with thresholds calibrated on ``validation``.

    The latter are recordings of known materials that ``embedder`` was not trained on. If there are none, each known
    recording is compared with the others, which is optimistic.

    Raises
    ------
    ParameterError
        If ``known`` is empty.
    """
    if not known:
        raise ParameterError("an index needs at least one recording, got none")
    vectors = embeddings(embedder, known)
    materials = [str(example.material) for example in known]
    index = SurfaceIndex(
        vectors,
        [example.id for example in known],
        materials,
        whitening=whitening_of(vectors, materials),
        thresholds=dict.fromkeys(materials, 1.0),
        calibrated_on=len(validation),
    )
    # The nearest of each is itself.
    apart = np.array([index.nearest(vector, 2)[-1]["distance"] for vector in vectors])
    index.thresholds = _typical(apart, materials)
    if len(validation):
        novelties = [index.novelty(vector) for vector in embeddings(embedder, validation)]
    else:
        novelties = [far / index.thresholds[name] for far, name in zip(apart, materials, strict=True)]
    limit = prediction_limit(novelties)
    index.thresholds = {name: limit * typical for name, typical in index.thresholds.items()}
    return index


def _typical(distances: NDArray[np.float64], materials: Sequence[str]) -> dict[str, float]:
    """Return the mean of ``distances``, one for each of ``materials``, by material; of copies, a tenth of all."""
    least = distances.mean() / 10 or 1.0
    of = np.array(materials)
    return {name: max(float(distances[of == name].mean()), float(least)) for name in sorted(set(materials))}


def whitening_of(vectors: NDArray[np.float32], materials: Sequence[str]) -> NDArray[np.float32]:
    """Return the matrix, float32, shape (feature, feature), after which distances compare recordings with materials.

    ``vectors @ matrix`` have equal variance within materials in all directions, as far as few recordings can tell:
    half of the covariance is that of the recordings about the mean of their material, the other half is a multiple of
    the identity. Distance 1 is the root mean square distance of two of these recordings of one material; of any two, if
    no material has several.
    """
    names, of = np.unique(materials, return_inverse=True)
    wide = vectors.astype(np.float64)
    freedom = len(wide) - len(names)
    if freedom < 1:
        of, freedom = np.zeros_like(of), max(len(wide) - 1, 1)
    means = np.stack([wide[of == each].mean(axis=0) for each in range(of.max() + 1)])
    residuals = wide - means[of]
    covariance = residuals.T @ residuals / freedom
    variance = np.trace(covariance) / len(covariance)
    if variance == 0:
        return np.eye(len(covariance), dtype=np.float32)
    triangle = np.linalg.cholesky(covariance + variance * np.eye(len(covariance)))
    whitening = solve_triangular(triangle, np.eye(len(covariance)), lower=True).T
    unit = np.sqrt(2 * np.sum((residuals @ whitening) ** 2) / freedom)
    matrix: NDArray[np.float32] = (whitening / unit).astype(np.float32)
    return matrix


def prediction_limit(distances: Sequence[float]) -> float:
    """Return the distance, relative to the typical, within which a new recording is with probability `KEPT`.

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


def index_run(run: Run, embedder: Embedder, known: Sequence[Example], validation: Sequence[Example]) -> None:
    """Build the index of a run and save it there."""
    build_index(embedder, known, validation).save(run)


def calibration_text(recordings: int) -> str:
    """Return a sentence on the calibration of "none of these"."""
    if recordings:
        return f"The thresholds were set on {recordings} recordings that were not trained on."
    return "The thresholds were set on the training recordings, each against the others, which is optimistic."


def embeddings(embedder: Embedder, examples: Sequence[Example]) -> NDArray[np.float32]:
    """Return the embedding of each example, scaled to length 1: float32, shape (example, feature)."""
    return np.stack([_unit(embedder.embed(example.signal)) for example in examples])


def _unit(vector: NDArray[np.float32]) -> NDArray[np.float32]:
    unit: NDArray[np.float32] = vector / max(float(np.linalg.norm(vector)), 1e-12)
    return unit
