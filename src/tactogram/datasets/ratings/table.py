"""Tables of ratings: CSV, TSV or Parquet, with a row per score or a row per rater and item.

*Long*: columns ``rater``, ``item``, ``word``, ``score``. *Wide*: ``rater``, ``item``, and a column per word. Columns
``order`` and ``session`` are optional; the order of columns is free. The ten words of [1] and [2] are recognised in
English, Japanese and romaji (`words.word_of`).

The tables of the published study (IEEE DataPort, DOI 10.21227/5jwn-qx81) were not at hand. The paper describes them as
384 instances of ten scores for 12 plates by 32 people, and 1,248 for 39 signals ([1], Sec. III-A and III-C), hence
probably one wide table each; `RatingColumns.named` maps their headings.
"""

from __future__ import annotations

import csv
from collections import Counter
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any, Literal

import numpy as np
import pyarrow as pa

from tactogram.datasets.cells import finite_number
from tactogram.datasets.parquet_table import read_parquet
from tactogram.datasets.ratings.files import read_ratings, write_ratings
from tactogram.datasets.ratings.ratings import SEVEN_POINT, Ratings, Scale, check_rows
from tactogram.datasets.ratings.words import WORDS, word_of
from tactogram.errors import DataError, ParameterError
from tactogram.signal.io.atomic import atomic_write
from tactogram.text_files import csv_rows, read_text

NAMED = ("rater", "item", "word", "score", "order", "session")
MISSING = ("", "na", "n/a", "nan", "none", "null", "-", "–")
"""Cells that hold no score, in any case."""
SUFFIXES = (".csv", ".tsv", ".parquet")
Form = Literal["long", "wide"]


@dataclass(frozen=True)
class RatingColumns:
    """Columns of a table of ratings.

    Parameters
    ----------
    named : mapping from str to str
        The table's heading of ``rater``, ``item``, ``word``, ``score``, ``order``, ``session`` or of a word.
    words : tuple of str
        Words of the study; by default the ten words. In the wide form each must have a column.
    ignored : tuple of str
        Headings of other columns, such as an age.
    item : str
        Format of an item's name in the store: ``plate{:0>2}`` makes ``7`` ``plate07``.
    encoding : str
        Of a CSV or TSV file; ``cp932`` is that of Japanese Excel.
    """

    named: Mapping[str, str] = field(default_factory=dict)
    words: tuple[str, ...] = ()
    ignored: tuple[str, ...] = ()
    item: str = "{}"
    encoding: str = "utf-8-sig"

    def __post_init__(self) -> None:
        for name in self.named:
            if name not in (*NAMED, *self.vocabulary):
                raise ParameterError(
                    f"a column must be one of {', '.join((*NAMED, *self.vocabulary))}, got {name!r}"
                )
        try:
            "".encode(self.encoding)  # refuses codecs that are not for text
        except LookupError:
            raise ParameterError(f"encoding must be one that Python knows, got {self.encoding!r}") from None
        try:
            self.item.format("1")
        except (IndexError, KeyError, ValueError):
            raise ParameterError(
                f"item must have a place for the cell, such as plate{{:0>2}}, got {self.item!r}"
            ) from None

    @property
    def vocabulary(self) -> tuple[str, ...]:
        """Words of the study, or the ten words."""
        return self.words or WORDS

    def word(self, text: str) -> str | None:
        """Return the word that a heading or a cell means, or None."""
        text = text.strip()
        word = text if text in self.vocabulary else word_of(text)
        return word if word in self.vocabulary else None


@dataclass(frozen=True)
class RatingsTable:
    """Ratings as read from a table, with the number of empty cells by rater; raters without any are left out."""

    ratings: Ratings
    blank: Mapping[str, int]


def read_table(
    path: Path, *, scale: Scale = SEVEN_POINT, columns: RatingColumns | None = None
) -> RatingsTable:
    """Read a table of ratings.

    Parameters
    ----------
    path : Path
        ``.csv``, ``.tsv`` or ``.parquet``; a file of `tactogram.datasets.ratings.files.write_ratings` has its own scale
        and words.
    scale : Scale
    columns : RatingColumns, optional

    Raises
    ------
    DataError
        Naming file and row, if a score is not a number or off the scale, a word is unknown, a rating is repeated, a
        required cell is empty, a column is missing or unknown, or there is no row.
    """
    columns = columns or RatingColumns()
    if path.suffix.lower() not in SUFFIXES:
        raise DataError(f"{path}: a table of ratings must be {', '.join(SUFFIXES)}, got {path.suffix!r}")
    if path.suffix.lower() == ".parquet":
        table = read_parquet(path)
        if b"tactogram" in (table.schema.metadata or {}):
            return RatingsTable(read_ratings(path), {})
        headings, rows = _parquet_rows(table)
    else:
        headings, rows = _text_rows(path, columns.encoding)
    return _Reader(path, scale, columns, headings).read(rows)


