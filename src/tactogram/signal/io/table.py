"""Text tables: foreign ones as they are, own ones exact to the last bit."""

from __future__ import annotations

import csv
import re
from collections import Counter
from collections.abc import Sequence
from contextlib import suppress
from pathlib import Path

import numpy as np

from tactogram.errors import DataError
from tactogram.signal.io.content import Column, RawTable, SignalDescription, decode
from tactogram.signal.io.numeric_rows import numeric_table
from tactogram.signal.io.stamps import is_stamp
from tactogram.signal.io.table_columns import (
    converted,
    footer_of,
    is_empty,
    start_and_rate,
    text_columns,
    with_unit,
)
from tactogram.signal.io.table_head import (
    TableHead,
    body_start,
    head_of,
    increment_in,
    is_number,
    rate_in,
    units_in,
)
from tactogram.signal.io.text_rows import (
    SNIFFED_ROWS,
    NumberedLine,
    TextRows,
    cleaned,
    is_ruler,
    pairs_apart,
    prefix_apart,
    separator_of,
    split,
    without_brackets,
)
from tactogram.signal.io.vocabulary import heading as heading_of
from tactogram.signal.signal import Signal
from tactogram.text_files import detected_text

COMMENTS = ("#", "%", "//", ";")
SIDE_ROWS = 40
"""Rows of numbers beside which settings are looked for."""
LINES_ABOVE = "the lines above"
_SNIFFED_BYTES = 8192
_YAML = re.compile(r"\s*(?:[\w/]+:(?:\s+\S+)?|---|- \S+)\s*")


def text_table(path: Path, raw: bytes) -> RawTable:
    """Return the columns of a text table with one row per sample, as `table_by_lines` finds them."""
    return numeric_table(path, raw, table_by_lines) or table_by_lines(path, raw)


