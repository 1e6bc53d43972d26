"""Distances between two sets of points in an embedding: as distributions, not as pairs.

All take float arrays of shape (point, feature), for example from a trained `stroke_cnn`. The
embedding decides what they detect. Every estimate depends on the number of points: use equally many, cut alike.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray
from scipy.stats import hypergeom

from tactogram.errors import ParameterError
from tactogram.evaluation.measures.intervals import Accuracy, wilson

CHUNK_DISTANCES = 2**23
"""Maximum number of distances in memory at once (64 MiB)."""


class Manifold(NamedTuple):
    """Overlap of two sets of points by neighbourhoods; see `precision_recall_density_coverage`."""

    precision: float
    recall: float
    density: float
    coverage: float


def frechet_distance(one: ArrayLike, other: ArrayLike) -> float:
    """Return the Fréchet distance between two sets of points, each modelled as a normal distribution.

    d^2 = |m1 - m2|^2 + tr(S1 + S2 - 2 (S1 S2)^(1/2)), with means m and covariances S (divided by n - 1); the value
    is d^2, as is customary ("FID"). Exact for any number of points, even fewer than features: with S = A^T A,
    tr (S1 S2)^(1/2) is the sum of the singular values of A1 A2^T, which avoids the square root of an
    ill-conditioned product, complex results and shrinkage.

    Few points bias it upwards, by about a constant over their number: the distance between two draws of 50 points
    from one distribution in 256 dimensions is far above 0. Compare only values from equally many points, with their
    floor.

    At least 2 points each. The result is >= 0, in squared units of the embedding.

    References
    ----------
    D. C. Dowson, B. V. Landau, J. Multivar. Anal. 12 (1982) 450-455: the closed form. M. Heusel et al., NeurIPS
    2017: its use for GANs. M. J. Chong, D. Forsyth, CVPR 2020: its bias.
    """
    a, b = _points(one, other, fewest=2)
    shift = a.mean(axis=0) - b.mean(axis=0)
    first, second = _factor(a), _factor(b)
    shared = np.linalg.svd(first @ second.T, compute_uv=False).sum()
    squared = shift @ shift + np.sum(first**2) + np.sum(second**2) - 2 * shared
    return max(0.0, float(squared))


def precision_recall_density_coverage(real: ArrayLike, made: ArrayLike, k: int = 5) -> Manifold:
    """Return by how much generated and real points overlap.

    With B(x) the ball around a point that reaches to its ``k``-th nearest neighbour in its own set:

    - precision: share of generated points in at least one B(real); are they realistic?
    - recall: share of real points in at least one B(generated); do they cover the whole variety? Outliers
      among the generated points, whose balls are large, inflate it.
    - density: mean number of B(real) that a generated point lies in, divided by ``k``; may exceed 1.
    - coverage: share of B(real) that hold a generated point.

    Real points against other real points give about 1 in density and 1 - 2^-k in coverage (k = 5: 0.97).

    Higher is better. Both sets need more than ``k`` points.

    References
    ----------
    Precision and recall: T. Kynkäänniemi et al., "Improved precision and recall metric for assessing generative
    models", NeurIPS 2019. Density and coverage: M. F. Naeem et al., "Reliable fidelity and diversity
    metrics for generative models", ICML 2020, with the expectations above for equally many points.
    """
    if k < 1:
        raise ParameterError.must("k", "be >= 1", k)
    a, b = _points(real, made, fewest=k + 1)
    reach_a, reach_b = _reach(a, k), _reach(b, k)
    in_any_real = np.zeros(len(b), bool)
    balls, recalled, covered = 0, 0, 0
    for rows, squared in _distances(a, b):
        within_real = squared <= reach_a[rows, None]
        in_any_real |= within_real.any(axis=0)
        balls += int(within_real.sum())
        covered += int(within_real.any(axis=1).sum())
        recalled += int((squared <= reach_b).any(axis=1).sum())
    return Manifold(
        precision=float(in_any_real.mean()),
        recall=recalled / len(a),
        density=balls / (k * len(b)),
        coverage=covered / len(a),
    )


def two_sample_accuracy(
    one: ArrayLike,
    other: ArrayLike,
    *,
    one_groups: Sequence[object] | None = None,
    other_groups: Sequence[object] | None = None,
) -> Accuracy:
    """Return how often a point's nearest neighbour, excluding itself, comes from its own set.

    Since a point is excluded from its own set, that set offers fewer neighbours than the other; with few points
    that alone would bring chance below 0.5. The share is therefore the exact mean over all ways to draw equally many
    from both (a hypergeometric probability).

    0.5: the sets cannot be distinguished. 1: a classifier would separate every point. Well below 0.5 is no better than
    0.5: every point has a copy in the other set, as when training data was memorised, or replayed.

    Pieces of one recording are each other's neighbours in any comparison; that alone lifts real
    against real far above 0.5. With groups, a point's own group is excluded, and equally many groups are drawn from
    both sets.

    Both sets have equally many points, or with groups for both, equally many in every group; otherwise chance is not
    0.5. Groups are the origin of each point, e.g. the id of its recording, at least 2 per set; by default each point is
    its own.

    The accuracy is the mean of both sets' shares, with Wilson's 95 % interval. The points of a group count as one
    answer, groups as independent.

    References
    ----------
    D. Lopez-Paz, M. Oquab, "Revisiting classifier two-sample tests", ICLR 2017; leave-one-out nearest neighbour:
    Q. Xu et al., "An empirical study on evaluation metrics of generative adversarial networks", 2018, arXiv:1806.07755.
    """
    a, b = _points(one, other, fewest=2)
    if len(a) != len(b) and (one_groups is None or other_groups is None):
        raise ParameterError(f"two_sample_accuracy needs equally many points, got {len(a)} and {len(b)}")
    group = np.concatenate([_numbered(one_groups, len(a)), -1 - _numbered(other_groups, len(b))])
    side = np.repeat([0, 1], [len(a), len(b)])
    if min(len(np.unique(group[side == s])) for s in (0, 1)) < 2:
        raise ParameterError("two_sample_accuracy needs at least 2 groups in both sets, got 1")
    order = np.argsort(group, kind="stable")
    points, group, side = np.concatenate([a, b])[order], group[order], side[order]
    starts = np.flatnonzero(np.diff(group, prepend=group[0] - 1))
    correct = np.zeros(2)
    for rows, squared in _distances(points, points):
        nearest = np.minimum.reduceat(squared, starts, axis=1)  # of each group
        nearest[group[rows, None] == group[starts]] = np.inf
        for s in (0, 1):
            members = nearest[side[rows] == s]
            correct[s] += _nearest_is_own(members[:, side[starts] == s], members[:, side[starts] != s])
    return wilson(float(np.mean(correct / (len(a), len(b)))), len(starts))


def _nearest_is_own(own: NDArray[np.float64], other: NDArray[np.float64]) -> float:
    """Return the probability that the nearest group is one of a point's own set, summed over points.

    As many groups of each set are drawn as the smaller set has. With r groups of the other set nearer than all a of
    the own, none of these is among a drawn of b with probability C(b - r, a) / C(b, a), and vice versa.

    ``own`` and ``other``, shape (point, group), are squared distances to the nearest point of each group; infinite for
    the point's own group.
    """
    a, b = own.shape[1] - 1, other.shape[1]
    if a <= b:
        nearer = np.sum(other < own.min(axis=1, keepdims=True), axis=1)
        return float(np.sum(hypergeom.pmf(0, b, nearer, a)))
    nearer = np.sum(own < other.min(axis=1, keepdims=True), axis=1)
    return float(np.sum(1 - hypergeom.pmf(0, a, nearer, b)))


def _points(
    one: ArrayLike, other: ArrayLike, *, fewest: int
) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Return both as float64, shifted to a common centre."""
    a, b = (np.asarray(points, dtype=np.float64) for points in (one, other))
    if a.ndim != 2 or b.ndim != 2 or a.shape[1] != b.shape[1]:
        raise ParameterError.must(
            "points", f"be (point, feature) with equally many features, got {a.shape} and {b.shape}"
        )
    if min(len(a), len(b)) < fewest:
        raise ParameterError(f"both sets must have at least {fewest} points, got {len(a)} and {len(b)}")
    if not (np.isfinite(a).all() and np.isfinite(b).all()):
        raise ParameterError.must("points", "be finite, got NaN or infinity")
    centre = (a.mean(axis=0) + b.mean(axis=0)) / 2
    return a - centre, b - centre