def write_table(path: Path, ratings: Ratings, *, form: Form = "long") -> None:
    """Write a table for `read_table`, atomically; Parquet is always long.

    Raises
    ------
    ParameterError
        For another suffix or form.
    """
    suffix = path.suffix.lower()
    if suffix not in SUFFIXES or form not in ("long", "wide"):
        raise ParameterError(
            f"a table of ratings must be {', '.join(SUFFIXES)}, long or wide, got {path.name} {form}"
        )
    if suffix == ".parquet":
        write_ratings(path, ratings)
        return
    rows = _long(ratings) if form == "long" else _wide(ratings)
    with atomic_write(path) as part, part.open("w", encoding="utf-8", newline="") as file:
        csv.writer(file, delimiter="\t" if suffix == ".tsv" else ",").writerows(rows)


class _Reader:
    """Reader of one table, which assigns its columns and reads its rows."""

    def __init__(self, path: Path, scale: Scale, columns: RatingColumns, headings: Sequence[str]) -> None:
        self.path, self.scale, self.columns = path, scale, columns
        self.headings = [heading.strip() for heading in headings]
        self.place: dict[str, int] = {}
        theirs = {heading: ours for ours, heading in columns.named.items()}
        for number, heading in enumerate(self.headings):
            if heading in columns.ignored:
                continue
            name = theirs.get(heading) or self._standard(heading)
            if name is None:
                raise DataError(
                    f"{path}: column {number + 1} {heading!r} is neither a word nor one of {', '.join(NAMED)}; "
                    "column.NAME=HEADING names it, ignore=HEADING leaves it out"
                )
            if name in self.place:
                raise DataError(f"{path}: columns {self.place[name] + 1} and {number + 1} both are {name!r}")
            self.place[name] = number
        self.words = [word for word in columns.vocabulary if word in self.place]
        self.wide = bool(self.words)
        for ours, heading in columns.named.items():
            if ours not in self.place:
                raise DataError(f"{path}: has no column {heading!r}, but {self._listed()}")
        self._check()

    def _standard(self, heading: str) -> str | None:
        lower = heading.casefold()
        return lower if lower in NAMED and lower not in self.columns.named else self.columns.word(heading)

    def _listed(self) -> str:
        return ", ".join(self.headings) or "none"

    def _check(self) -> None:
        if self.wide and ("word" in self.place or "score" in self.place):
            raise DataError(
                f"{self.path}: must have columns word and score, or a column per word, got both: {self._listed()}"
            )
        needed = ("rater", "item", *(self.columns.vocabulary if self.wide else ("word", "score")))
        if missing := [name for name in needed if name not in self.place]:
            hint = "words=A,B lists the words" if self.wide else "column.NAME=HEADING names it"
            raise DataError(
                f"{self.path}: lacks the column {', '.join(missing)}, has {self._listed()}; {hint}"
            )

    def read(self, rows: Iterator[tuple[int, list[str]]]) -> RatingsTable:
        blank: Counter[str] = Counter()
        scored: list[tuple[int, str, str, str, float, int, str]] = []
        count = 0
        for number, cells in rows:
            count += 1
            where = f"{self.path}: row {number}"
            if len(cells) != len(self.headings):
                raise DataError(f"{where}: must have {len(self.headings)} cells, got {len(cells)}")
            rater, item = self._filled(where, "rater", cells), self._filled(where, "item", cells)
            item = self.columns.item.format(item)
            order, session = self._order(where, cells), self._cell("session", cells)
            for word, text in self._scores(where, cells):
                if text.casefold() in MISSING:
                    blank[rater] += 1
                else:
                    score = finite_number(f"{where} ({rater}, {item}, {word})", "score", text)
                    scored.append((number, rater, item, word, score, order, session))
        if not scored:
            rest = f"score in any of its rows ({count})" if count else "row below its headings"
            raise DataError(f"{self.path}: holds no {rest}")
        numbers, raters, items, words, scores, orders, sessions = zip(*scored, strict=True)
        vocabulary = self.columns.words or (
            self.columns.vocabulary if self.wide else tuple(word for word in WORDS if word in set(words))
        )
        table = f"{self.path}: "
        check_rows(raters, items, words, scores, sessions, vocabulary, self.scale, rows=numbers, table=table)
        ratings = Ratings(
            raters, items, words, np.array(scores), self.scale, np.array(orders), sessions, words=vocabulary
        )
        return RatingsTable(ratings, dict(sorted(blank.items())))

    def _scores(self, where: str, cells: Sequence[str]) -> Iterator[tuple[str, str]]:
        if self.wide:
            for word in self.words:
                yield word, cells[self.place[word]].strip()
            return
        text = self._filled(where, "word", cells)
        named = self.columns.word(text)
        if named is None:
            raise DataError(
                f"{where}: word must be one of {', '.join(self.columns.vocabulary)}, got {text!r}"
            )
        yield named, self._cell("score", cells)

    def _cell(self, name: str, cells: Sequence[str]) -> str:
        return cells[self.place[name]].strip() if name in self.place else ""

    def _filled(self, where: str, name: str, cells: Sequence[str]) -> str:
        text = self._cell(name, cells)
        if not text:
            raise DataError(f"{where}: {name} must not be empty")
        return text

    def _order(self, where: str, cells: Sequence[str]) -> int:
        text = self._cell("order", cells)
        if not text:
            return -1
        order = finite_number(where, "order", text)
        if order < 1 or order != int(order):
            raise DataError(f"{where}: order must be a whole number from 1, got {text!r}")
        return int(order)


