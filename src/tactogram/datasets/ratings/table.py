"""Tables of ratings, with a row per score or a row per rater and item, and exports of questionnaires.

*Long*: columns ``rater``, ``item``, ``word``, ``score``. *Wide*: ``rater``, ``item``, and a column per word. Columns
``order`` and ``session`` are optional; the order of columns is free. The ten words of [1] and [2] are recognised in
English, Japanese and romaji (`words.word_of`). PsychoPy's, jsPsych's, Qualtrics' and Google Forms' exports become the
long form (`questions.Questions`).

The tables of the published study (IEEE DataPort, DOI 10.21227/5jwn-qx81) were not at hand. The paper describes them as
384 instances of ten scores for 12 plates by 32 people, and 1,248 for 39 signals ([1], Sec. III-A and III-C), hence
probably one wide table each; `RatingColumns.named` maps their headings.
"""

from __future__ import annotations

import csv
from collections import Counter
from collections.abc import Collection, Iterator, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Literal

import numpy as np

from tactogram.datasets.cells import Cells, cell_text, finite_number, read_cells, read_parquet
from tactogram.datasets.ratings.questionnaires import export_of, rows_left_out
from tactogram.datasets.ratings.questions import MISSING, NAMED, Questions, RatingColumns
from tactogram.datasets.ratings.ratings import (
    SEVEN_POINT,
    Ratings,
    Scale,
    check_rows,
    read_ratings,
    write_ratings,
)
from tactogram.datasets.ratings.words import WORDS
from tactogram.errors import DataError, ParameterError
from tactogram.signal.io.atomic import atomic_write

SUFFIXES = (".csv", ".tsv", ".parquet")
YES_NO = {"true": "1", "false": "0"}
READ_SUFFIXES = (*SUFFIXES, ".xlsx", ".json")
Form = Literal["long", "wide"]


@dataclass(frozen=True)
class RatingsTable:
    """Ratings as read from a table, with the number of empty cells by rater; raters without any are left out.

    Each of the ``notes`` says in a line what was left out.
    """

    ratings: Ratings
    blank: Mapping[str, int]
    notes: Sequence[str] = ()


def read_table(
    path: Path,
    *,
    scale: Scale = SEVEN_POINT,
    columns: RatingColumns | None = None,
    items: Collection[str] = (),
) -> RatingsTable:
    """Read a table of ratings.

    Parameters
    ----------
    path : Path
        ``.csv``, ``.tsv``, ``.parquet``, ``.xlsx`` or ``.json``; a file of
        `tactogram.datasets.ratings.ratings.write_ratings` has its own scale and words.
    items : collection of str
        Names of items, by which they are found in the questions of a questionnaire.

    Raises
    ------
    DataError
        Naming file and row, if a score is not a number or off the scale, a word is unknown, a rating is repeated, a
        required cell is empty, a column is missing or unknown, or there is no row.
    """
    columns = columns or RatingColumns()
    if path.suffix.lower() not in READ_SUFFIXES:
        raise DataError(path, f"a table of ratings must be {', '.join(READ_SUFFIXES)}, got {path.suffix!r}")
    if path.suffix.lower() == ".parquet" and b"tactogram" in (read_parquet(path).schema.metadata or {}):
        return RatingsTable(read_ratings(path), {})
    table = read_cells(path, encoding=columns.encoding)
    export = export_of(path, table, low=scale.low, ignored=columns.ignored)
    if export.program:
        table, columns = Questions(export, columns, scale, items).read()
    return _Reader(path, scale, columns, table).read()


