"""Answers: a table with one row per answer of a participant, the same for every design.

``stimulus`` is the item (texture, plate, image), ``condition`` its version; ``other`` and the extra column
``other_condition`` are those of the second stimulus. The design's docstring describes the other columns. Answers to the
questions before and after the trials have the ``design`` ``questions`` and no ``stimulus``; those of practice have
``practice``, and the extra column ``practice`` names the design that was practised.
"""

from __future__ import annotations

import csv
import math
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field, fields, replace
from pathlib import Path
from typing import Any

import numpy as np
import pyarrow as pa
import pyarrow.parquet as pq

from tactogram.datasets import cell_text, read_cells
from tactogram.errors import DataError, ParameterError
from tactogram.signal.io import atomic_write

SUFFIXES = (".csv", ".tsv", ".parquet")
Targets = Mapping[str, Mapping[str, float]]
"""Target scores by stimulus and word."""


@dataclass(frozen=True)
class Answer:
    """One answer of one participant.

    Parameters
    ----------
    participant, session : str
        A code (never a name), and the name of the sitting.
    block, trial, repeat : int
        From 1; several answers can belong to one trial.
    side : str
        Slot of the target: ``A``, ``B`` or "".
    value : float
        NaN where the answer is no number.
    correct : bool or None
        None where no answer is right.
    scale_low, scale_high : float
        Ends of the scale, NaN where there was none.
    rt_ms : float
        From presentation to answer, NaN if not measured.
    at : str
        ISO time, UTC. The order of answers follows from ``trial``, never from this.
    played_sha256 : str
        Of the samples that were played for this answer; several are joined by ``+``.
    level : str
        As `tactogram.rendering.level.parse_level` reads it.
    seed : int
        Of the study's order.
    simulated : bool
        Whether a simulated participant answered.
    more : mapping from str to str
        Extra columns.
    """

    study: str
    participant: str
    session: str = "1"
    block: int = 1
    trial: int = 1
    repeat: int = 1
    design: str = ""
    question: str = ""
    condition: str = ""
    stimulus: str = ""
    other: str = ""
    side: str = ""
    answer: str = ""
    value: float = math.nan
    correct: bool | None = None
    scale_low: float = math.nan
    scale_high: float = math.nan
    rt_ms: float = math.nan
    at: str = ""
    played_sha256: str = ""
    level: str = ""
    display: str = ""
    seed: int = 0
    simulated: bool = False
    more: Mapping[str, str] = field(default_factory=dict)


COLUMNS: tuple[str, ...] = tuple(f.name for f in fields(Answer) if f.name != "more")
"""Columns of every table, in this order."""
KINDS: Mapping[str, str] = {f.name: str(f.type) for f in fields(Answer) if f.name != "more"}
NEEDED = ("study", "participant", "design", "question", "answer")
"""Required columns; the others have the defaults of `Answer`."""


@dataclass(frozen=True)
class Answers:
    """A table of answers; each of the ``notes`` says in a line what was left out of the file."""

    rows: tuple[Answer, ...] = ()
    notes: tuple[str, ...] = ()

    def __len__(self) -> int:
        return len(self.rows)

    def __iter__(self) -> Iterator[Answer]:
        return iter(self.rows)

    def column(self, name: str) -> tuple[Any, ...]:
        """Return a column; an extra one as text, "" where a row lacks it, `ParameterError` if all do."""
        if name in COLUMNS:
            return tuple(getattr(row, name) for row in self.rows)
        if name not in self.extra_columns:
            raise ParameterError(
                f"a column must be one of {', '.join((*COLUMNS, *self.extra_columns))}, got {name!r}"
            )
        return tuple(row.more.get(name, "") for row in self.rows)

    def numbers(self, name: str = "value") -> np.ndarray:
        """Return a column of numbers: float64 array, shape (row,); NaN where there is none."""
        return np.array([math.nan if value is None else float(value) for value in self.column(name)])

    def unique(self, name: str) -> tuple[Any, ...]:
        """Return the distinct values of a column, in order of first appearance."""
        return tuple(dict.fromkeys(self.column(name)))

    @property
    def extra_columns(self) -> tuple[str, ...]:
        """Names of the extra columns."""
        return tuple(dict.fromkeys(name for row in self.rows for name in row.more))

    @property
    def people(self) -> int:
        """Number of participants."""
        return len(self.unique("participant"))

    def where(self, keep: Callable[[Answer], bool] | None = None, **values: Any) -> Answers:
        """Return the rows that ``keep`` accepts and whose columns have ``values``.

        A tuple, list or set of values means any of them.
        """
        rows: Iterable[Answer] = self.rows if keep is None else filter(keep, self.rows)
        for name, value in values.items():
            accepted = set(value) if isinstance(value, tuple | list | set | frozenset) else {value}
            common = name in COLUMNS
            rows = [r for r in rows if (getattr(r, name) if common else r.more.get(name, "")) in accepted]
        return Answers(tuple(rows))

    def by(self, name: str) -> dict[Any, Answers]:
        """Return the rows of each value of a column."""
        groups: dict[Any, list[Answer]] = {}
        for value, row in zip(self.column(name), self.rows, strict=True):
            groups.setdefault(value, []).append(row)
        return {value: Answers(tuple(rows)) for value, rows in groups.items()}

    def values_by(self, *names: str) -> dict[tuple[Any, ...], list[float]]:
        """Return the values of each combination of columns."""
        groups: dict[tuple[Any, ...], list[float]] = {}
        for key, row in zip(zip(*map(self.column, names), strict=True), self.rows, strict=True):
            groups.setdefault(key, []).append(row.value)
        return groups

    def participant_means(self, *names: str) -> dict[tuple[Any, ...], list[float]]:
        """Return the means of each participant's values, by combination of columns."""
        means: dict[tuple[Any, ...], list[float]] = {}
        for (*key, _), values in self.values_by(*names, "participant").items():
            means.setdefault(tuple(key), []).append(float(np.mean(values)))
        return means


