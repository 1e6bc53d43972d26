"""Search index of a run: embedded recordings, and the distance beyond which a surface is none of them.

A recording is embedded as the last hidden layer of the classifier averaged over its windows, scaled to length 1, and
searched in a vector index. A recording is "none of these" when it is farther from all known recordings than `KEPT` of
the recordings of known materials are: the k-nearest-neighbour test of Sun et al. 2022 ("Out-of-distribution
detection with deep nearest neighbors"), its threshold calibrated on recordings that the network was not trained on.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray
from usearch.index import Index

from tactogram.errors import ParameterError, RunError
from tactogram.model import Embedder, Example
from tactogram.signal.io.atomic import atomic_write
from tactogram.training.run import Run

KEPT = 0.95
"""Share of recordings of known materials that the threshold accepts."""
EXACT_BELOW = 20_000
"""Largest number of recordings for exact search; beyond it the index's graph is searched."""


class SurfaceIndex:
    """Embedded recordings, and the distance beyond which something is none of them.

    ``vectors`` are float32, shape (recording, feature), of length 1; ``threshold`` is a cosine distance, 0..2, set by
    ``calibrated_on`` recordings.
    """

    def __init__(
        self,
        vectors: NDArray[np.float32],
        ids: Sequence[str],
        materials: Sequence[str],
        *,
        threshold: float,
        calibrated_on: int,
    ) -> None:
        self.ids, self.materials = list(ids), list(materials)
        self.threshold, self.calibrated_on = threshold, calibrated_on
        self.index: Any = Index(ndim=vectors.shape[1], metric="cos", dtype="f32")
        self.index.add(np.arange(len(vectors)), vectors)

    def nearest(self, vector: NDArray[np.float32], count: int) -> list[dict[str, Any]]:
        """Return the ``count`` nearest recordings: ``id``, ``material``, ``distance`` (cosine, 0..2)."""
        exact = len(self.ids) <= EXACT_BELOW
        found: Any = self.index.search(_unit(vector[None])[0], min(count, len(self.ids)), exact=exact)
        return [
            {"id": self.ids[int(key)], "material": self.materials[int(key)], "distance": float(distance)}
            for key, distance in zip(found.keys, found.distances, strict=True)
        ]

    def save(self, run: Run) -> None:
        """Write ``search.usearch`` and ``search.json`` into the run."""
        with atomic_write(run.folder / "search.usearch") as part:
            self.index.save(str(part))
        run.write_json(
            "search.json",
            {
                "version": 1,
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
            If the run has none: only classifiers trained with `tactogram train` have one.
        """
        if not (run.folder / "search.json").is_file():
            raise RunError(f"{run.folder}: has no search index; search needs a trained classifier")
        facts = run.read_json("search.json")
        found = cls.__new__(cls)
        found.ids, found.materials = facts["ids"], facts["materials"]
        found.threshold, found.calibrated_on = facts["threshold"], facts["calibrated_on"]
        try:
            found.index = Index.restore(str(run.folder / "search.usearch"))
        except (OSError, RuntimeError, ValueError) as error:
            raise RunError(f"{run.folder / 'search.usearch'}: not a readable index: {error}") from error
        if found.index is None or len(found.index) != len(found.ids):
            raise RunError(f"{run.folder / 'search.usearch'}: does not match search.json")
        return found


def build_index(embedder: Embedder, known: Sequence[Example], validation: Sequence[Example]) -> SurfaceIndex:
    """Return an index over ``known``, with a threshold calibrated on ``validation``.

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
    if len(validation):
        distances = 1 - (embeddings(embedder, validation) @ vectors.T).max(axis=1)
    else:
        similarity = vectors @ vectors.T
        np.fill_diagonal(similarity, -1)
        distances = 1 - similarity.max(axis=1)
    # The conformal quantile: at least KEPT of new recordings pass, however few set the threshold.
    rank = min(len(distances), int(np.ceil((len(distances) + 1) * KEPT)))
    threshold = float(np.sort(distances)[rank - 1])
    return SurfaceIndex(
        vectors,
        [example.id for example in known],
        [str(example.material) for example in known],
        threshold=threshold,
        calibrated_on=len(validation),
    )


def index_run(run: Run, embedder: Embedder, known: Sequence[Example], validation: Sequence[Example]) -> None:
    """Build the index of a run and save it there."""
    build_index(embedder, known, validation).save(run)


def calibration_text(recordings: int) -> str:
    """Return a sentence on the calibration of "none of these"."""
    if recordings:
        return f"The threshold was set on {recordings} recordings that were not trained on."
    return "The threshold was set on the training recordings, each against the others, which is optimistic."


def embeddings(embedder: Embedder, examples: Sequence[Example]) -> NDArray[np.float32]:
    """Return the embedding of each example, scaled to length 1: float32, shape (example, feature)."""
    return _unit(np.stack([embedder.embed(example.signal) for example in examples]))


def _unit(vectors: NDArray[np.float32]) -> NDArray[np.float32]:
    unit: NDArray[np.float32] = vectors / np.maximum(np.linalg.norm(vectors, axis=1, keepdims=True), 1e-12)
    return unit
