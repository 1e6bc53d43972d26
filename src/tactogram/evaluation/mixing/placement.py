"""Placement of a mix's steps between its ends: position, distance from the line, direction."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, fields
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from tactogram.errors import ParameterError
from tactogram.evaluation.mixing.ordering import SIGNIFICANCE, order_of
from tactogram.evaluation.mixing.texture_features import texture_features
from tactogram.signal import Signal

Array = NDArray[np.float64]

OVERALL = "overall"
"""Name of the column for all axes together."""


class IndistinctEndsError(ParameterError):
    """The ends of a ladder cannot be distinguished, so no position between them is defined."""


@dataclass(frozen=True, eq=False)
class MixingLadder:
    """Positions of a ladder of mixes from its start (0) to its end (1). NaN where the ends do not differ.

    A column is an axis; in the last one, `OVERALL`, each axis counts by its share of the squared distance between
    the ends. Arrays have shape (column,) unless stated.
    """

    columns: tuple[str, ...]
    weights: Array
    """Weight of the end's material, rising, shape (step,)."""
    position: Array
    """Position of the step's mean along the line between the ends' means, shape (step, column)."""
    error: Array
    """Standard error of ``position``, that of the ends included, shape (step, column)."""
    off_line: Array
    """Distance of the step's mean from that line over the ends' distance, less what chance explains, shape (step,
    column): 0 is between the ends, 1 as far from the line as the ends are apart ("neither")."""
    spread: Array
    """Standard deviation of the positions of a step's signals, shape (step, column)."""
    end_spread: Array
    """The same for the signals of the start and the end, shape (2, column)."""
    distance_db: Array
    """Distance between the ends' means, root mean square over features, dB, less what chance explains."""
    resolution: Array
    """Largest difference between two steps that chance explains (95 %)."""
    monotone_p: Array
    """Probability of drops as large as the observed ones by chance; see `positions`."""
    tau: Array
    """Kendall's rank correlation of weight and position, with its 95 % interval."""
    tau_low: Array
    tau_high: Array
    half_weight: Array
    """Weight at which the position crosses one half, with its 95 % interval; infinite if it never does."""
    half_low: Array
    half_high: Array
    largest_rise: Array
    """Largest rise from one step to the next."""
    largest_drop: Array
    """Deepest fall below an earlier step."""

    @property
    def monotone(self) -> NDArray[np.bool_]:
        """Whether the ladder rises (``tau_low`` > 0) without a drop beyond chance, bool, shape (column,)."""
        return (self.tau_low > 0) & (self.monotone_p >= SIGNIFICANCE)

    def as_dict(self) -> dict[str, Any]:
        """Return the values as JSON types, each by column; None stands for NaN and infinity."""
        result: dict[str, Any] = {"weights": self.weights.tolist(), "columns": list(self.columns)}
        for field in fields(self):
            if field.name not in result:
                result[field.name] = self._by_column(getattr(self, field.name))
        monotone = self._by_column(self.monotone)
        result["monotone"] = {n: None if result["tau"][n] is None else monotone[n] for n in self.columns}
        return result

    def _by_column(self, values: NDArray[Any]) -> dict[str, Any]:
        return {name: _json(values[..., place].tolist()) for place, name in enumerate(self.columns)}


@dataclass(frozen=True, eq=False)
class _AxisResult:
    """Positions in one axis or all, before the tests against chance."""

    position: Array
    signals: tuple[Array, ...]
    """Positions of each step's signals."""
    off_line: Array
    error: Array
    end_spread: Array
    end_error: Array
    distance_db: float

    @classmethod
    def undefined(cls, steps: Sequence[Array]) -> _AxisResult:
        """Return a column of NaN, in which the ends do not differ."""
        nothing = np.full(len(steps), np.nan)
        each = tuple(np.full(len(step), np.nan) for step in steps)
        pair = np.full(2, np.nan)
        return cls(nothing, each, nothing, nothing, pair, pair, np.nan)


