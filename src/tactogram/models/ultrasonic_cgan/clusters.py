"""Cluster analysis of the surfaces by their mean ratings. Sec. IV-B."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray
from scipy.cluster.hierarchy import cut_tree, linkage

from tactogram.errors import ParameterError


def tree_of(means: NDArray[np.float64], method: str) -> NDArray[np.float64]:
    """Return scipy's linkage matrix of items by their mean scores, over Euclidean distances.

    Parameters
    ----------
    means : float64 array, shape (item, word), 0 to 1
    method : str
        ``ward``, ``average``, ``complete`` or ``single``.

    Returns
    -------
    float64 array, shape (item - 1, 4)
    """
    if len(means) < 2:
        return np.empty((0, 4))
    tree: NDArray[np.float64] = linkage(means, method, metric="euclidean")
    return tree


def clusters_of(tree: NDArray[np.float64], count: int, *, items: int) -> NDArray[np.int64]:
    """Return the cluster of each item, from 0, shape (item,), where the tree is cut into exactly ``count``.

    Numbered in the order in which they first occur. ``tree`` is that of `tree_of`, shape (item - 1, 4).

    Raises
    ------
    ParameterError
        If there are fewer items than clusters.
    """
    if count > items:
        raise ParameterError(f"clusters must be at most the {items} surfaces, got {count}")
    if items == 1:
        return np.zeros(1, np.int64)
    found: NDArray[np.int64] = cut_tree(tree, n_clusters=count)[:, 0].astype(np.int64)
    return found


def nearest(means: NDArray[np.float64], asked: NDArray[np.float64]) -> tuple[int, float]:
    """Return which row of ``means`` (item, word) is nearest to ``asked`` (word,), and its Euclidean distance."""
    distances = np.linalg.norm(means - asked, axis=1)
    place = int(np.argmin(distances))
    return place, float(distances[place])
