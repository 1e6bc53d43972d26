"""Head of a table: where its rows of numbers begin, and what the lines above say: headings, units, rate."""

from __future__ import annotations

import itertools
import re
from collections.abc import Sequence
from dataclasses import dataclass

from tactogram.errors import UnitError
from tactogram.signal.io.stamps import is_stamp
from tactogram.signal.units import parse_seconds, parse_unit

_NO_NUMBERS = """nan na n/a #n/a #na null none - -- --- . ovf ol over overload overflow overrange #value! #num! #div/0!
-nan nan(ind) -1.#ind 1.#qnan inf -inf +inf ∞ -∞ +∞ infinity -infinity"""
MISSING = frozenset(["", *_NO_NUMBERS.split()])
"""Cells that hold no number, in lower case."""
DECIMAL_COMMA = re.compile(r"[-+]?\d*,\d+(?:[eE][-+]?\d+)?")
NUMBER_WITH_UNIT = re.compile(r"\s*([-+]?\d+(?:[.,]\d+)?(?:[eE][-+]?\d+)?)\s*((?:[^\W\d_]|[°%]).*?)\s*")
HEAD_ROWS = 4
"""Most rows of headings: of groups, names, kinds and units."""
_KINDS = frozenset(["cal", "raw", "uncal", "real", "float", "double", "int", "analog", "none", "value"])
_RATE = re.compile(
    r"""\b(?P<what>(?:sampl(?:e|ing|es)|data|acquisition|logging|output)?[ _-]*
        (?:rate|freq(?:uency)?|interval|period|increment)
    |messrate|abtastrate|time[ ]interval|tinc|x-axis[ ]delta|fs|dt|delta_?x|at
    |samples?[ _/]+(?:per|/)[ _]*s(?:ec(?:ond)?)?)\b
    [^\d\n]{0,24}?(?P<number>\d+(?:[.,]\d+)?(?:[eE][-+]?\d+)?)\s*(?P<unit>[a-zµμ]*)""",
    re.IGNORECASE | re.VERBOSE,
)
_OTHER_UNITS = ("°c", "degc", "hz", "db", "bpm", "lux", "no units", "nm", "n·m")
_HERTZ = {"hz": 1.0, "khz": 1e3, "mhz": 1e6, "sps": 1.0, "": 1.0}


@dataclass(frozen=True)
class TableHead:
    """Headings of the columns of a table, their units where a row of their own has them."""

    headings: tuple[str, ...]
    units: tuple[str | None, ...]  # empty if no row has them
    named: bool  # whether the headings are the file's


def is_number(cell: object) -> bool:
    """Return whether a cell holds a number, as text or as a value of a worksheet."""
    if not isinstance(cell, str):
        return isinstance(cell, int | float) and not isinstance(cell, bool)
    try:
        float(cell)
    except ValueError:
        return False
    return "_" not in cell


def is_missing(cell: object) -> bool:
    """Return whether a cell says that there is no number."""
    return cell is None or (isinstance(cell, str) and cell.strip().lower() in MISSING)


def is_value(cell: object) -> bool:
    """Return whether a cell holds a number, perhaps with a decimal comma or a unit, or a time stamp."""
    if is_number(cell) or is_stamp(cell):
        return True
    if not isinstance(cell, str):
        return False
    match = NUMBER_WITH_UNIT.fullmatch(cell)
    return bool(DECIMAL_COMMA.fullmatch(cell.strip())) or bool(match and _is_unit(match[2]))


def body_start(
    rows: Sequence[Sequence[object]], sample: Sequence[Sequence[object]], width: int
) -> int | None:
    """Return the first of the rows of numbers: ``width`` cells, and numbers where most rows of a sample have them."""
    filled = [
        [row[i] for row in sample if len(row) >= width and not is_missing(row[i])] for i in range(width)
    ]
    numeric = [i for i, cells in enumerate(filled) if cells and 2 * sum(map(is_value, cells)) > len(cells)]

    def is_data(row: Sequence[object]) -> bool:
        cells = [row[i] for i in numeric if i < len(row)]
        return (
            abs(len(row) - width) <= 1
            and any(map(is_value, cells))
            and all(is_value(c) or is_missing(c) for c in cells)
        )

    data = [bool(numeric) and is_data(row) for row in rows]
    for i, holds_data in enumerate(data):
        following = data[i : i + 4]
        section = i + 1 < len(rows) and len(rows[i + 1]) == 1 < width and str(rows[i + 1][0]).endswith(":")
        if holds_data and not section and sum(following) >= min(len(following), 3):
            return i
    return None


