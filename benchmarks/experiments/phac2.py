"""PHAC-2: adjectives for sixty objects explored by a robot's fingers; statistics only, no waveforms.

V. Chu et al., "Robotic learning of haptic adjectives through physical interaction", Robotics and Autonomous Systems 63
(2015). Read from ``object_adjectives.csv`` and ``phac2_static_features.npz`` (of the repository Penn-haptics-bolt),
which state no licence. Checked on the real files, which hold no recordings.

Notes on the data:

- The ten trials of an object are one object felt ten times: with trials of an object on both sides of a split, a model
  recognises objects rather than adjectives. Hold out whole objects (``AdjectiveTrials.trial_object``).
- The 47 statistics of each of four phases are undocumented; their spreads reach from 1e-13 to 1e11, so they must be
  standardised with the training data. None is missing or constant.
- ``nice``, ``sticky`` and ``unpleasant`` apply to one object each: if it is held out, nothing is left to learn from.
- Three names (car_sponge, chalkboard_eraser, tooth_paste_box) belong to two objects each, with different ids.
- The adjectives are the consensus of a group of people, whose size and individual answers are not in the files.
- ``split_is_test`` holds 6 or 7 objects of each adjective, others for each, and for the three adjectives above one
  object on both sides: it is not read.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from tactogram.datasets.ratings.ratings import EVOKED, Ratings
from tactogram.errors import DataError
from tactogram.signal.io.arrays import load_arrays
from tactogram.text_files import read_table

TABLE, FEATURES = "object_adjectives.csv", "phac2_static_features.npz"
FACTS = ("object_id", "object", "trials")
"""Columns of the table that are not adjectives."""


@dataclass(frozen=True, eq=False)
class AdjectiveTrials:
    """Statistics of trials, and the adjectives of their objects.

    Parameters
    ----------
    features : float64 array, shape (trial, phase * statistic)
        Phase by phase; units unknown.
    phases : tuple of str
    trials : tuple of str
        Names in the files: ``acrylic_211_01``.
    objects : tuple of str
        Name and id, ``acrylic_211``, in the order of the table.
    trial_object : int64 array, shape (trial,)
        Index of each trial's object in ``objects``.
    adjectives : tuple of str
    table : bool array, shape (object, adjective)
        Whether the adjective applies.
    """

    features: NDArray[np.float64]
    phases: tuple[str, ...]
    trials: tuple[str, ...]
    objects: tuple[str, ...]
    trial_object: NDArray[np.int64]
    adjectives: tuple[str, ...]
    table: NDArray[np.bool_]

    @property
    def labels(self) -> NDArray[np.bool_]:
        """The adjectives of each trial's object, bool, shape (trial, adjective)."""
        labels: NDArray[np.bool_] = self.table[self.trial_object]
        return labels

    @property
    def ratings(self) -> Ratings:
        """The same as yes-or-no ratings of one rater, ``group``, who stands for the consensus."""
        objects, words = len(self.objects), len(self.adjectives)
        return Ratings(
            ("group",) * (objects * words),
            tuple(name for name in self.objects for _ in range(words)),
            self.adjectives * objects,
            self.table.ravel().astype(np.float64),
            EVOKED,
            words=self.adjectives,
        )


def read_phac2(folder: Path | str) -> AdjectiveTrials:
    """Read both files.

    Raises
    ------
    DataError
        If one is missing or damaged, a value is not finite, or they disagree about an object.
    """
    table_path, path = Path(folder) / TABLE, Path(folder) / FEATURES
    rows, adjectives = _objects(table_path)
    objects = [f"{row['object']}_{row['object_id']}" for row in rows]
    place = {row["object_id"]: number for number, row in enumerate(rows)}
    if len(place) != len(rows):
        raise DataError(f"{table_path}: every object must have a different id")
    table = np.array([[_yes(table_path, row, name) for name in adjectives] for row in rows])
    names = ("features", "phases", "trial_names", "object_ids", "adjectives", "labels")
    arrays = load_arrays(path, needed=names)
    features = np.asarray(arrays["features"], np.float64)
    ids = [str(id) for id in arrays["object_ids"].tolist()]
    if features.ndim != 3 or not (len(features) == len(ids) == len(arrays["trial_names"])):
        raise DataError(
            f"{path}: features must be (trial, phase, statistic) of {len(ids)} trials, got {features.shape}"
        )
    if not np.isfinite(features).all():
        raise DataError(
            f"{path}: features must be finite, got {int((~np.isfinite(features)).sum())} that are not"
        )
    if unknown := sorted(set(ids) - place.keys()):
        raise DataError(f"{path}: objects must be among those of {TABLE}, got {', '.join(unknown[:5])}")
    trial_object = np.array([place[id] for id in ids])
    columns = tuple(str(name) for name in arrays["adjectives"])
    labels = np.asarray(arrays["labels"], bool)
    if sorted(columns) != sorted(adjectives) or labels.shape != (len(ids), len(columns)):
        raise DataError(f"{path}: must have the adjectives of {TABLE}, got {', '.join(columns)}")
    if not np.array_equal(labels[:, [columns.index(name) for name in adjectives]], table[trial_object]):
        raise DataError(f"{path}: labels must be those of {TABLE}, got others")
    return AdjectiveTrials(
        features.reshape(len(features), -1),
        tuple(str(name) for name in arrays["phases"]),
        tuple(str(name) for name in arrays["trial_names"]),
        tuple(objects),
        trial_object,
        adjectives,
        table,
    )


def _objects(path: Path) -> tuple[list[dict[str, str]], tuple[str, ...]]:
    rows = [row for _, row in read_table(path, needed=("object_id", "object"))]
    if not rows or len(rows[0]) <= len(FACTS):
        raise DataError(f"{path}: needs columns object_id, object and adjectives, and rows")
    return rows, tuple(name for name in rows[0] if name not in FACTS)


def _yes(path: Path, row: Mapping[str, str], name: str) -> bool:
    if row[name] not in ("0", "1"):
        raise DataError(f"{path}: {name} of {row['object']} must be 0 or 1, got {row[name]!r}")
    return row[name] == "1"
