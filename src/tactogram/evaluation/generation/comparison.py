"""Comparison of a generator with floor, ceiling and baselines; its measures, and the pieces that are compared."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Any, Literal

import numpy as np

from tactogram.errors import ParameterError
from tactogram.evaluation.measures import mean_interval, signal_measures, wilson
from tactogram.evaluation.measures.measure import SignalSet
from tactogram.signal import Signal

MODEL, FLOOR, CEILING, NEAREST = "model", "floor", "ceiling", "nearest_other"
"""Columns of a row: the model, real against other real recordings, other materials (mean), the nearest of them."""

TEST, OTHERS = "test", "others"
"""Sets without a column: the test recordings, and those of every material in the training part."""

BetterDirection = Literal["lower", "higher"]
Tables = dict[str, dict[str, dict[str, float | None]]]
"""Measure -> material -> column -> value."""
Row = Mapping[str, float | None]
Verdict = Literal["floor", "between", "beyond", "undecided"]
"""At the floor or better; between floor and ceiling; beyond the ceiling; the measure does not separate materials."""
NEAR, FAR = 0.25, 0.5
"""Positions up to which a measure is near the floor, and from which it is nearer to the ceiling."""
LONGEST_S, SHORTEST_S = 2.0, 1.0
"""Limits of a piece's length, s. Recordings below the lower limit are left out where every material has longer ones."""
MOST_PIECES = 12
"""Pieces per material and set: bounds the time that an evaluation takes."""


