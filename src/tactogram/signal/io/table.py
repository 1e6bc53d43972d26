"""Text tables: foreign ones as they are, own ones exact to the last bit."""

from __future__ import annotations

import csv
import io
import re
from collections import Counter
from collections.abc import Sequence
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from tactogram.errors import DataError
from tactogram.signal.io.description import SignalDescription, decode
from tactogram.signal.io.raw_table import Column, RawTable
from tactogram.signal.io.stamps import is_stamp
from tactogram.signal.io.table_head import (
    DECIMAL_COMMA,
    MISSING,
    NUMBER_WITH_UNIT,
    TableHead,
    body_start,
    head_of,
    increment_in,
    is_missing,
    is_number,
    is_value,
    rate_in,
    units_in,
)
from tactogram.signal.io.table_lines import NumberedLine, cleaned, is_ruler, pairs_apart, prefix_apart, without_brackets
from tactogram.signal.signal import Signal
from tactogram.text_files import detected_text

COMMENTS = ("#", "%", "//", ";")
SEPARATORS = ("\t", ";", ",", "|", " ")
SNIFFED_ROWS = 200
SIDE_ROWS = 40
"""Rows of numbers beside which settings are looked for."""
MOST_MISSING = 0.8
"""Share of cells without a number above which a column without a heading is none."""
MOST_ODD = 0.05
"""Share of lines among the numbers that may be something else, such as messages of a logger."""
_SNIFFED_BYTES = 8192
_BLANK_SEPARATED = re.compile(r"[^\s\[(]+(?:\s*[\[(][^\])]*[\])])?")
"""A cell among blanks; in a heading, the unit in brackets belongs to it."""
_YAML = re.compile(r"\s*(?:[\w/]+:(?:\s+\S+)?|---|- \S+)\s*")
_CALENDAR = re.compile(r"((?:19|20)\d\d)(0[1-9]|1[0-2])([0-2]\d|3[01])([01]\d|2[0-3])([0-5]\d)([0-5]\d)(\d{3}|)")
_GROUPED = re.compile(r"[-+]?[1-9]\d{0,2},\d{3}")
"""A number with a comma that may be one of thousands."""
_THOUSANDS = re.compile(r"[-+]?\d{1,3}(?:,\d{3})+\.\d+")


