"""Rows of plain numbers below the head of a text table: read at once, and in blocks if they are many.

`tactogram.signal.io.table` looks at every line of a table. What it says of the first ones holds for all if the others
are numbers in as many columns, which pyarrow's reader checks. The form of a table is remembered for the next file with
the same head.
"""

from __future__ import annotations

import re
from collections.abc import Callable, Iterator
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from tactogram.errors import DataError
from tactogram.signal.io.content import RawTable
from tactogram.signal.io.table_columns import MISSING_FORMS, is_empty

FIRST_BYTES = 2**14
"""Beginning of a file that is looked at line by line."""
BLOCK_BYTES = 2**23
"""Of a long file that is in memory at a time."""
MOST_FORMS = 16
Reader = Callable[[Path, bytes], RawTable]
"""Reads a table line by line."""
_SEPARATORS = ("\t", ";", ",", "|", " ")
_CALENDAR = re.compile(rb"(?<![\d.])(?:\d{14}|\d{17})(?![\d.])")
"""Digits that may spell date and time."""


@dataclass(frozen=True, eq=False)
class NumericForm:
    """Form of a table: the lines above its numbers, what they say, and how a row is written."""

    head: bytes
    first: RawTable  # of the first rows
    separator: str
    decimal: str

    def table(self, path: Path, raw: bytes) -> RawTable | None:
        """Return the table in a file with this head; None if a row is not a number, or nothing, in each column."""
        columns = self.columns(raw, len(self.head))
        if columns is None:
            return None
        rows = range(self.first.rows[0], self.first.rows[0] + len(columns[0]))
        return replace(self.first, path=path, columns=tuple(columns), rows=rows)

    def columns(self, raw: bytes, start: int = 0) -> list[NDArray[np.float64]] | None:
        """Return the columns of the whole lines from a byte on; None if there is another line than of numbers."""
        import pyarrow as pa
        import pyarrow.csv as pc

        names = [*map(str, range(len(self.first.headings)))]
        rows = pa.py_buffer(raw).slice(start)
        if not raw.endswith(b"\n") or _CALENDAR.search(raw, start, raw.find(b"\n", start)):
            return None
        try:
            table = pc.read_csv(
                pa.BufferReader(rows),
                pc.ReadOptions(column_names=names, block_size=max(1, len(rows)), use_threads=False),
                pc.ParseOptions(delimiter=self.separator, quote_char=False, ignore_empty_lines=False),
                pc.ConvertOptions(
                    column_types=dict.fromkeys(names, pa.float64()),
                    null_values=MISSING_FORMS,
                    decimal_point=self.decimal,
                ),
            )
        except pa.ArrowInvalid:
            return None
        if all(column.null_count for column in table.columns):  # perhaps of an empty line
            return None
        columns = [column.to_numpy() for column in table.columns]
        named = [self.first.named and bool(text) for text in self.first.headings]
        unnamed = [column for column, known in zip(columns, named, strict=True) if not known]
        return None if any(map(is_empty, unnamed)) else columns


_FORMS: dict[tuple[bytes, str, str], NumericForm] = {}
"""Forms of tables with headings, the last ones met."""


def numeric_table(path: Path, raw: bytes, read: Reader) -> RawTable | None:
    """Return a table whose rows are plain numbers; None for another, or if the first bytes do not tell."""
    result = _form_and_table(path, raw, read)
    return result and result[1]


def long_table(path: Path, read: Reader) -> RawTable | None:
    """Return the first rows of a table of plain numbers that is not read at once (`RawTable.rest`); errors as ``read``.

    None if the first block holds anything else. A later block that does is read line by line.
    """
    with path.open("rb") as file:
        first = file.read(BLOCK_BYTES) + file.readline()
        result = _form_and_table(path, first, read)
        if result is None:
            return None
        more, last = 0, first
        while block := file.read(BLOCK_BYTES):
            more, last = more + block.count(b"\n"), block
    form, table = result

    def rest() -> Iterator[RawTable]:
        import pyarrow as pa

        number = table.rows[-1] + 1
        with path.open("rb") as file:
            file.seek(len(first))
            while raw := file.read(BLOCK_BYTES) + file.readline():
                columns = form.columns(raw)
                rows = range(number, number + (raw.count(b"\n") if columns is None else len(columns[0])))
                if columns is not None:
                    yield replace(table, columns=tuple(columns), rows=rows, notes=(), rest=None)
                else:
                    yield _line_by_line(form, table, raw, rows, read)
                number = rows.stop
        pa.default_memory_pool().release_unused()

    return replace(table, rest=rest, most_rows=len(table) + more + (not last.endswith(b"\n")))


def _line_by_line(form: NumericForm, table: RawTable, raw: bytes, rows: range, read: Reader) -> RawTable:
    """Return a block of a long table with other lines than rows of numbers."""
    part = read(table.path, form.head + raw)
    if part.headings != table.headings:
        raise DataError(f"{table.path}: rows {rows.start} to {rows.stop}", "expected columns as above")
    above = rows.start - form.head.count(b"\n") - 1
    notes = tuple(f"from row {rows.start} on: {note}" for note in part.notes if note not in table.notes)
    return replace(part, rows=[number + above for number in part.rows], notes=notes)


def _form_and_table(path: Path, raw: bytes, read: Reader) -> tuple[NumericForm, RawTable] | None:
    for form in reversed(_FORMS.values()):
        if raw.startswith(form.head) and (table := form.table(path, raw)) is not None:
            return form, table
    new_form = _form_of(path, raw[: raw.rfind(b"\n", 0, FIRST_BYTES) + 1], read)
    if new_form is None:
        return None
    if re.search(rb"[A-Za-z]", new_form.head):
        _FORMS[new_form.head, new_form.separator, new_form.decimal] = new_form
        while len(_FORMS) > MOST_FORMS:
            del _FORMS[next(iter(_FORMS))]
    table = new_form.table(path, raw)
    return None if table is None else (new_form, table)


def _form_of(path: Path, first: bytes, read: Reader) -> NumericForm | None:
    """Return the form in which the first lines of a file give the columns that they have line by line."""
    try:
        table = read(path, first)
    except DataError:
        return None
    lines = first.count(b"\n")
    alike = [*table.rows] == [*range(lines - len(table) + 1, lines + 1)] and len(table) > 1
    if not alike or first.count(b"\r") not in (0, lines) or any(c.dtype == object for c in table.columns):
        return None
    head = b"".join(first.splitlines(keepends=True)[: lines - len(table)])
    for separator in _SEPARATORS:
        for decimal in ".,":
            if separator == decimal:
                continue
            form = NumericForm(head, table, separator, decimal)
            columns = form.columns(first, len(head))
            if columns is not None and all(
                np.allclose(ours, theirs, rtol=1e-14, atol=0, equal_nan=True)
                for ours, theirs in zip(columns, table.columns, strict=True)
            ):
                return form
    return None