@dataclass(frozen=True, eq=False)
class GenerationResult:
    """Result of `evaluate_generation`."""

    materials: tuple[str, ...]
    columns: tuple[str, ...]
    """``"model"`` and the baselines."""
    values: Mapping[str, Mapping[str, Row]]
    """Measure -> material -> column -> value; also for ``floor``, ``ceiling``, ``nearest_other``; None if undefined."""
    better: Mapping[str, BetterDirection]
    """Per measure."""
    answers: Mapping[str, int]
    """Per accuracy, the number of independent answers in its overall value."""
    seconds: float
    """Length of the pieces of all sets, s."""
    count: int
    """Number of pieces per set and material."""
    notes: tuple[str, ...] = ()
    """Omissions and their reasons."""
    floored: frozenset[str] = frozenset()
    """Measures in which values better than the floor are no advantage: generated signals need not be less like the
    training data than unseen recordings are."""

    @property
    def baselines(self) -> tuple[str, ...]:
        """The columns other than the model."""
        return tuple(column for column in self.columns if column != MODEL)

    @cached_property
    def overall(self) -> dict[str, dict[str, float | None]]:
        """The mean over materials, equally weighted, per measure and column."""
        columns = (*self.columns, FLOOR, CEILING, NEAREST)
        return {
            name: {column: _mean(row.get(column) for row in rows.values()) for column in columns}
            for name, rows in self.values.items()
        }

    def position(self, measure: str, material: str | None = None, column: str = MODEL) -> float | None:
        """Return the position of ``column`` for one material or overall: 0 at the floor, 1 at the ceiling.

        ``(value - floor) / (ceiling - floor)``, in either direction; None where the ceiling is no worse
        than the floor, since the measure then does not separate this material from others.
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
        """Return where ``column`` is relative to floor and ceiling."""
        position = self.position(measure, material, column)
        if position is None:
            return "undecided"
        return "floor" if position <= 0 else "between" if position <= 1 else "beyond"

    @property
    def summary(self) -> str:
        """A sentence: in which measures the model is near the floor, and in which far from it."""
        parts: dict[str, list[str]] = {
            "near other recordings of the same material in": [],
            "between these and other materials in": [],
            "nearer to other materials in": [],
        }
        near, between, far = parts.values()
        for name in self.values:
            if (position := self.position(name)) is not None:
                listed = near if position <= NEAR else between if position < FAR else far
                listed.append(name.removesuffix("_db").replace("_", " "))
        text = "; ".join(f"{where} {', '.join(names)}" for where, names in parts.items() if names)
        return f"{text[:1].upper()}{text[1:]}." if text else "No measure separates these materials."

    def beyond_ceiling(self, column: str = MODEL) -> list[tuple[str, str]]:
        """Return the pairs (measure, material) in which ``column`` is beyond the ceiling."""
        return [
            (name, material)
            for name, rows in self.values.items()
            for material in rows
            if self.verdict(name, material, column) == "beyond"
        ]

    def advantage(self, measure: str, baseline: str) -> dict[str, Any] | None:
        """Return the gain of the model over ``baseline``, paired by material; None without pairs.

        ``mean`` is in the measure's unit, > 0 if the model is better; ``low`` and ``high`` are Student's
        95 % interval over materials (None below three); ``better_on`` is the number of ``materials`` with a gain.
        """
        sign = 1.0 if self.better[measure] == "lower" else -1.0
        rows = self.values[measure].values()
        pairs = [tuple(self._limited(measure, row, column) for column in (baseline, MODEL)) for row in rows]
        gains = np.array([sign * (b - m) for b, m in pairs if b is not None and m is not None])
        if gains.size == 0:
            return None
        low, high = mean_interval(gains) or (None, None)
        return {
            "mean": float(gains.mean()),
            "low": low,
            "high": high,
            "materials": int(gains.size),
            "better_on": int(np.sum(gains > 0)),
        }

    def _limited(self, measure: str, row: Row, column: str) -> float | None:
        value, floor = row.get(column), row.get(FLOOR)
        if measure not in self.floored or value is None or floor is None:
            return value
        return max(value, floor) if self.better[measure] == "lower" else min(value, floor)

    def worse_than(self, baseline: str) -> list[str]:
        """Return the measures in which the model's mean over materials is worse than the baseline's."""
        gains = {name: self.advantage(name, baseline) for name in self.values}
        return [name for name, gain in gains.items() if gain is not None and gain["mean"] < 0]

    def interval(self, measure: str, column: str = MODEL) -> tuple[float, float] | None:
        """Return the 95 % interval of an overall value.

        Wilson's for an accuracy, with one trial per recording; otherwise Student's over materials, None below three.
        """
        value = self.overall[measure].get(column)
        if value is None:
            return None
        if trials := self.answers.get(measure):
            _, low, high = wilson(value, trials)
            return low, high
        known = [row.get(column) for row in self.values[measure].values()]
        least = 0.0 if self.better[measure] == "lower" else -np.inf
        return mean_interval(np.array([v for v in known if v is not None]), least=least)

    def as_dict(self) -> dict[str, Any]:
        """Return the result as JSON types, under the names that the command line documents."""
        intervals = {
            name: {column: self.interval(name, column) for column in (*self.columns, FLOOR)}
            for name in self.values
        }
        return {
            "summary": self.summary,
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
            "beyond_ceiling": [
                {"measure": name, "material": material} for name, material in self.beyond_ceiling()
            ],
            "beside": {
                baseline: {name: self.advantage(name, baseline) for name in self.values}
                for baseline in self.baselines
            },
            "worse_than": {baseline: self.worse_than(baseline) for baseline in self.baselines},
            "pieces": {"seconds": self.seconds, "count": self.count},
            "notes": list(self.notes),
        }


def _mean(values: Iterable[float | None]) -> float | None:
    known = [value for value in values if value is not None]
    return float(np.mean(known)) if known else None


@dataclass(frozen=True)
class MeasureInfo:
    """Description of a measure, for tables."""

    title: str
    better: BetterDirection = "lower"
    unit: str = ""


EMBEDDING_MEASURES: Mapping[str, MeasureInfo] = {
    "frechet_distance": MeasureInfo("Fréchet distance in the embedding"),
    "precision": MeasureInfo("precision: share of the generated that lies among the real", "higher"),
    "recall": MeasureInfo("recall: share of the real that lies among the generated", "higher"),
    "density": MeasureInfo("density of the real around the generated", "higher"),
    "coverage": MeasureInfo("coverage: share of the real with generated nearby", "higher"),
    "two_sample_accuracy": MeasureInfo("nearest-neighbour two-sample accuracy"),
}
MEMORY_MEASURES: Mapping[str, MeasureInfo] = {
    "memorised_share": MeasureInfo("share nearer to the training data than unseen recordings"),
    "training_correlation": MeasureInfo("largest correlation with the training data, median"),
}
CLASSIFIER_MEASURES: Mapping[str, MeasureInfo] = {
    "recognised_accuracy": MeasureInfo("classified correctly by the stroke_cnn trained on real", "higher"),
    "tested_on_generated_accuracy": MeasureInfo(
        "classified correctly by a discriminant trained on real", "higher"
    ),
    "trained_on_generated_accuracy": MeasureInfo(
        "real classified correctly by a discriminant trained on it", "higher"
    ),
}


def describe_measures() -> dict[str, MeasureInfo]:
    """Return the description of every measure, by its name in results."""
    signals = {
        name: MeasureInfo(measure.title, unit="" if measure.unit == "1" else measure.unit)
        for name, measure in signal_measures().items()
    }
    return signals | {**EMBEDDING_MEASURES, **CLASSIFIER_MEASURES, **MEMORY_MEASURES}


@dataclass(frozen=True, eq=False)
class PieceSet:
    """Pieces of one length; ``groups`` numbers the signals that they were cut from."""

    signals: SignalSet
    groups: tuple[int, ...]


@dataclass(frozen=True)
class PiecePlan:
    """Length of pieces, and their number per material."""

    seconds: float
    count: int

    def cut(self, signals: Sequence[Signal]) -> PieceSet:
        """Return ``count`` pieces, spread evenly over ``signals``; `ParameterError` if there are fewer."""
        length = max(1, round(self.seconds * signals[0].rate)) if signals else 1
        pieces = [
            (signal.cut(start, start + length), group)
            for group, signal in enumerate(signals)
            for start in range(0, len(signal) - length + 1, length)
        ]
        if len(pieces) < self.count:
            raise ParameterError(
                f"{self.count} pieces of {self.seconds:g} s are needed, the signals hold {len(pieces)}"
            )
        spread = [pieces[k] for k in (np.arange(self.count) * len(pieces)) // self.count]
        return PieceSet(SignalSet(piece for piece, _ in spread), tuple(group for _, group in spread))

    def draws(self, recordings: Sequence[Signal]) -> tuple[int, float]:
        """Return number and length (s) of the signals to generate in place of ``recordings``.

        As many signals as `cut` uses recordings: pieces of one signal are more alike than pieces of several.
        """
        number = len(set(self.cut(recordings).groups))
        return number, -(-self.count // number) * self.seconds


def plan_pieces(
    train: Mapping[str, Sequence[Signal]],
    test: Mapping[str, Sequence[Signal]],
    *,
    longest_s: float = LONGEST_S,
    most: int = MOST_PIECES,
) -> PiecePlan:
    """Return the largest plan that the recordings of every material of ``test`` allow.

    Pieces are as long as possible up to ``longest_s``, with little remainder; recordings shorter than `SHORTEST_S` are
    left out where every material has longer ones. The number is that of the material with the fewest pieces in either
    part, up to ``most``. Raises `ParameterError` if ``longest_s`` or ``most`` is not positive.
    """
    if not (longest_s > 0 and most >= 1):
        raise ParameterError.must("longest_s", f"be > 0 and most >= 1, got {longest_s:g} and {most}")
    every = [part[material] for part in (train, test) for material in test]
    rate = every[0][0].rate
    length = min(len(signal) for signals in every for signal in signals)
    if length < SHORTEST_S * rate:
        length = min(round(SHORTEST_S * rate), *(max(map(len, signals)) for signals in every))
    length = max(1, length // int(np.ceil(length / (longest_s * rate) - 1e-9)))
    count = min(sum(len(signal) // length for signal in signals) for signals in every)
    return PiecePlan(length / rate, min(count, most))
