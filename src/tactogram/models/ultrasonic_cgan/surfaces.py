"""Surfaces and display signals of a run: ratings, clusters (Sec. IV-B), scales, sensor spectra."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any, Self

import numpy as np
from numpy.typing import NDArray
from scipy.cluster.hierarchy import cut_tree, linkage

from tactogram.errors import ParameterError
from tactogram.models.ultrasonic_cgan.config import Config
from tactogram.models.ultrasonic_cgan.spectra import SideSpectra


@dataclass(frozen=True, eq=False)
class SurfaceTable:
    """Table measured once from the training part, and stored with the weights.

    Parameters
    ----------
    plates : tuple of str
        The surfaces.
    means : float64 array, shape (surface, word)
        Mean ratings, 0 to 1.
    tree : float64 array, shape (surface - 1, 4)
        Scipy's linkage matrix.
    clusters : int64 array, shape (surface,)
        From 0.
    sensor_scale, display_scale : float
        Divisors of spectra in the networks' input: the rms of all their bins, over the weight of the config. The
        display's is in the display signals' unit, so that their levels are preserved.
    stored : float32 array, shape (surface, spectrum, bin)
        Some of each surface's sensor spectra.
    stored_place : int64 array, shape (surface, spectrum, 3)
        Their place in ``recordings``, axis and window.
    recordings : tuple of str
    display : float32 array, shape (spectrum, bin)
        The display signals' spectra.
    display_items : tuple of str
        Their items.
    """

    plates: tuple[str, ...]
    means: NDArray[np.float64]
    tree: NDArray[np.float64]
    clusters: NDArray[np.int64]
    sensor_scale: float
    display_scale: float
    stored: NDArray[np.float32]
    stored_place: NDArray[np.int64]
    recordings: tuple[str, ...]
    display: NDArray[np.float32]
    display_items: tuple[str, ...]

    @classmethod
    def measured(cls, sensor: SideSpectra, display: SideSpectra, config: Config) -> Self:
        """Cluster the surfaces, measure the scales, and store some spectra, evenly spread over each surface's."""
        tree = tree_of(sensor.means, config.linkage)
        stored = []
        for plate in range(len(sensor.items)):
            rows = np.flatnonzero(sensor.item == plate)
            stored.append(rows[np.linspace(0, len(rows) - 1, config.stored).round().astype(int)])
        rows = np.array(stored)
        return cls(
            plates=sensor.items,
            means=sensor.means,
            tree=tree,
            clusters=clusters_of(tree, config.clusters, items=len(sensor.items)),
            sensor_scale=_rms(sensor.spectra) / config.spectrum_weight,
            display_scale=_rms(display.spectra) / config.spectrum_weight,
            stored=sensor.spectra[rows],
            stored_place=sensor.place[rows],
            recordings=sensor.recordings,
            display=display.spectra,
            display_items=tuple(display.items[k] for k in display.item),
        )

    @property
    def count(self) -> int:
        return int(self.clusters.max()) + 1

    def members(self, cluster: int) -> tuple[str, ...]:
        return tuple(name for name, k in zip(self.plates, self.clusters, strict=True) if k == cluster)

    def rows(self, sensor: SideSpectra, cluster: int) -> NDArray[np.int64]:
        return np.flatnonzero(self.clusters[sensor.item] == cluster)

    def display_rows(self, display: SideSpectra, cluster: int) -> NDArray[np.int64]:
        """Return the spectra of the display signals with mean ratings nearest to the mean of ``cluster``."""
        centres = np.array([self.means[self.clusters == k].mean(0) for k in range(self.count)])
        mine = np.array([nearest(centres, means)[0] == cluster for means in display.means])
        if not mine.any():
            raise ParameterError(
                f"cluster {cluster + 1} ({', '.join(self.members(cluster))}) has no display signal nearest to it: "
                "use fewer clusters, or omit display_by_cluster"
            )
        return np.flatnonzero(mine[display.item])

    def state(self) -> dict[str, Any]:
        return {
            name: list(value) if isinstance(value, tuple) else value
            for name, value in ((name, getattr(self, name)) for name in self.__dataclass_fields__)
        }

    @classmethod
    def of(cls, state: Mapping[str, Any]) -> Self:
        fields: dict[str, Any] = {
            name: np.asarray(value)
            if hasattr(value, "numpy")
            else tuple(value)
            if isinstance(value, list)
            else value
            for name, value in state.items()
        }
        return cls(**fields)


def tree_of(means: NDArray[np.float64], method: str) -> NDArray[np.float64]:
    """Return scipy's linkage matrix, (item - 1, 4), of items by mean scores, (item, word), Euclidean. Sec. IV-B."""
    if len(means) < 2:
        return np.empty((0, 4))
    tree: NDArray[np.float64] = linkage(means, method, metric="euclidean")
    return tree


def clusters_of(tree: NDArray[np.float64], count: int, *, items: int) -> NDArray[np.int64]:
    """Return the cluster of each item, shape (item,), from 0 in the order of occurrence, in a cut into ``count``."""
    if count > items:
        raise ParameterError.must("clusters", f"be at most the {items} surfaces", count)
    if items == 1:
        return np.zeros(1, np.int64)
    clusters: NDArray[np.int64] = cut_tree(tree, n_clusters=count)[:, 0].astype(np.int64)
    return clusters


def nearest(means: NDArray[np.float64], scores: NDArray[np.float64]) -> tuple[int, float]:
    """Return the row of ``means``, (item, word), nearest to ``scores``, (word,), and its Euclidean distance."""
    distances = np.linalg.norm(means - scores, axis=1)
    index = int(np.argmin(distances))
    return index, float(distances[index])


def _rms(spectra: NDArray[np.float32]) -> float:
    rms = float(np.sqrt(np.mean(np.square(spectra, dtype=np.float64))))
    if rms == 0:
        raise ParameterError.must("spectra", "not be all 0: the signals have nothing in the band")
    return rms