def cells(answers: Answers) -> tuple[list[str], list[list[str]]]:
    """Return the headings and the rows as text: booleans as ``true`` and ``false``, missing numbers as ""."""
    extra = answers.extra_columns
    rows = [
        [*(cell_text(getattr(row, name)) for name in COLUMNS), *(row.more.get(name, "") for name in extra)]
        for row in answers
    ]
    return [*COLUMNS, *extra], rows


def write_answers(path: Path, answers: Answers) -> None:
    """Write a table as ``.csv``, ``.tsv`` or ``.parquet`` (else `ParameterError`), the whole file or nothing."""
    suffix = _suffix(path)
    with atomic_write(path) as part:
        if suffix == ".parquet":
            pq.write_table(_arrow(answers), part)
        else:
            headings, rows = cells(answers)
            with part.open("w", encoding="utf-8", newline="") as file:
                csv.writer(file, delimiter="\t" if suffix == ".tsv" else ",").writerows([headings, *rows])


def read_answers(path: Path) -> Answers:
    """Read a table that `write_answers` wrote, or another with these columns.

    Raises `DataError`, naming file and row, if a column is missing or a cell is not of its column's type.
    """
    headings, rows, notes = read_cells(path)
    return replace(answers_of(headings, rows, where=str(path)), notes=tuple(notes))


def answers_of(headings: Sequence[str], rows: Sequence[tuple[int, Sequence[str]]], *, where: str) -> Answers:
    """Return the answers of numbered rows of text; unknown columns become extra ones. Raises as `read_answers`."""
    if missing := [name for name in NEEDED if name not in headings]:
        raise DataError(where, f"lacks the column {', '.join(missing)}, has {', '.join(headings)}")
    if twice := next((name for name in headings if name and list(headings).count(name) > 1), ""):
        raise DataError(where, f"has two columns {twice!r}; remove one")
    answers = []
    for number, row in rows:
        texts = {name: cell for name, cell in zip(headings, row, strict=True) if name}
        values = {
            name: _value(texts[name], KINDS[name], f"{where}: row {number}: {name}")
            for name in COLUMNS
            if name in texts and (texts[name] != "" or KINDS[name] == "str")
        }
        answers.append(Answer(**values, more={k: v for k, v in texts.items() if k not in KINDS}))
    return Answers(tuple(answers))


def _value(text: str, kind: str, where: str) -> Any:
    try:
        match kind:
            case "int":
                return int(text)
            case "float":
                return float(text)
            case "str":
                return text
    except ValueError:
        expected = {"int": "a whole number", "float": "a number"}[kind]
        raise DataError(where, f"must be {expected}, got {text!r}") from None
    booleans = {"true": True, "false": False, "1": True, "0": False}
    if text.casefold() not in booleans:
        raise DataError(where, f"must be true or false, got {text!r}")
    return booleans[text.casefold()]


def _suffix(path: Path) -> str:
    suffix = path.suffix.lower()
    if suffix not in SUFFIXES:
        raise ParameterError(f"a table of answers must be {', '.join(SUFFIXES)}, got {path.name}")
    return suffix


def _arrow(answers: Answers) -> pa.Table:
    types = {
        "int": pa.int64(),
        "float": pa.float64(),
        "str": pa.string(),
        "bool": pa.bool_(),
        "bool | None": pa.bool_(),
    }
    table = {}
    for name in COLUMNS:
        values = [None if isinstance(v, float) and math.isnan(v) else v for v in answers.column(name)]
        table[name] = pa.array(values, types[KINDS[name]])
    table |= {name: pa.array(answers.column(name), pa.string()) for name in answers.extra_columns}
    return pa.table(table)
