"""Comparison of a generator with its floor, its ceiling and the baselines."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from typing import Any, Literal

import numpy as np
from numpy.typing import NDArray

from tactogram.evaluation.measures import wilson

MODEL, FLOOR, CEILING, NEAREST = "model", "floor", "ceiling", "nearest_other"
"""Columns of a row: the model, real against other real recordings, other materials (mean), the nearest of them."""

TEST, OTHERS = "test", "others"
"""The recordings to judge by, and those of every material that was trained on: no columns of a row."""

BetterDirection = Literal["lower", "higher"]
Tables = dict[str, dict[str, dict[str, float | None]]]
"""Measure -> material -> column -> value."""
Row = Mapping[str, float | None]
Verdict = Literal["floor", "between", "beyond", "untold"]
"""At the floor or better; between floor and ceiling; beyond the ceiling; the measure does not tell."""

FEWEST_MATERIALS = 3
"""An interval over fewer materials means nothing."""
RESAMPLES = 2000


@dataclass(frozen=True, eq=False)
class GenerationResult:
    """Result of `evaluate_generation`. Immutable; all else follows from ``values``.

    Parameters
    ----------
    materials : tuple of str
    columns : tuple of str
        ``"model"`` and the baselines.
    values : mapping measure -> material -> column -> float or None
        Columns are those and ``floor``, ``ceiling`` and ``nearest_other``; None where not defined.
    better : mapping from str to {"lower", "higher"}
        Per measure, which way is better.
    answers : mapping from str to int
        Per accuracy, how many independent answers its overall figure is the mean of.
    seconds : float
        Length of the pieces that all sets were cut to, s.
    count : int
        Number of such pieces in each set of each material.
    notes : tuple of str
        What was left out, and why.
    floored : frozenset of str
        Measures in which nothing is better than the floor: a signal that is less like the training data than
        unseen recordings are is none the better for it.
    """

    materials: tuple[str, ...]
    columns: tuple[str, ...]
    values: Mapping[str, Mapping[str, Row]]
    better: Mapping[str, BetterDirection]
    answers: Mapping[str, int]
    seconds: float
    count: int
    notes: tuple[str, ...] = ()
    floored: frozenset[str] = frozenset()

    @property
    def baselines(self) -> tuple[str, ...]:
        """The columns beside the model."""
        return tuple(column for column in self.columns if column != MODEL)

    @property
    def overall(self) -> dict[str, dict[str, float | None]]:
        """The mean over materials per measure and column: every material counts the same."""
        columns = (*self.columns, FLOOR, CEILING, NEAREST)
        return {
            name: {column: _mean(row.get(column) for row in rows.values()) for column in columns}
            for name, rows in self.values.items()
        }

    def position(self, measure: str, material: str | None = None, column: str = MODEL) -> float | None:
        """Return where ``column`` stands: 0 at the floor, 1 at the ceiling, of one material or overall.

        ``(value - floor) / (ceiling - floor)``, whichever way is better; None where the ceiling is no worse
        than the floor, so that the measure does not tell this material from others.
        """
        row = self.overall[measure] if material is None else self.values[measure][material]
        value, floor, ceiling = row.get(column), row.get(FLOOR), row.get(CEILING)
        if value is None or floor is None or ceiling is None:
            return None
        span = ceiling - floor
        if (span if self.better[measure] == "lower" else -span) <= 1e-9 * max(abs(ceiling), abs(floor)):
            return None
        return float((value - floor) / span)

    def verdict(self, measure: str, material: str | None = None, column: str = MODEL) -> Verdict:
        """Return on which side of floor and ceiling ``column`` is."""
        position = self.position(measure, material, column)
        if position is None:
            return "untold"
        return "floor" if position <= 0 else "between" if position <= 1 else "beyond"

    def beyond(self, column: str = MODEL) -> list[tuple[str, str]]:
        """Return the (measure, material) where ``column`` is farther off than another material is."""
        return [
            (name, material)
            for name, rows in self.values.items()
            for material in rows
            if self.verdict(name, material, column) == "beyond"
        ]

    def advantage(self, measure: str, baseline: str, *, seed: int = 0) -> dict[str, Any] | None:
        """Return by how much the model is better than ``baseline``, paired by material; None where not known.

        Returns
        -------
        dict
            ``mean`` (in the measure's unit, > 0: the model is better), ``low`` and ``high`` (95 % bootstrap
            interval over materials; None below three), ``materials`` and ``better_on`` of them.
        """
        sign = 1.0 if self.better[measure] == "lower" else -1.0
        rows = self.values[measure].values()
        pairs = [tuple(self._counted(measure, row, column) for column in (baseline, MODEL)) for row in rows]
        gains = np.array([sign * (b - m) for b, m in pairs if b is not None and m is not None])
        if gains.size == 0:
            return None
        low, high = bootstrap_interval(gains, seed=seed) or (None, None)
        return {
            "mean": float(gains.mean()),
            "low": low,
            "high": high,
            "materials": int(gains.size),
            "better_on": int(np.sum(gains > 0)),
        }

    def _counted(self, measure: str, row: Row, column: str) -> float | None:
        value, floor = row.get(column), row.get(FLOOR)
        if measure not in self.floored or value is None or floor is None:
            return value
        return max(value, floor) if self.better[measure] == "lower" else min(value, floor)

    def worse_than(self, baseline: str) -> list[str]:
        """Return the measures in which the model's mean over materials is worse than that of ``baseline``."""
        gains = {name: self.advantage(name, baseline) for name in self.values}
        return [name for name, gain in gains.items() if gain is not None and gain["mean"] < 0]

    def interval(self, measure: str, column: str = MODEL, *, seed: int = 0) -> tuple[float, float] | None:
        """Return the 95 % interval of an overall figure.

        Wilson's for an accuracy, with as many trials as there are recordings; for the others a bootstrap over
        materials, None below three.
        """
        value = self.overall[measure].get(column)
        if value is None:
            return None
        if trials := self.answers.get(measure):
            _, low, high = wilson(value, trials)
            return low, high
        known = [row.get(column) for row in self.values[measure].values()]
        return bootstrap_interval(np.array([v for v in known if v is not None]), seed=seed)

    def as_dict(self) -> dict[str, Any]:
        """Return everything as JSON types, under the names that the command line documents."""
        intervals = {
            name: {column: self.interval(name, column) for column in (*self.columns, FLOOR)}
            for name in self.values
        }
        return {
            "measures": self.overall,
            "better": dict(self.better),
            "positions": {
                name: {column: self.position(name, column=column) for column in self.columns}
                for name in self.values
            },
            "intervals_95": {
                name: {column: list(pair) for column, pair in row.items() if pair is not None}
                for name, row in intervals.items()
            },
            "per_material": {
                material: {name: dict(rows[material]) for name, rows in self.values.items()}
                for material in self.materials
            },
            "beyond_ceiling": [{"measure": name, "material": material} for name, material in self.beyond()],
            "beside": {
                baseline: {name: self.advantage(name, baseline) for name in self.values}
                for baseline in self.baselines
            },
            "worse_than": {baseline: self.worse_than(baseline) for baseline in self.baselines},
            "pieces": {"seconds": self.seconds, "count": self.count},
            "notes": list(self.notes),
        }


def bootstrap_interval(
    values: NDArray[np.float64], *, seed: int, level: float = 0.95
) -> tuple[float, float] | None:
    """Return the percentile bootstrap interval of a mean (Efron & Tibshirani 1993, ch. 13); None below three."""
    if len(values) < FEWEST_MATERIALS:
        return None
    drawn = np.random.default_rng(seed).integers(len(values), size=(RESAMPLES, len(values)))
    low, high = np.quantile(values[drawn].mean(axis=1), [(1 - level) / 2, (1 + level) / 2])
    return float(low), float(high)


def _mean(values: Iterable[float | None]) -> float | None:
    known = [value for value in values if value is not None]
    return float(np.mean(known)) if known else None