def table(path: Path, raw: bytes) -> RawTable:
    """Return the columns of a text table with one row per sample.

    Lines of a logger above the heading and comments are no rows; a line below the headings may hold units. Separators
    are tabs, semicolons, commas, bars or blanks, whichever fits; decimals have points, or commas where these do not
    separate. Lines may be pairs (``x:0.1 y:0.2``), in brackets, or begin with the time of a terminal
    (``10:23:45.123 -> 1,2``). A last line that was cut off is left out and noted. A `DataError` names the line.
    """
    if not raw:
        raise DataError(f"{path}: empty file")
    notes = []
    if raw.endswith(b"\0") and raw.count(0) < len(raw) // 4:
        raw = raw.rstrip(b"\0")
        notes.append("zero bytes at the end left out")
    text, encoding = detected_text(raw, path)
    notes += [] if encoding.startswith("utf") else [f"text read as {encoding}, not UTF-8"]
    lines = cleaned(text).split("\n")
    filled = [NumberedLine(n, line) for n, line in enumerate(lines, 1) if line and not line.isspace()]
    separator = None
    if filled and (stated := re.fullmatch(r'"?sep=(.)"?\s*', filled[0].text)):
        separator, filled = stated[1], filled[1:]
    comments = [line.text for line in filled if line.text.startswith(COMMENTS)]
    rows = [line for line in filled if not line.text.startswith(COMMENTS) and not is_ruler(line.text)]
    if not rows:
        raise DataError(f"{path}: no rows")
    if sum(bool(_YAML.fullmatch(line.text)) for line in rows[:SNIFFED_ROWS]) > 0.9 * len(rows[:SNIFFED_ROWS]):
        raise DataError(
            f"{path}: lines of 'name: value' over several rows (YAML, as `ros2 topic echo` prints): save a table instead, "
            "with its option --csv"
        )
    description = next((found for line in comments[:3] if (found := decode(line[1:].strip(), str(path)))), None)
    rows, stamps = prefix_apart(rows)
    rows = without_brackets(rows)
    rows, names = pairs_apart(rows)
    sample = rows[len(rows) // 2 :][:SNIFFED_ROWS]
    separator = separator or ("\t" if names else _separator([line.text for line in sample]))
    counts = Counter(len(_cells(line.text, separator, path)) for line in sample if line is not rows[-1] or len(sample) < 3)
    width = counts.most_common(1)[0][0]
    first = [_cells(line.text, separator, path) for line in rows[: 5 * SNIFFED_ROWS]]
    ended_alike = separator != " " and all(line.text.rstrip(" ").endswith(separator) for line in sample)
    if ended_alike and width > 1 and not any(len(cells) >= width and cells[-1] for cells in first[:2]):
        width -= 1
    start = body_start(first, [_cells(line.text, separator, path) for line in sample], width)
    if start is None:
        raise DataError(f"{path}: {_no_numbers(first, width)}")
    above = [_spaced(line.text, cells, width) if separator == " " else cells for line, cells in zip(rows[:start], first, strict=False)]
    head = _head(above, comments, width, separator, path)
    if not head.named and separator == "," and (short := next((r for r in first[:start] if 2 * len(r) == width), None)):
        raise DataError(
            f"{path}: row {rows[start].number}: expected {len(short)} columns, got {width}; write decimal points, not commas"
        )
    if names:
        head = TableHead(tuple(names), (), named=True)
    body = _body(rows[start:], width, separator, path, notes, first[:start], ended=lines[-1].strip() == "")
    columns, spelled = _columns(body, width, separator, path)
    facts = [*comments, *(line.text for line in rows[: start + SIDE_ROWS])]
    units = tuple(a or b for a, b in zip(head.units or (None,) * width, spelled, strict=True))
    kept = [i for i in range(width) if (head.headings[i] and head.named) or not _is_empty(columns[i])]
    rate = increment_in(first[:start]) or rate_in(facts)
    numbers = [line.number for line in body]
    if not head.named and (fact := _start_and_rate(columns)):
        rate, columns, numbers = fact, [column[2:] for column in columns], numbers[2:]
        notes.append("the first two rows are the start and the rate, as Empatica's E4 writes them")
    headings, columns = [head.headings[i] for i in kept], [columns[i] for i in kept]
    units = tuple(units[i] for i in kept)
    across, along = units_in(facts)
    if along is not None and not any(units) and not any(re.search(r"[\[(]", text) for text in headings):
        units = tuple(_side_unit(column, across, along) for column in columns)
    if stamps is not None:
        places = {line.number: stamp for line, stamp in zip(rows, stamps[1], strict=True)}
        headings, units = [stamps[0], *headings], (None, *units)
        columns = [_converted([places[n] for n in numbers]), *columns]
    return RawTable(
        path,
        tuple(headings),
        tuple(columns),
        units=units if any(units) else (),
        named=head.named,
        rows=numbers,
        rate=rate if description is None else description.rate,
        rate_name="the lines above",
        description=description,
        notes=tuple(notes),
    )


def table_of_cells(path: Path, cells: Sequence[Sequence[object]], *, name: str = "") -> RawTable:
    """Return the columns of a worksheet, given the cells of all its rows; ``name`` is the sheet's."""
    rows = [(n, [*row]) for n, row in enumerate(cells, 1) if any(cell not in (None, "") for cell in row)]
    if not rows:
        raise DataError(f"{path}: no rows{f' in sheet {name!r}' if name else ''}")
    ends = [max(i for i, cell in enumerate(row, 1) if cell not in (None, "")) for _, row in rows]
    middle = ends[len(ends) // 2 :][:SNIFFED_ROWS]
    width = Counter(middle).most_common(1)[0][0]
    width = max(width, Counter(ends[:5]).most_common(1)[0][0])
    first = [row[:width] for _, row in rows[: 5 * SNIFFED_ROWS]]
    start = body_start(first, [row[:width] for _, row in rows[len(rows) // 2 :][:SNIFFED_ROWS]], width)
    if start is None:
        raise DataError(f"{path}: {_no_numbers([[str(c or '') for c in row] for row in first], width)}")
    head = head_of([row[:end] for row, end in zip(first[:start], ends, strict=False)], width)
    body = [(n, row[:width] + [None] * (width - len(row))) for n, row in rows[start:]]
    columns = [_converted([row[i] for _, row in body]) for i in range(width)]
    kept = [i for i in range(width) if (head.headings[i] and head.named) or not _is_empty(columns[i])]
    above = [" ".join(str(cell) for cell in row if cell is not None) for _, row in rows[:start]]
    return RawTable(
        path,
        tuple(head.headings[i] for i in kept),
        tuple(columns[i] for i in kept),
        units=tuple(head.units[i] for i in kept) if head.units else (),
        named=head.named,
        rows=[n for n, _ in body],
        rate=increment_in(first[:start]) or rate_in(above),
        rate_name="the lines above",
    )


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
    found = (decode(line[1:].strip(), str(path)) for line in lines if line.startswith("#"))
    return next((each for each in found if each), None)


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


def _separator(rows: Sequence[str]) -> str:
    """Return the separator that gives most lines the same number of cells, and these values."""

    def fit(separator: str) -> tuple[float, int]:
        cells = [_split(row.strip() if separator != "\t" else row.strip(" "), separator) for row in rows]
        counts = Counter(map(len, cells))
        count, alike = max(counts.items(), key=lambda each: (each[1], each[0]))
        filled = [cell for row in cells for cell in row if not is_missing(cell)]
        values = sum(is_value(cell) for cell in filled)
        quality = alike / len(cells) * (0.2 + values / max(len(filled), 1)) * (1.0 if count > 1 else 0.7)
        return round(quality, 2), -SEPARATORS.index(separator)

    return max(SEPARATORS, key=fit)


def _split(row: str, separator: str) -> list[str]:
    if separator == " ":
        return _BLANK_SEPARATED.findall(row)
    if '"' in row:
        return [cell.strip() for cell in next(csv.reader([row], delimiter=separator, skipinitialspace=True))]
    return [cell.strip() for cell in row.split(separator)]


def _spaced(text: str, cells: list[str], width: int) -> list[str]:
    """Return the cells of a line above columns of fixed width, whose headings may hold single blanks."""
    apart = re.split(r"\s{2,}|\t", text.strip())
    return apart if len(cells) != width and len(apart) == width else cells


def _side_unit(column: Column, across: str | None, along: str) -> str | None:
    """Return the unit of a column of an oscilloscope: that of the time if it goes evenly forward."""
    steps = np.diff(column) if column.dtype != object else np.array([0.0])
    even = len(steps) > 1 and (steps > 0).all() and float(np.ptp(steps)) <= 0.1 * float(steps.mean())  # noqa: PLR2004
    if even and (steps == 1).all():
        return None  # a counter
    return across if even else along


def _cells(row: str, separator: str, path: Path) -> list[str]:
    try:
        return _split(row, separator)
    except csv.Error as error:
        raise DataError(f"{path}: not a table: {error}; is a quote left open?") from None


def _head(
    above: Sequence[Sequence[str]], comments: Sequence[str], width: int, separator: str, path: Path
) -> TableHead:
    """Return the head in the lines above the numbers, else in the last comment with as many cells as these."""
    head = head_of(above, width)
    if head.named:
        return head
    for comment in reversed(comments):
        text = comment.lstrip("#%/; ")
        if len(text) > csv.field_size_limit() or decode(text, "") is not None:
            continue
        for cells in (_cells(text, separator, path), _split(text, ","), _split(text, " ")):
            if len(cells) in (width, width + 1) and (found := head_of([cells], width)).named:
                return found
    return head


def _body(
    rows: list[NumberedLine], width: int, separator: str, path: Path, notes: list[str], above: Sequence[Sequence[str]],
    *, ended: bool,
) -> list[NumberedLine]:
    """Return the lines that hold a row each; others are left out with a note, or too many of them an error."""
    kept: list[NumberedLine] = []
    odd: list[tuple[NumberedLine, int]] = []
    repeated, remarks = 0, []
    heads = {tuple(row) for row in above}
    plain = separator != " " and not any('"' in line.text for line in rows)
    for line in rows:
        count = line.text.count(separator) + 1 if plain else len(_cells(line.text, separator, path))
        if count == width or (count == width + 1 and line.text.rstrip(" ").endswith(separator)):
            kept.append(line)
        elif tuple(cells := _cells(line.text, separator, path)) in heads:
            repeated += 1
        elif len(cells) > width and not any(is_value(cell) for cell in cells[width:]) and all(map(is_value, cells[:width])):
            kept.append(NumberedLine(line.number, separator.join(cells[:width])))
            remarks.append(line.number)
        else:
            odd.append((line, count))
    for line in [line for line in kept if line.text[:1].isalpha() and tuple(_cells(line.text, separator, path)) in heads]:
        kept.remove(line)
        repeated += 1
    if remarks:
        notes.append(f"remarks behind the numbers of {len(remarks)} rows left out, the first is row {remarks[0]}")
    if repeated:
        notes.append(f"headings stand again {repeated} times among the rows: the logger was started again there")
    if odd and odd[-1][0] is rows[-1]:
        notes.append(f"last line (row {odd.pop()[0].number}) is cut off: left out")
    elif kept and kept[-1] is rows[-1] and not ended and _cut(kept, separator, path):
        notes.append(f"last line (row {kept.pop().number}) is cut off: left out")
    chatter = [line for line, count in odd if not any(map(is_value, _cells(line.text, separator, path)))]
    if (wrong := next((each for each in odd if each[0] not in chatter), None)) or len(chatter) > MOST_ODD * len(rows):
        line, count = wrong or odd[0]
        comma = separator == "," and count == 2 * width
        hint = "; write decimal points, not commas" if comma else ""
        raise DataError(f"{path}: row {line.number}: expected {width} columns, got {count}{hint}")
    if chatter:
        notes.append(f"{len(chatter)} lines without numbers among the rows left out, the first is row {chatter[0].number}")
    return kept


def _cut(rows: Sequence[NumberedLine], separator: str, path: Path) -> bool:
    """Return whether the last row lacks the end of its last number: an empty one, or fewer decimals than all others."""
    last = [_cells(line.text, separator, path)[-1] for line in rows[-20:]]
    decimals = {len(cell.partition(".")[2]) for cell in last[:-1]}
    return not last[-1] or (len(decimals) == 1 and len(last) > 10 and len(last[-1].partition(".")[2]) < min(decimals))


def _columns(
    body: Sequence[NumberedLine], width: int, separator: str, path: Path
) -> tuple[list[Column], list[str | None]]:
    """Return the columns of the rows, and the unit behind the numbers of each, if they have one."""
    import pandas as pd

    sample = [cell for line in body[:SNIFFED_ROWS] for cell in _cells(line.text, separator, path)]
    decimal = "."
    if any(DECIMAL_COMMA.fullmatch(cell) for cell in sample):
        decimal = "." if any("." in cell and is_number(cell) for cell in sample) else ","
    grouped = any(_THOUSANDS.fullmatch(cell) for cell in sample)
    text = "\n".join(line.text.rstrip(" " if separator == "\t" else None) for line in body)
    try:
        frame = pd.read_csv(
            io.StringIO(text),
            sep=r"\s+" if separator == " " else separator,
            header=None,
            names=[*range(width + 1)],
            index_col=False,
            decimal=decimal,
            thousands="," if grouped else None,
            skipinitialspace=True,
            keep_default_na=False,
            na_values=sorted({form for cell in MISSING for form in (cell, cell.upper(), cell.title(), "NaN")}),
            skip_blank_lines=False,
            low_memory=False,
        )
    except (ValueError, pd.errors.ParserError) as error:
        raise DataError(f"{path}: not a table: {' '.join(str(error).split())}") from None
    columns: list[Column] = []
    units: list[str | None] = []
    for i in range(width):
        values = frame[i]
        if values.dtype.kind == "i" and (dated := _calendar_digits(values.to_numpy())) is not None:
            columns.append(dated)
            units.append(None)
        elif values.dtype.kind in "fiub":
            columns.append(values.to_numpy(dtype=np.float64))
            units.append(None)
        else:
            column, unit = _with_unit([None if value != value else str(value).strip() for value in values])
            columns.append(column)
            units.append(unit)
    return columns, units


def _calendar_digits(values: NDArray[np.int64]) -> Column | None:
    """Return whole numbers that spell date and time (``20260102102345000``) as stamps."""
    digits = {14: 0, 17: 3}.get(len(str(int(values[0]))) if len(values) else 0)
    if digits is None or not all(_CALENDAR.fullmatch(str(value)) for value in values[:20]):
        return None
    column = np.empty(len(values), dtype=object)
    column[:] = [_CALENDAR.sub(r"\1-\2-\3 \4:\5:\6.\g<7>0", str(value)) for value in values]
    return column


def _with_unit(cells: Sequence[str | None]) -> tuple[Column, str | None]:
    """Return cells as numbers if each has the same unit behind it, or a decimal comma where others have points."""
    filled = [cell for cell in cells if cell]
    if filled and all(is_number(cell) or DECIMAL_COMMA.fullmatch(cell) for cell in filled):
        if not all(_GROUPED.fullmatch(cell) for cell in filled if "," in cell):
            return _converted([cell and cell.replace(",", ".") for cell in cells]), None
    found = [cell and NUMBER_WITH_UNIT.fullmatch(cell) for cell in cells[:SNIFFED_ROWS] if cell]
    units = {match[2] if match else None for match in found}
    if len(units) == 1 and None not in units and not any(is_stamp(cell) for cell in cells[:3]):
        [unit] = units
        matches = [NUMBER_WITH_UNIT.fullmatch(cell or "") for cell in cells]
        if all(match is not None or not cell for match, cell in zip(matches, cells, strict=True)):
            return np.array([float(m[1].replace(",", ".")) if m else np.nan for m in matches]), unit
    return _converted(cells), None


def _converted(cells: Sequence[object]) -> Column:
    """Return cells as float64 if all that are not missing are numbers, else as objects."""
    if all(is_missing(cell) or is_number(cell) for cell in cells):
        return np.array([np.nan if is_missing(cell) else float(cell) for cell in cells])  # type: ignore[arg-type]
    column = np.empty(len(cells), dtype=object)
    column[:] = [None if is_missing(cell) else cell for cell in cells]
    return column


def _is_empty(column: Column) -> bool:
    """Return whether most cells are missing, as where an oscilloscope writes its settings beside the first rows."""
    missing = [cell is None for cell in column] if column.dtype == object else np.isnan(column)
    return float(np.mean(missing)) > MOST_MISSING


def _start_and_rate(columns: Sequence[Column]) -> float | None:
    """Return the rate if all columns begin with the same seconds since 1970, and the same rate below."""
    heads = {(float(column[0]), float(column[1])) for column in columns if column.dtype != object and len(column) > 2}
    if len(heads) == 1 and len(columns) > 0:
        [(start, rate)] = heads
        if start > 1e9 and 1 <= rate <= 1e5:
            return rate
    return None


def _no_numbers(rows: Sequence[Sequence[str]], width: int) -> str:
    if any(len(row) == 2 * width and width == 1 for row in rows):
        return "no rows of numbers; are decimal commas separators, too?"
    return "no rows of numbers below the heading" if rows else "no rows"