def _factor(points: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return A with A^T A the covariance of ``points``, shape (min(point, feature), feature)."""
    deviation = (points - points.mean(axis=0)) / np.sqrt(len(points) - 1)
    if len(deviation) <= deviation.shape[1]:
        return np.asarray(deviation)
    return np.asarray(np.linalg.qr(deviation, mode="r"))


def _reach(points: NDArray[np.float64], k: int) -> NDArray[np.float64]:
    """Return the squared distance to each point's ``k``-th nearest other point, shape (point,)."""
    reach = np.empty(len(points))
    for rows, squared in _distances(points, points):
        squared[np.arange(len(squared)), np.arange(rows.start, rows.stop)] = np.inf
        reach[rows] = np.partition(squared, k - 1, axis=1)[:, k - 1]
    return reach


def _distances(
    one: NDArray[np.float64], other: NDArray[np.float64]
) -> Iterator[tuple[slice, NDArray[np.float64]]]:
    """Yield the squared distances from some rows of ``one`` to all of ``other``, in bounded memory."""
    first, second = np.sum(one**2, axis=1), np.sum(other**2, axis=1)
    together = max(1, CHUNK_DISTANCES // len(other))
    for start in range(0, len(one), together):
        rows = slice(start, min(start + together, len(one)))
        squared = one[rows] @ other.T
        squared *= -2
        squared += first[rows, None]
        squared += second
        yield rows, np.maximum(squared, 0, out=squared)


def _numbered(groups: Sequence[object] | None, count: int) -> NDArray[np.int64]:
    if groups is None:
        return np.arange(count)
    if len(groups) != count:
        raise ParameterError.must("groups", f"be one per point ({count})", len(groups))
    numbers = {group: number for number, group in enumerate(dict.fromkeys(groups))}
    return np.array([numbers[group] for group in groups])
