"""Ratings of surfaces, vibrations and images: a score per rater, item and word, in Parquet files."""

from __future__ import annotations

import hashlib
import json
from collections.abc import Mapping, Sequence
from dataclasses import asdict, dataclass, replace
from functools import cached_property
from pathlib import Path
from typing import Any

import numpy as np
import pyarrow as pa
import pyarrow.parquet as pq
from numpy.typing import NDArray

from tactogram.datasets.cells import read_parquet
from tactogram.errors import DataError, ParameterError
from tactogram.model import ItemRatings
from tactogram.signal.io.atomic import atomic_write

COLUMNS = ("rater", "item", "word", "score", "order", "session")


@dataclass(frozen=True)
class Scale:
    """Scale of a score.

    Parameters
    ----------
    name : str
    low, high : float
        Lowest and highest score.
    step : float, optional
        Distance of possible scores; None allows anything between, as for means.
    """

    name: str
    low: float
    high: float
    step: float | None = None

    def __post_init__(self) -> None:
        if not (np.isfinite(self.low) and np.isfinite(self.high) and self.low < self.high):
            raise ParameterError(f"a scale must go from low to high, got {self.low} to {self.high}")
        if self.step is not None and not 0 < self.step <= self.high - self.low:
            raise ParameterError(
                f"step of a scale must be > 0 and at most {self.high - self.low:g}, got {self.step}"
            )

    def to_unit(self, scores: NDArray[np.float64] | float) -> Any:
        """Return scores, of any shape and in points of the scale, as 0 (lowest) to 1 (highest)."""
        return (scores - self.low) / (self.high - self.low)

    def from_unit(self, shares: NDArray[np.float64] | float) -> Any:
        """Return shares of 0 to 1, of any shape, in points of the scale: the inverse of `to_unit`."""
        return self.low + shares * (self.high - self.low)

    def holds(self, score: float) -> bool:
        """Return whether ``score`` is on the scale."""
        if not self.low <= score <= self.high:
            return False
        steps = 0.0 if self.step is None else (score - self.low) / self.step
        return abs(steps - round(steps)) < 1e-6

    def __str__(self) -> str:
        """Return the range in words: ``1 to 7 in steps of 1``."""
        return f"{self.low:g} to {self.high:g}" + (f" in steps of {self.step:g}" if self.step else "")


SEVEN_POINT = Scale("7-point unipolar", 1.0, 7.0, 1.0)
"""1 (negative) to 7 (positive)."""


EVOKED = Scale("evoked", 0.0, 1.0, 1.0)
"""0: the word was not evoked; 1: it was."""


SCALES: Mapping[str, Scale] = {scale.name: scale for scale in (SEVEN_POINT, EVOKED)}


def scale_of(text: str) -> Scale:
    """Return the scale of that name, or ``LOW:HIGH`` or ``LOW:HIGH:STEP``; else a `ParameterError`."""
    if text in SCALES:
        return SCALES[text]
    if text == "7-point":
        return SEVEN_POINT
    try:
        low, high, *rest = (float(part) for part in text.split(":"))
        if len(rest) > 1:
            raise ValueError(text)  # noqa: TRY301
    except ValueError:
        raise ParameterError(
            f"a scale must be 7-point, evoked, LOW:HIGH or LOW:HIGH:STEP (-3:3:1), got {text!r}"
        ) from None
    return Scale(text, low, high, *rest)