def positions(
    steps: Sequence[Sequence[Signal]],
    start: Sequence[Signal],
    end: Sequence[Signal],
    *,
    weights: ArrayLike | None = None,
    level: bool = True,
    seed: int = 0,
) -> MixingLadder:
    """Place each step of a mix on the line between the means of its two ends.

    Every signal is a point, its `texture_features` in dB; with s and e the ends' means and m a step's, the
    position is (m - s)·(e - s) / |e - s|². Both products are corrected for the bias from the noise of s and e.
    Positions are in dB: two materials 20 dB apart, mixed to equal parts of their powers, give a result 3 dB below
    the louder one, at position 0.85.

    Whether the ladder is monotone is tested against chance. The residual of the least increasing curve through the
    positions (isotonic regression) is compared with that of steps that all lie at the same place and differ by
    chance alone, the hardest case to distinguish (Robertson, Wright and Dykstra 1988, Sec. 2.3, with the variance
    pooled over steps). Whether it moves at all is Kendall's (1938) tau with an interval from draws of the positions
    within their errors.

    Raises `IndistinctEndsError` if the squared distance of the ends is less than twice its expectation for equal ends;
    `ParameterError` if there are too few signals or they differ in kind, or weights do not rise.

    Parameters
    ----------
    steps : sequence of sequences of Signal
        From start to end: at least 2 steps of at least 2 signals each.
    start, end : sequence of Signal
        At least 2 signals each, drawn independently of the steps.
    weights : array-like, shape (step,), optional
        Weight of the end's material, rising; by default evenly from 0 to 1.
    level : bool
        Whether the level counts; without it, only the shape of the spectrum and the modulation do.
    """
    w = np.linspace(0, 1, len(steps)) if weights is None else np.asarray(weights, np.float64)
    if w.shape != (len(steps),) or len(w) < 2 or not (np.isfinite(w).all() and (np.diff(w) > 0).all()):
        raise ParameterError(f"weights must be {max(2, len(steps))} rising numbers, got {w.tolist()}")
    groups = (start, end, *steps)
    if min(map(len, groups)) < 2:
        raise ParameterError("each end and each step must have at least 2 signals: one has no spread")
    features = texture_features([signal for group in groups for signal in group], level=level)
    first, last, *rungs = np.split(features, np.cumsum([len(group) for group in groups])[:-1])
    axes = groups[0][0].axes
    columns = [_column(*(part[:, place] for part in (first, last, *rungs))) for place in range(len(axes))]
    columns.append(_column(*(part.reshape(len(part), -1) for part in (first, last, *rungs)), needed=True))
    orders = [
        order_of(c.position, c.signals, w, end_error=c.end_error, rng=np.random.default_rng([seed, place]))
        for place, c in enumerate(columns)
    ]
    return MixingLadder(
        columns=(*axes, OVERALL),
        weights=w,
        position=np.stack([c.position for c in columns], axis=1),
        error=np.stack([c.error for c in columns], axis=1),
        off_line=np.stack([c.off_line for c in columns], axis=1),
        spread=np.array([[part.std(ddof=1) for part in c.signals] for c in columns]).T,
        end_spread=np.stack([c.end_spread for c in columns], axis=1),
        distance_db=np.array([c.distance_db for c in columns]),
        largest_rise=np.array([np.diff(c.position).max() for c in columns]),
        largest_drop=np.array([(np.maximum.accumulate(c.position) - c.position).max() for c in columns]),
        **{name: np.array([order[name] for order in orders]) for name in orders[0]},
    )


def _column(start: Array, end: Array, *steps: Array, needed: bool = False) -> _AxisResult:
    """Return positions along the line from ``start`` to ``end``; all have shape (signal, feature)."""
    s, e = start.mean(axis=0), end.mean(axis=0)
    way = e - s
    noise_s, noise_e = _noise(start), _noise(end)
    if not way @ way > 2 * (noise_s + noise_e):
        if needed:
            apart, chance = np.sqrt([way @ way / way.size, (noise_s + noise_e) / way.size])
            raise IndistinctEndsError(
                f"the two ends must differ, got {apart:.2g} dB between them and {chance:.2g} dB by chance: "
                "take two other materials, or more signals"
            )
        return _AxisResult.undefined(steps)
    squared = way @ way - noise_s - noise_e
    along = way / np.sqrt(way @ way)
    unit = way / squared
    across_s, across_e = (_noise(part - np.outer(part @ along, along)) for part in (start, end))
    position, signals, off, error = [], [], [], []
    for step in steps:
        each = ((step - s) @ way - noise_s) / squared
        t = each.mean()
        rest = (step - s) - np.outer((step - s) @ along, along)
        r = rest.mean(axis=0)
        chance = _noise(rest) + (1 - t) ** 2 * across_s + t**2 * across_e
        off.append(np.sqrt(max(0.0, r @ r - chance) / squared))
        # Derivatives of t by the ends' means s and e.
        by_start, by_end = (1 - t) * unit + r / squared, t * unit - r / squared
        variance = _noise(each) + _noise(start @ by_start) + _noise(end @ by_end)
        error.append(np.sqrt(variance))
        position.append(t)
        signals.append(each)
    spreads = np.array([(part @ unit).std(ddof=1) for part in (start, end)])
    return _AxisResult(
        np.array(position),
        tuple(signals),
        np.array(off),
        np.array(error),
        spreads,
        spreads / np.sqrt([len(start), len(end)]),
        float(np.sqrt(squared / way.size)),
    )


def _noise(part: Array) -> float:
    """Return the expected squared error of the mean of ``part``, shape (signal,) or (signal, feature)."""
    return float(part.var(axis=0, ddof=1).sum() / len(part))


def _json(values: Any) -> Any:
    if isinstance(values, list):
        return [_json(value) for value in values]
    return values if np.isfinite(values) else None