def _text_rows(path: Path, encoding: str) -> tuple[list[str], Iterator[tuple[int, list[str]]]]:
    """Return the headings, and the rows that are not empty with their numbers as in a spreadsheet."""
    text = read_text(path, encoding=encoding, hint=", or set encoding=cp932 for files of Japanese Excel")
    first = text.partition("\n")[0]
    divider = "\t" if path.suffix.lower() == ".tsv" else max(",;\t", key=first.count)
    (number, headings), *rows = csv_rows(text, path, delimiter=divider) or [(0, [])]
    if number != 1 or not any(cell.strip() for cell in headings):
        raise DataError(f"{path}: must begin with a row of headings, got none")
    return headings, ((n, row) for n, row in rows if any(cell.strip() for cell in row))


def _parquet_rows(table: pa.Table) -> tuple[list[str], Iterator[tuple[int, list[str]]]]:
    """Return the columns' names, and the rows from 1 as text."""
    lists = [[_text(value) for value in column.to_pylist()] for column in table.columns]
    return table.column_names, ((n, list(row)) for n, row in enumerate(zip(*lists, strict=True), 1))


def _text(value: Any) -> str:
    """Return a cell as text: 3.0 and 3 are the same score, rater or item."""
    if value is None:
        return ""
    if isinstance(value, bool):
        return str(int(value))
    return repr(int(value)) if isinstance(value, float) and value.is_integer() else str(value)


def _long(ratings: Ratings) -> Iterator[list[Any]]:
    yield list(NAMED)
    orders = np.asarray(ratings.order).tolist()
    columns = (ratings.rater, ratings.item, ratings.word, ratings.score.tolist(), orders, ratings.session)
    for rater, item, word, score, order, session in zip(*columns, strict=True):
        yield [rater, item, word, _text(score), order if order > 0 else "", session]


def _wide(ratings: Ratings) -> Iterator[list[Any]]:
    yield ["rater", "item", "order", "session", *ratings.words]
    rows: dict[tuple[str, str, str, int], dict[str, float]] = {}
    keys = zip(ratings.rater, ratings.item, ratings.session, np.asarray(ratings.order).tolist(), strict=True)
    for key, word, score in zip(keys, ratings.word, ratings.score.tolist(), strict=True):
        rows.setdefault(key, {})[word] = score
    for (rater, item, session, order), scores in rows.items():
        cells = [_text(scores[word]) if word in scores else "" for word in ratings.words]
        yield [rater, item, order if order > 0 else "", session, *cells]