@dataclass(frozen=True, eq=False)
class Ratings:
    """A table with one row per score, in columns of equal length.

    Parameters
    ----------
    rater, item, word : sequence of str
        ``item`` is a recording's or a photograph's `item_of`.
    score : float64 array, shape (row,)
        On ``scale``, never NaN: a missing rating has no row.
    scale : Scale
    order : int64 array, shape (row,), optional
        Position of the item in the rater's session, from 1; -1 if unknown.
    session : sequence of str, optional
        Empty if unknown.
    words : sequence of str, optional
        All words of the study, in order; by default those that occur, in the order of their first row.

    Raises
    ------
    DataError
        Naming the row (from 1): a score off the scale, a word that is not among ``words``, or a repeated rating in one
        session.
    """

    rater: tuple[str, ...]
    item: tuple[str, ...]
    word: tuple[str, ...]
    score: NDArray[np.float64]
    scale: Scale = SEVEN_POINT
    order: NDArray[np.int64] | None = None
    session: tuple[str, ...] = ()
    words: tuple[str, ...] = ()

    def __post_init__(self) -> None:
        count = len(self.rater)
        fill = object.__setattr__
        for name in ("rater", "item", "word"):
            fill(self, name, tuple(getattr(self, name)))
        fill(self, "score", _frozen(np.array(self.score, np.float64)))
        order = np.full(count, -1) if self.order is None else np.array(self.order)
        fill(self, "order", _frozen(order.astype(np.int64)))
        fill(self, "session", tuple(self.session) or ("",) * count)
        fill(self, "words", tuple(self.words) or tuple(dict.fromkeys(self.word)))
        if len(set(self.words)) != len(self.words):
            raise ParameterError.must("words", "differ", ", ".join(self.words))
        columns: tuple[Any, ...] = (self.item, self.word, self.score, self.order, self.session)
        if any(len(column) != count for column in columns):
            raise ParameterError.must(
                "columns",
                f"be of one length, got {count} raters and {', '.join(str(len(c)) for c in columns)}",
            )
        if not count:
            raise DataError("ratings must have a row, got none")
        check_rows(
            self.rater, self.item, self.word, self.score.tolist(), self.session, self.words, self.scale
        )

    def __len__(self) -> int:
        return len(self.rater)

    def __contains__(self, item: object) -> bool:
        return item in self._place

    @cached_property
    def items(self) -> tuple[str, ...]:
        """Rated items, sorted."""
        return tuple(sorted(set(self.item)))

    @cached_property
    def raters(self) -> tuple[str, ...]:
        """Raters, sorted."""
        return tuple(sorted(set(self.rater)))

    @cached_property
    def cube(self) -> NDArray[np.float64]:
        """Scores, float64, shape (item, rater, word), NaN if missing; the mean of several sessions."""
        shape = (len(self.items), len(self.raters), len(self.words))
        places = tuple(
            np.array([number[name] for name in column])
            for column, number in (
                (self.item, {name: n for n, name in enumerate(self.items)}),
                (self.rater, {name: n for n, name in enumerate(self.raters)}),
                (self.word, {name: n for n, name in enumerate(self.words)}),
            )
        )
        total, count = np.zeros(shape), np.zeros(shape)
        np.add.at(total, places, self.score)
        np.add.at(count, places, 1.0)
        with np.errstate(invalid="ignore"):
            cube: NDArray[np.float64] = total / count
        cube.flags.writeable = False
        return cube

    @cached_property
    def sha256(self) -> str:
        """Hash of scale, words and rows, whatever their order."""
        rows = sorted(
            zip(self.rater, self.item, self.word, self.session, self.score.tolist(), self._order, strict=True)
        )
        text = json.dumps([asdict(self.scale), list(self.words), rows], ensure_ascii=False)
        return hashlib.sha256(text.encode()).hexdigest()

    @property
    def _order(self) -> list[int]:
        return [] if self.order is None else self.order.tolist()

    @property
    def means(self) -> NDArray[np.float64]:
        """Mean over the raters with a score, float64, shape (item, word), NaN if there is none."""
        rated = ~np.isnan(self.cube)
        with np.errstate(invalid="ignore"):
            means: NDArray[np.float64] = np.where(rated, self.cube, 0).sum(1) / rated.sum(1)
        return means

    def rated(self, item: str) -> ItemRatings:
        """Return the ratings of one item as 0 to 1, for learners; `ParameterError` if it was not rated."""
        if item not in self:
            raise ParameterError.must("item", f"be one of the {len(self.items)} that were rated", item)
        scores = self.cube[self._place[item]]
        who = ~np.isnan(scores).all(1)
        raters = tuple(name for name, has in zip(self.raters, who, strict=True) if has)
        return ItemRatings(self.words, raters, self.scale.to_unit(scores[who]))

    @cached_property
    def _place(self) -> dict[str, int]:
        return {name: number for number, name in enumerate(self.items)}

    def select(self, *, items: Sequence[str] | None = None, raters: Sequence[str] | None = None) -> Ratings:
        """Return the rows of some items or raters."""
        chosen = set(self.items if items is None else items)
        people = set(self.raters if raters is None else raters)
        keep = [n for n in range(len(self)) if self.item[n] in chosen and self.rater[n] in people]
        kept: dict[str, Any] = {name: [getattr(self, name)[n] for n in keep] for name in COLUMNS}
        return replace(self, **kept)

    def in_words(self, words: Sequence[str]) -> Ratings:
        """Return the same ratings with their words in another order; `DataError` if ``words`` are others."""
        if sorted(words) != sorted(self.words):
            raise DataError(f"ratings must be of {', '.join(words)}, got {', '.join(self.words)}")
        return replace(self, words=tuple(words))