def table_by_lines(path: Path, raw: bytes) -> RawTable:
    """Return the columns of a text table with one row per sample.

    Lines of a logger above the heading and comments are no rows; a line below the headings may hold units. Separators
    are tabs, semicolons, commas, bars or blanks, whichever fits; decimals have points, or commas where these do not
    separate. Lines may be pairs (``x:0.1 y:0.2``), in brackets, or begin with the time of a terminal
    (``10:23:45.123 -> 1,2``). A last line that was cut off is left out and noted. A `DataError` names the line.
    """
    if not raw:
        raise DataError(path, "empty file")
    notes = []
    if raw.endswith(b"\0") and raw.count(0) < len(raw) // 4:
        raw = raw.rstrip(b"\0")
        notes.append("zero bytes at the end left out")
    text, encoding = detected_text(raw, path)
    if not encoding.startswith("utf"):
        notes.append(f"text read as {encoding}, not UTF-8")
    lines = cleaned(text).split("\n")
    separator, comments, rows = _lines(lines, path)
    description = next(
        (parsed for line in comments[:3] if (parsed := decode(line[1:].strip(), str(path)))), None
    )
    rows, stamps = prefix_apart(rows)
    rows, names = pairs_apart(without_brackets(rows))
    if not separator:
        middle = [line.text for line in rows[len(rows) // 2 :][:SNIFFED_ROWS]]
        try:
            separator = "\t" if names else separator_of(middle)
        except csv.Error as error:
            raise DataError(path, f"not a table: {error}; is a quote left open?") from None
    grid = TextRows(path, rows, separator, notes=notes)
    grid.divide()
    head = TableHead(tuple(names), (), named=True) if names else _head(grid, comments)
    if not head.named:
        grid.check_commas()
    body = grid.rows(ended=not lines[-1].strip())
    sample = [cell for line in body[:SNIFFED_ROWS] for cell in grid.cells(line.text)]
    try:
        columns, behind = text_columns([line.text for line in body], sample, grid.width, separator)
    except DataError as error:
        raise DataError(path, error) from None
    facts = [*comments, *(line.text for line in rows[: grid.start + SIDE_ROWS])]
    rate, numbers = increment_in(grid.above) or rate_in(facts), [line.number for line in body]
    if not head.named and (stated := start_and_rate(columns)):
        rate, columns, numbers = stated, [column[2:] for column in columns], numbers[2:]
        notes.append("the first two rows are the start and the rate, as Empatica's E4 writes them")
    units = [unit or other for unit, other in zip(head.units or [None] * grid.width, behind, strict=True)]
    headings = [*head.headings]
    across, along = units_in(facts)
    if along is not None and any(line.strip(" ,").lower() == "mode,fast" for line in facts):
        along = None
        notes.append("GW Instek's fast mode: counts, 25 to a division of the vertical scale")
    if length := re.search(r"\blength units?[ ,;:=]+([a-z]+)", " ".join(facts), re.IGNORECASE):  # OptiTrack
        units = [
            length[1] if unit is None and heading_of(name).quantity == "position" else unit
            for name, unit in zip(headings, units, strict=True)
        ]
    if along is not None and not any(units) and not any(re.search(r"[\[(]", name) for name in headings):
        units = [_side_unit(column, across, along) for column in columns]
    if stamps is not None:
        places = dict(zip((line.number for line in rows), stamps[1], strict=True))
        headings, units = [stamps[0], *headings], [None, *units]
        columns = [converted([places[number] for number in numbers]), *columns]
    return _table(
        path, headings, columns, units, numbers, rate, head.named, description=description, notes=notes
    )


def table_of_cells(path: Path, cells: Sequence[Sequence[object]], *, name: str = "") -> RawTable:
    """Return the columns of a worksheet, given the cells of all its rows; ``name`` is the sheet's."""
    filled = [(n, [*row]) for n, row in enumerate(cells, 1) if any(cell not in (None, "") for cell in row)]
    if not filled:
        raise DataError(path, f"no rows{f' in sheet {name!r}' if name else ''}")
    numbers, rows = [n for n, _ in filled], [row for _, row in filled]
    ends = [max(i for i, cell in enumerate(row, 1) if cell not in (None, "")) for row in rows]
    common = (
        Counter(part).most_common(1)[0][0] for part in (ends[len(ends) // 2 :][:SNIFFED_ROWS], ends[:5])
    )
    width = max(common)
    cut = [row[:width] + [None] * (width - len(row)) for row in rows]
    start = body_start(cut[: 5 * SNIFFED_ROWS], cut[len(cut) // 2 :][:SNIFFED_ROWS], width)
    if start is None:
        raise DataError(path, "no rows of numbers below the heading")
    if start and all(isinstance(cell, str) for cell in rows[start - 1] if cell is not None):
        width = max(width, ends[start - 1])  # a column that is empty in most rows
    rows = [row[:width] + [None] * (width - len(row)) for row in rows]
    above = [row[:end] for row, end in zip(rows[:start], ends, strict=False)]
    head = head_of(above, width)
    columns = [_of_cells([row[i] for row in rows[start:]]) for i in range(width)]
    rate = increment_in(above) or rate_in([" ".join(str(c) for c in row if c is not None) for row in above])
    return _table(path, [*head.headings], columns, [*head.units], numbers[start:], rate, head.named)


def _table(
    path: Path,
    headings: Sequence[str],
    columns: Sequence[Column],
    units: Sequence[str | None],
    rows: Sequence[int],
    rate: float | None,
    named: bool,
    *,
    description: SignalDescription | None = None,
    notes: Sequence[str] = (),
) -> RawTable:
    if footer := footer_of(columns):
        columns = [_numbers(column[:-footer]) for column in columns]
        notes = [
            *notes,
            f"the last {footer} rows hold words, as of a summary: left out, from row {rows[-footer]}",
        ]
        rows = rows[:-footer]
    kept = [i for i, column in enumerate(columns) if (named and headings[i]) or not is_empty(column)]
    return RawTable(
        path,
        tuple(headings[i] for i in kept),
        tuple(columns[i] for i in kept),
        units=tuple(units[i] for i in kept) if any(units) else (),
        named=named,
        rows=rows,
        rate=rate if description is None else description.rate,
        rate_name=LINES_ABOVE,
        description=description,
        notes=tuple(notes),
    )


def _of_cells(cells: Sequence[object]) -> Column:
    """Return cells of a worksheet; numbers that it holds as text may have decimal commas."""
    texts = [cell for cell in cells if isinstance(cell, str)]
    return with_unit(texts)[0] if len(texts) == len(cells) else converted(cells)


def _numbers(column: Column) -> Column:
    return converted([*column]) if column.dtype == object else column


def is_table(path: Path) -> bool:
    """Return whether most lines at the beginning of a text file are mostly numbers; notes are not."""
    with path.open("rb") as file:
        head = file.read(_SNIFFED_BYTES)
    lines = detected_text(head[: head.rfind(b"\n") + 1] or head, path)[0].splitlines()[:SNIFFED_ROWS]
    rows = [cells for line in lines if (cells := re.findall(r"[^\s;,:=()\[\]]+", line))]
    numeric = [2 * sum(is_number(cell) or is_stamp(cell) for cell in row) >= len(row) for row in rows]
    return 2 * sum(numeric) > len(numeric)


def describe(path: Path) -> SignalDescription | None:
    """Return the description in the first lines, if there is one."""
    with path.open("rb") as file:
        lines = file.read(1 << 20).decode("utf-8-sig", "ignore").split("\n")[:3]
    descriptions = (decode(line[1:].strip(), str(path)) for line in lines if line.startswith("#"))
    return next((each for each in descriptions if each), None)


def write(path: Path, signal: Signal, description: SignalDescription, *, suffix: str) -> None:
    """Write one row per sample: time (or position), then the axes; nine digits represent float32 exactly."""
    separator = "\t" if suffix == ".tsv" else ","
    rows = np.column_stack([np.arange(len(signal)) / signal.rate, signal.samples.T.astype(np.float64)])
    with path.open("w", encoding="utf-8", newline="") as file:
        file.write(f"# {description.encode()}\n")
        csv.writer(file, delimiter=separator, lineterminator="\n").writerow(heading(signal))
        np.savetxt(file, rows, fmt=["%.12g"] + ["%.9g"] * len(signal.axes), delimiter=separator)


def heading(signal: Signal) -> list[str]:
    """Return the heading of a table of ``signal``, with units."""
    first = "time [s]" if signal.domain == "time" else "position [mm]"
    return [first, *(f"{name} [{signal.unit}]" for name in signal.axes)]


def _lines(lines: Sequence[str], path: Path) -> tuple[str, list[str], list[NumberedLine]]:
    """Return the separator that a file states, its comments, and its other lines that are not empty."""
    filled = [NumberedLine(n, line) for n, line in enumerate(lines, 1) if line.strip().strip('"')]
    separator = ""
    if filled and (stated := re.fullmatch(r'"?sep=(.)"?\s*', filled[0].text)):
        separator, filled = stated[1], filled[1:]
    comments = [line.text for line in filled if line.text.startswith(COMMENTS)]
    rows = [line for line in filled if not line.text.startswith(COMMENTS) and not is_ruler(line.text)]
    if not rows:
        raise DataError(path, "no rows")
    first = rows[:SNIFFED_ROWS]
    if sum(bool(_YAML.fullmatch(line.text)) for line in first) > 0.9 * len(first):
        raise DataError(
            path,
            "lines of 'name: value' over several rows (YAML, as `ros2 topic echo` prints); save a table "
            "instead, with its option --csv",
        )
    return separator, comments, rows


def _head(rows: TextRows, comments: Sequence[str]) -> TableHead:
    """Return the head in the lines above the numbers, else in the last comment with as many cells as these."""
    head = head_of(rows.above, rows.width)
    for comment in [] if head.named else reversed(comments):
        text = comment.lstrip("#%/; ")
        if len(text) > csv.field_size_limit() or decode(text, "") is not None:
            continue
        for separator in (rows.separator, ",", " "):
            with suppress(csv.Error):
                cells = split(text, separator)
                if (
                    len(cells) in (rows.width, rows.width + 1)
                    and (candidate := head_of([cells], rows.width)).named
                ):
                    return candidate
    return head


def _side_unit(column: Column, across: str | None, along: str) -> str | None:
    """Return the unit of a column of an oscilloscope: that of the time if it goes evenly forward; none of a counter."""
    steps = np.diff(column) if column.dtype != object else np.array([0.0])
    even = len(steps) > 1 and (steps > 0).all() and float(np.ptp(steps)) <= 0.1 * float(steps.mean())
    if even and (steps == 1).all():
        return None
    return across if even else along