def write_table(path: Path, ratings: Ratings, *, form: Form = "long") -> None:
    """Write a table for `read_table`, atomically; Parquet is always long.

    Raises `ParameterError` for another suffix or form.
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

    def __init__(self, path: Path, scale: Scale, columns: RatingColumns, table: Cells) -> None:
        self.path, self.scale, self.columns = path, scale, columns
        self.headings, self.rows, self.notes = table.headings, table.rows, [*table.notes]
        left = []
        self.place: dict[str, int] = {}
        theirs = {heading: ours for ours, heading in columns.named.items()}
        for number, heading in enumerate(self.headings):
            if not heading or columns.ignores(heading):
                continue
            name = theirs.get(heading) or self._standard(heading)
            if name is None and "*" in columns.ignored:
                left.append(heading)
                continue
            if name is None:
                raise DataError(
                    path,
                    f"column {number + 1} {heading!r} is neither a word nor one of {', '.join(NAMED)}; "
                    "column.NAME=HEADING names it, ignore=HEADING (or *) leaves it out",
                )
            if name in self.place:
                raise DataError(path, f"columns {self.place[name] + 1} and {number + 1} both are {name!r}")
            self.place[name] = number
        self.words = [word for word in columns.vocabulary if word in self.place]
        for ours, heading in columns.named.items():
            if ours not in self.place:
                raise DataError(path, f"has no column {heading!r}, but {self._listed()}")
        if left:
            self.notes.append(f"columns left out: {', '.join(left)}")
        self._check()

    def _standard(self, heading: str) -> str | None:
        lower = heading.casefold()
        return lower if lower in NAMED and lower not in self.columns.named else self.columns.word(heading)

    def _listed(self) -> str:
        return ", ".join(self.headings) or "none"

    def _check(self) -> None:
        if self.words and ("word" in self.place or "score" in self.place):
            raise DataError(
                self.path,
                f"must have columns word and score, or a column per word, got both: {self._listed()}",
            )
        needed = ("rater", "item", *(self.columns.vocabulary if self.words else ("word", "score")))
        if missing := [name for name in needed if name not in self.place]:
            hint = "words=A,B lists the words" if self.words else "column.NAME=HEADING names it"
            raise DataError(self.path, f"lacks the column {', '.join(missing)}, has {self._listed()}; {hint}")

    def read(self) -> RatingsTable:
        blank: Counter[str] = Counter()
        scored: list[tuple[int, str, str, str, float, int, str]] = []
        empty, without = [], []
        for number, row in self.rows:
            where = f"{self.path}: row {number}"
            cells = {name: row[n].strip() for name, n in self.place.items()}
            texts = {w: cells[w] for w in self.words} if self.words else {cells["word"]: cells["score"]}
            if not cells["item"] and all(cell.casefold() in MISSING for cell in texts.values()):
                empty.append(number)
                continue
            rater, item = (
                _filled(where, "rater", cells),
                self.columns.item.format(_filled(where, "item", cells)),
            )
            if item in self.columns.without:
                without.append(number)
                continue
            order, session = _order(where, cells.get("order", "")), cells.get("session", "")
            for heading, cell in texts.items():
                word = heading if self.words else self._word(where, _filled(where, "word", cells))
                text = YES_NO.get(cell.casefold(), cell) if self.scale.high == 1 else cell
                if text.casefold() in MISSING:
                    blank[rater] += 1
                else:
                    score = finite_number(f"{where} ({rater}, {item}, {word})", "score", text)
                    scored.append((number, rater, item, word, score, order, session))
        if not scored:
            count = len(self.rows)
            rest = f"score in any of its rows ({count})" if count else "row below its headings"
            raise DataError(self.path, f"holds no {rest}")
        numbers, raters, items, words, scores, orders, sessions = zip(*scored, strict=True)
        vocabulary = self.columns.words or (
            self.columns.vocabulary if self.words else tuple(word for word in WORDS if word in set(words))
        )
        table = f"{self.path}: "
        check_rows(raters, items, words, scores, sessions, vocabulary, self.scale, rows=numbers, table=table)
        ratings = Ratings(
            raters, items, words, np.array(scores), self.scale, np.array(orders), sessions, words=vocabulary
        )
        self.notes += rows_left_out("without item and score", empty)
        self.notes += rows_left_out(f"of {', '.join(self.columns.without)}", sorted(set(without)))
        return RatingsTable(ratings, dict(sorted(blank.items())), tuple(self.notes))

    def _word(self, where: str, text: str) -> str:
        if (word := self.columns.word(text)) is None:
            known = ", ".join(self.columns.vocabulary)
            raise DataError(where, f"word must be one of {known}, got {text!r}")
        return word


def _filled(where: str, name: str, cells: Mapping[str, str]) -> str:
    if not cells[name]:
        raise DataError(where, f"{name} must not be empty")
    return cells[name]


def _order(where: str, text: str) -> int:
    if not text:
        return -1
    order = finite_number(where, "order", text)
    if order < 1 or order != int(order):
        raise DataError(where, f"order must be a whole number from 1, got {text!r}")
    return int(order)


def _long(ratings: Ratings) -> Iterator[list[Any]]:
    yield list(NAMED)
    orders = np.asarray(ratings.order).tolist()
    columns = (ratings.rater, ratings.item, ratings.word, ratings.score.tolist(), orders, ratings.session)
    for rater, item, word, score, order, session in zip(*columns, strict=True):
        yield [rater, item, word, cell_text(score), order if order > 0 else "", session]


def _wide(ratings: Ratings) -> Iterator[list[Any]]:
    yield ["rater", "item", "order", "session", *ratings.words]
    rows: dict[tuple[str, str, str, int], dict[str, float]] = {}
    keys = zip(ratings.rater, ratings.item, ratings.session, np.asarray(ratings.order).tolist(), strict=True)
    for key, word, score in zip(keys, ratings.word, ratings.score.tolist(), strict=True):
        rows.setdefault(key, {})[word] = score
    for (rater, item, session, order), scores in rows.items():
        cells = [cell_text(scores[word]) if word in scores else "" for word in ratings.words]
        yield [rater, item, order if order > 0 else "", session, *cells]