def join_ratings(tables: Sequence[Ratings]) -> Ratings:
    """Return the rows of several tables as one, e.g. of those who rated surfaces and those who rated signals.

    Raises `DataError` if they differ in scale or words, or contain the same rating.
    """
    first = tables[0]
    for other in tables[1:]:
        if other.scale != first.scale or set(other.words) != set(first.words):
            raise DataError(
                "tables of ratings must have one scale and the same words, got "
                f"{first.scale} ({', '.join(first.words)}) and {other.scale} ({', '.join(other.words)}); words=A,B "
                "names the words of all"
            )
    every: dict[str, Any] = {name: [x for table in tables for x in getattr(table, name)] for name in COLUMNS}
    return replace(first, **every)


def check_rows(
    rater: Sequence[str],
    item: Sequence[str],
    word: Sequence[str],
    score: Sequence[float],
    session: Sequence[str],
    words: Sequence[str],
    scale: Scale,
    *,
    rows: Sequence[int] = (),
    table: str = "",
) -> None:
    """Raise the `DataError` of `Ratings`, naming the ``table`` and the numbers of its ``rows``."""
    first: dict[tuple[str, str, str, str], int] = {}
    vocabulary = set(words)
    for number, key in enumerate(zip(rater, item, word, session, strict=True)):
        where = f"{table}row {rows[number] if rows else number + 1} ({key[0]}, {key[1]}, {key[2]})"
        if key[2] not in vocabulary:
            raise DataError(where, f"word must be one of {', '.join(words)}, got {key[2]!r}")
        if not scale.holds(score[number]):
            raise DataError(where, f"score must be {scale}, got {score[number]:g}")
        if (before := first.setdefault(key, number)) != number:
            same = rows[before] if rows else before + 1
            raise DataError(
                where,
                f"row {same} is the same rating; leave one out, or name what differs (column.session=HEADING)",
            )


def _frozen(values: NDArray[Any]) -> NDArray[Any]:
    values.flags.writeable = False
    return values


def write_ratings(path: Path, ratings: Ratings) -> None:
    """Write a Parquet file; the whole file or nothing."""
    about = {"scale": asdict(ratings.scale), "words": list(ratings.words)}
    table = pa.table({name: pa.array(getattr(ratings, name)) for name in COLUMNS})
    with atomic_write(path) as part:
        pq.write_table(table.replace_schema_metadata({"tactogram": json.dumps(about)}), part)


def read_ratings(file: Path | pa.NativeFile, *, name: str = "") -> Ratings:
    """Read a file of `write_ratings`; `DataError`, which gives its ``name``, if it is something else."""
    try:
        table = read_parquet(file, name)
        about = json.loads((table.schema.metadata or {})[b"tactogram"])
        columns = {name: table[name].to_pylist() for name in COLUMNS}
        return Ratings(**columns, scale=Scale(**about["scale"]), words=tuple(about["words"]))
    except (KeyError, TypeError, ValueError, DataError) as error:
        raise DataError(name or file, f"not a table of ratings: {error}") from error