def head_of(above: Sequence[Sequence[object]], width: int) -> TableHead:
    """Return headings and units from the rows above the numbers, the last of which are nearest to them."""
    texts = [[str("" if cell is None else cell).strip() for cell in row] for row in above]
    labelled = {
        row[0].lower().strip(" =:"): tuple(row[1 : width + 1])
        for row in texts
        if len(row) >= width and row[0].endswith(("=", ":"))
    }
    if (titles := labelled.get("channeltitle")) is not None:  # LabChart
        below = labelled.get("unitname", ("",) * width)[: width - 1]
        return TableHead(
            ("time", *titles[: width - 1]), (None, *(unit or None for unit in below)), named=True
        )
    if (titles := labelled.get("kanalname")) is not None and len(titles) >= width:  # catman
        return TableHead(
            titles[:width], tuple(unit or None for unit in labelled.get("einheit", ())[:width]), named=True
        )
    rows: list[list[str]] = []
    lengths: set[int] = set()
    for row in reversed(texts[-2 * HEAD_ROWS :]):
        while len(row) > width and not row[-1]:
            row.pop()
        filled = [text for text in row if text]
        if width > 1 and len(filled) == 1 and not filled[0][0].isalnum():
            continue  # the name of a section, such as *DATA
        fitted = _fitted(row, width, over=bool(rows) and len(row) not in lengths)
        if fitted is None or not _heads(fitted) or len(rows) == HEAD_ROWS:
            break
        rows.insert(0, fitted)
        lengths.add(len(row))
    units: tuple[str | None, ...] = ()
    if len(rows) > 1 and _are_units(rows[-1]):
        units = tuple(_bare(text) or None for text in rows.pop())
    rows = [row for row in rows if not all(text.lower() in _KINDS for text in row if text)] or rows[-1:]
    while len(rows) > 1 and sum(map(bool, rows[0])) * 2 < width and not _spreads(rows[0], rows[1]):
        rows.pop(0)
    if not rows:
        return TableHead(tuple(str(i + 1) for i in range(width)), (), named=False)
    names = rows[-1]
    for group in reversed(rows[:-1]):
        names = [
            f"{over} {name}".strip() if over != name else name
            for over, name in zip(_spread(group), names, strict=True)
        ]
    return TableHead(tuple(names), units, named=True)


def rate_in(lines: Sequence[str]) -> float | None:
    """Return the rate in Hz that lines above a table state, by a rate or an interval; None if there is none, or two."""
    rates = set()
    joined = [
        f"{line} {following}" if line.strip().endswith(":") else line
        for line, following in zip(lines, [*lines[1:], ""], strict=False)
    ]
    for line in joined:
        for match in _RATE.finditer(line):
            number, unit = float(match["number"].replace(",", ".")), match["unit"].lower()
            slow = re.search(r"interval|period|inc|dt|delta", match["what"], re.IGNORECASE)
            seconds = parse_seconds(unit) if unit else 1.0
            if slow and seconds and number > 0:
                rates.add(round(1 / (number * seconds), 9))
            elif not slow and unit in _HERTZ and number > 0 and (unit or match["what"].lower() != "at"):
                rates.add(number * _HERTZ[unit])
    return rates.pop() if len(rates) == 1 else None


def units_in(lines: Sequence[str]) -> tuple[str | None, str | None]:
    """Return the units of time stamps and samples in lines such as ``Horizontal Units,s`` and ``Vertical Units,V``."""
    axis_units: list[str | None] = []
    for axis in (r"horizontal|x-axis|h", r"vertical|y-axis|v|measure"):
        form = re.compile(
            rf"[\"'#\s]*(?:{axis})[ _-]*units?\b[\"':=\s]*[,;:\t=]?[\"'\s]*([^\",;\t\s]+)", re.IGNORECASE
        )
        units = [match[1] for line in lines if (match := form.match(line)) and _is_unit(match[1])]
        axis_units.append(units[0] if units else None)
    return axis_units[0], axis_units[1]


def increment_in(above: Sequence[Sequence[object]]) -> float | None:
    """Return the rate that a number below the heading ``Increment`` states, as Rigol's oscilloscopes write it."""
    for names, values in itertools.pairwise(above):
        for name, value in zip(names, values, strict=False):
            if str(name).strip().lower() == "increment" and is_number(value) and float(str(value)) > 0:
                return 1 / float(str(value))
    return None


def _fitted(row: list[str], width: int, *, over: bool) -> list[str] | None:
    """Return a row of headings with as many cells as the numbers.

    It may have one less if rows are named, more or, ``over`` others, fewer if these are empty.
    """
    if len(row) == width + 1 and row[0].lower().rstrip(":") in ("header", "headers", "columns", "fields"):
        row = row[1:]
    if len(row) == width - 1 and width > 1:
        return ["", *row] if all(row) else [*row, ""]
    if over and (row[:1] == [] or any(text.endswith(":") for text in row)):
        return None
    if over and 1 < len(row) < width and "" in row[:-1]:
        row = row + [""] * (width - len(row))
    return row[:width] if len(row) == width or (len(row) > width and not over) else None


def _heads(row: list[str]) -> bool:
    """Return whether a row may be one of headings: words, and hardly any numbers."""
    filled = [text for text in row if text]
    numbers = sum(is_value(text) for text in filled)
    counted = [str(i) for i in range(len(filled) - 1)], [str(i + 1) for i in range(len(filled) - 1)]
    return bool(filled) and (2 * numbers < len(filled) or (len(filled) > 1 and filled[1:] in counted))


def _are_units(row: list[str]) -> bool:
    filled = [text for text in row if text]
    known = sum(_is_unit(text) for text in filled)
    return known > 0 and 2 * known >= len([text for text in filled if not is_number(text)])


def _bare(text: str) -> str:
    """Return a unit without the brackets around it."""
    match = re.fullmatch(r"[\[(](.*)[\])]", text.strip())
    return match[1] if match else text.strip()


def _is_unit(text: str) -> bool:
    text = _bare(text)
    if parse_seconds(text) is not None or text.lower() in _OTHER_UNITS:
        return True
    try:
        parse_unit(text)
    except UnitError:
        return False
    return True


def _spreads(group: list[str], names: list[str]) -> bool:
    """Return whether groups stand over names: none over an empty one, each over the first of its names."""
    return (
        any(group)
        and all(name or not over for over, name in zip(group, names, strict=True))
        and len(set(names)) < len(names)
    )


def _spread(group: list[str]) -> list[str]:
    """Return each group also over the names that follow."""
    names, last = [], ""
    for text in group:
        last = text or last
        names.append(last)
    return names
