"""Texture map: models of one surface over speed and force.

Between recorded conditions the nearest models are mixed (autoregressive ones through their line spectral frequencies),
by the barycentric weights of a triangle in a Delaunay triangulation over (speed, force); outside, by those of the
nearest point of the convex hull (Culbertson et al. 2012, 2014). If only one of the two is known, or the conditions lie
on a line, the triangles are the segments of that line.

References
----------
- Culbertson, H., Romano, J. M., Castillo, P., Mintz, M. & Kuchenbecker, K. J. (2012). Refined methods for creating
  realistic haptic virtual textures from tool-mediated contact acceleration data. Proc. IEEE Haptics Symposium, 385-391.
- Culbertson, H., Unwin, J. & Kuchenbecker, K. J. (2014). Modeling and rendering realistic textures from unconstrained
  tool-surface interactions. IEEE Trans. Haptics 7(3), 381-393. doi 10.1109/TOH.2014.2316797
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace
from functools import cached_property
from typing import Any, Generic, TypeVar

import numpy as np
from numpy.typing import ArrayLike, NDArray
from scipy.spatial import Delaunay

from tactogram.errors import ParameterError
from tactogram.signal.autoregressive import AutoregressiveModel, Level, mix
from tactogram.signal.modulated_noise import (
    INNER,
    ModulatedNoise,
    band_edges,
    mix as mix_noise,
    stretch_difference,
    stretched,
)
from tactogram.signal.tones import share_pattern

Array = NDArray[np.float64]
M = TypeVar("M")
"""Model of one texture."""
NAMES = ("speed_mm_s", "force_n")
EXPONENTS = np.linspace(0, 1, 21)
LEAST_RATIO = 0.05
"""Of two speeds whose spectra are compared, as a logarithm."""


class ConditionMap:
    """Recorded conditions of one surface, and the shares of the nearest of them at any other.

    Parameters
    ----------
    conditions : array-like, shape (condition, 2)
        Speed in mm/s and force in N; an unknown column is NaN throughout.
    triangles : int array-like, shape (triangle, 3), optional
        Of indices into ``conditions``; by default Delaunay's, over speed and force each divided by its range.
    """

    def __init__(self, conditions: ArrayLike, *, triangles: ArrayLike | None = None) -> None:
        points = np.array(conditions, np.float64)
        if points.ndim != 2 or points.shape[1] != 2 or not len(points):
            raise ParameterError.must("conditions", f"be (condition, 2), got shape {points.shape}")
        known = ~np.isnan(points)
        if not np.array_equal(known.all(axis=0), known.any(axis=0)):
            raise ParameterError("a speed or force must be known for every model or for none")
        filled = np.where(known, points, 0.0)
        if not (np.isfinite(filled).all() and (filled >= 0).all()):
            raise ParameterError("speed and force must be finite and >= 0")
        if len(np.unique(filled, axis=0)) < len(filled):
            raise ParameterError("two models have the same speed and force; fit one to both recordings")
        self.conditions = points
        self.conditions.flags.writeable = False
        self.has_conditions = (bool(known[0, 0]), bool(known[0, 1]))
        """Whether speed and force are known."""
        extent = np.ptp(filled, axis=0)
        self._scale = np.where(extent > 0, extent, 1.0)
        self._points = filled / self._scale
        self._edges, self._triangles = _simplices(self._points, triangles)

    def weights(self, speed_mm_s: float | None = None, force_n: float | None = None) -> Array:
        """Return the share of each condition at another, float64, shape (condition,), >= 0, sum 1.

        By default it is the median of the recorded ones; it is clamped to the convex hull. One that is unknown
        for this surface, negative or not finite is a `ParameterError`.
        """
        point = np.zeros(2)
        for axis, value in enumerate((speed_mm_s, force_n)):
            if value is None:
                point[axis] = np.median(self._points[:, axis])
            elif not self.has_conditions[axis]:
                raise ParameterError(f"{NAMES[axis]} is unknown for this surface's recordings; omit it")
            elif not (np.isfinite(value) and value >= 0):
                raise ParameterError(f"{NAMES[axis]} must be finite and >= 0, got {value}")
            else:
                point[axis] = value / self._scale[axis]
        shares = np.zeros(len(self.conditions))
        corners, inside = _within(point, self._points, self._triangles)
        if corners is None:
            corners, inside = _nearest(point, self._points, self._edges)
        shares[corners] = inside
        return shares


def group_by_condition(
    conditions: Sequence[Mapping[str, Any]], *, known: bool = True
) -> tuple[Array, list[NDArray[np.intp]]]:
    """Return the different speeds and forces of recordings, shape (condition, 2), and the recordings of each.

    A speed or force that any recording lacks, or all if not ``known``, is NaN throughout.
    """
    values = np.array(
        [
            [np.nan if (value := each.get(name)) is None else float(value) for name in NAMES]
            for each in conditions
        ]
    )
    has = ~np.isnan(values).any(axis=0) & known
    points, group = np.unique(np.where(has, values, 0.0), axis=0, return_inverse=True)
    points[:, ~has] = np.nan
    return points, [np.flatnonzero(group.ravel() == number) for number in range(len(points))]


class ModelMap(ConditionMap, Generic[M]):
    """Models of one surface over speed and force.

    ``models`` are equal in rate, unit and axes; ``conditions`` and ``triangles`` are those of `ConditionMap`, one
    condition for each model.
    """

    def __init__(
        self, models: Sequence[M], conditions: ArrayLike, *, triangles: ArrayLike | None = None
    ) -> None:
        shape = np.shape(conditions)
        if not models or shape != (len(models), 2):
            raise ParameterError.must("conditions", f"be ({len(models)} models, 2), got shape {shape}")
        super().__init__(conditions, triangles=triangles)
        self.models = tuple(models)

    def moved(self, chosen: NDArray[np.intp], speed_mm_s: float | None) -> list[M]:
        """Return the chosen models as they are to be mixed at a speed: here as they are."""
        return [self.models[index] for index in chosen]

    def mix(self, weights: Array) -> M:
        """Return the mix of the models."""
        raise NotImplementedError

    def at(self, speed_mm_s: float | None = None, force_n: float | None = None) -> M:
        """Return the model at a condition, with parameters as `weights`."""
        return self.mix(self.weights(speed_mm_s, force_n))


class TextureMap(ModelMap[AutoregressiveModel]):
    """Autoregressive models over speed and force.

    ``level`` ("log" or "linear") is the interpolation of the power: see `tactogram.signal.autoregressive.mix`.
    """

    def __init__(
        self,
        models: Sequence[AutoregressiveModel],
        conditions: ArrayLike,
        *,
        triangles: ArrayLike | None = None,
        level: Level = "log",
    ) -> None:
        super().__init__(models, conditions, triangles=triangles)
        self.level: Level = level

    def mix(self, weights: Array) -> AutoregressiveModel:
        """Return the mix of the models."""
        return mix(self.models, weights, level=self.level)


class NoiseMap(ModelMap[ModulatedNoise]):
    """Models of modulated noise over speed and force.

    A pattern of k cycles per mm is felt at v k, a resonance at one frequency. So before models are mixed, their spectra
    are moved to the speed wanted, by its ratio to that of their recordings to the power of `exponent`. Tones, which are
    one pattern in all models (`tactogram.signal.tones.share_pattern`), move by the ratio itself.
    """

    def __init__(
        self, models: Sequence[ModulatedNoise], conditions: ArrayLike, *, triangles: ArrayLike | None = None
    ) -> None:
        super().__init__(models, conditions, triangles=triangles)
        band = band_edges(self.models[0].rate)[[0, -1]]
        shared = share_pattern([model.tones for model in self.models], self.conditions[:, 0], band)
        self.models = tuple(
            replace(model, tones=tones) for model, tones in zip(self.models, shared, strict=True)
        )

    def mix(self, weights: Array) -> ModulatedNoise:
        """Return the mix of the models as they are."""
        return mix_noise(self.models, weights)

    def at(self, speed_mm_s: float | None = None, force_n: float | None = None) -> ModulatedNoise:
        """Return the model at a condition, with parameters as `weights`."""
        weights = self.weights(speed_mm_s, force_n)
        chosen = np.flatnonzero(weights)
        return mix_noise(self.moved(chosen, speed_mm_s), weights[chosen])

    def moved(self, chosen: NDArray[np.intp], speed_mm_s: float | None) -> list[ModulatedNoise]:
        """Return the chosen models with their spectra and tones moved to a speed, or to the nearest recorded one."""
        recorded = self.conditions[:, 0]
        if not self.has_conditions[0]:
            return [self.models[index] for index in chosen]
        target_mm_s = np.median(recorded) if speed_mm_s is None else speed_mm_s
        speed = float(np.clip(target_mm_s, recorded.min(), recorded.max()))
        ratios = [speed / recorded[index] if recorded[index] > 0 and speed > 0 else 1.0 for index in chosen]
        band = band_edges(self.models[0].rate)[[0, -1]]
        return [
            model
            if ratio == 1
            else replace(stretched(model, ratio**self.exponent), tones=model.tones.moved(ratio, band))
            for model, ratio in zip((self.models[index] for index in chosen), ratios, strict=True)
        ]

    @cached_property
    def exponent(self) -> float:
        """Power of the speed, 0 to 1, with which peaks move; the spectra of neighbouring conditions decide."""
        speeds = self.conditions[:, 0]
        pairs = [
            (a, b) if speeds[a] < speeds[b] else (b, a)
            for a, b in self._edges
            if speeds[a] > 0 and speeds[b] > 0 and abs(np.log(speeds[a] / speeds[b])) > LEAST_RATIO
        ]
        if not pairs:
            return 0.0
        rate = self.models[0].rate
        frequency = np.linspace(0, rate / 2, self.models[0].spectrum.shape[1])
        low, high = INNER * band_edges(rate)[[0, -1]]
        inside = (frequency >= low) & (frequency <= high)

        def misfit(exponent: float) -> float:
            total = 0.0
            for slow, fast in pairs:
                factor = (speeds[fast] / speeds[slow]) ** (exponent / 2)
                one, other = (
                    spectrum + stretch_difference(spectrum, frequency, each, rate)
                    for spectrum, each in (
                        (self.models[slow].spectrum, factor),
                        (self.models[fast].spectrum, 1 / factor),
                    )
                )
                difference = (other - one)[:, inside]
                total += float(np.sum((difference - difference.mean(axis=1, keepdims=True)) ** 2))
            return total

        return float(min(EXPONENTS, key=misfit))


def _simplices(points: Array, triangles: ArrayLike | None) -> tuple[NDArray[np.intp], NDArray[np.intp]]:
    """Return edges (edge, 2) and triangles (triangle, 3) that cover ``points``."""
    none = np.zeros((0, 3), np.intp)
    if len(points) == 1:
        return np.zeros((1, 2), np.intp), none
    centred = points - points.mean(axis=0)
    _, spread, directions = np.linalg.svd(centred, full_matrices=False)
    if spread[1] <= 1e-9 * spread[0]:  # all on one line
        order = np.argsort(centred @ directions[0])
        return np.stack((order[:-1], order[1:]), axis=1), none
    if triangles is None:
        simplices = Delaunay(points).simplices.astype(np.intp)
    else:
        simplices = np.asarray(triangles, np.intp)
        if (
            simplices.ndim != 2
            or simplices.shape[1] != 3
            or simplices.min() < 0
            or simplices.max() >= len(points)
        ):
            raise ParameterError.must("triangles", f"be (triangle, 3) indices below {len(points)}")
    edges = np.unique(np.sort(simplices[:, [0, 1, 1, 2, 2, 0]].reshape(-1, 2), axis=1), axis=0)
    return edges, simplices


def _within(
    point: Array, points: Array, triangles: NDArray[np.intp]
) -> tuple[NDArray[np.intp] | None, Array]:
    """Return the corners of the triangle around ``point`` and its barycentric coordinates, or None."""
    if not len(triangles):
        return None, np.zeros(0)
    a, b, c = points[triangles].transpose(1, 0, 2)
    double = _cross(b - a, c - a)
    area = np.where(double == 0, np.inf, double)
    second, third = _cross(point - a, c - a) / area, _cross(b - a, point - a) / area
    shares = np.stack((1 - second - third, second, third), axis=1)
    shares[double == 0] = -np.inf
    best = int(np.argmax(shares.min(axis=1)))
    if shares[best].min() < -1e-12:
        return None, np.zeros(0)
    inside = np.maximum(shares[best], 0)
    return triangles[best], inside / inside.sum()


def _nearest(point: Array, points: Array, edges: NDArray[np.intp]) -> tuple[NDArray[np.intp], Array]:
    """Return the ends of the edge nearest to ``point``, and the shares of its nearest point on it."""
    a, b = points[edges].transpose(1, 0, 2)
    along = b - a
    square = np.einsum("ed,ed->e", along, along)
    share = np.clip(np.einsum("ed,ed->e", point - a, along) / np.where(square > 0, square, 1.0), 0, 1)
    distance = np.linalg.norm(a + share[:, None] * along - point, axis=1)
    best = int(np.argmin(distance))
    if edges[best][0] == edges[best][1]:
        return edges[best][:1], np.ones(1)
    return edges[best], np.array([1 - share[best], share[best]])


def _cross(u: Array, v: Array) -> Array:
    crossed: Array = u[..., 0] * v[..., 1] - u[..., 1] * v[..., 0]
    return crossed
