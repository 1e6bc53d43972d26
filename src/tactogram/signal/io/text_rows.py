"""Rows of a text table: separator, cells, which lines are numbers; time stamps and pairs that terminals put there."""

from __future__ import annotations

import csv
import re
from collections import Counter
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from functools import partial
from pathlib import Path
from typing import NamedTuple

from tactogram.errors import DataError
from tactogram.signal.io.table_head import DECIMAL_COMMA, body_start, is_missing, is_value

MOST = 0.8
"""Share of the lines that must be alike."""
_CLEANED = 20_000
_RULER = re.compile(r"[\s|+=:-]+")
SNIFFED = 200
"""Lines that are looked at for it."""
_TIME = r"(?:\d{4}[-/.]\d\d[-/.]\d\d[T ])?\d{1,2}:\d\d:\d\d(?:[.,:]\d+)?"
_STAMPED = re.compile(
    rf"(?:\[(?:[A-Z][a-z]{{2}} [A-Z][a-z]{{2}} +\d+ )?({_TIME})(?: \d{{4}})?\]:?\s*"
    rf"|({_TIME})(?:\s*->\s*|\s*>\s*|: +))(?=[^\s,;])(.*)"
)
"""``10:23:45.123 -> 1,2`` (Arduino), ``[2026-01-02 10:23:45.123] 1,2`` (Tera Term, CoolTerm)."""
_PLAIN = re.compile(rf"({_TIME}) +(?=[^\s,;])(.*)")
_TICKED = re.compile(r"[IWED] \((\d+)\) [\w.-]+: ()(.*)")
"""``I (1234) imu: 1,2`` (ESP-IDF), in ms."""
_NUMBER = r"[-+]?(?:\d+\.?\d*|\.\d+)(?:[eE][-+]?\d+)?|nan"
_PAIR = re.compile(
    rf"\s*[,;|\t]?\s*\"?([A-Za-z_][\w .\-/]*?(?:\s*[\[(][^\])]*[\])])?)\"?\s*"
    rf"[:=]\s*\"?({_NUMBER})\"?\s*((?:[^\s,;|:=\d][^\s,;|:=]*)?)(?=[\s,;|}}]|$)",
    re.IGNORECASE,
)

_FIRST = re.compile(rf"({_NUMBER})[\s,;|\t]+(?=[A-Za-z])")
"""A time before the pairs."""
SEPARATORS = ("\t", ";", ",", "|", " ")
SNIFFED_ROWS = 200
MOST_ODD = 0.05
"""Share of lines among the numbers that may be something else, such as messages of a logger."""
_BLANK_SEPARATED = re.compile(r"[^\s\[(]+(?:\s*[\[(][^\])]*[\])])?")
"""A cell among blanks; in a heading, the unit in brackets belongs to it."""


class NumberedLine(NamedTuple):
    """A line of a file, counted from 1."""

    number: int
    text: str


def cleaned(text: str) -> str:
    """Return a text with plain characters for signs, grouped digits and exponents, as far as most lines have them."""
    text = text.replace("\r\n", "\n").replace("\r", "\n").replace("\u2212", "-")
    middle = text[len(text) // 2 :][:_CLEANED]
    if re.search("\\d[\u00a0\u2009\u202f'\u2019]\\d{3}(?!\\d)", middle):
        text = re.sub("(?<=\\d)[\u00a0\u2009\u202f'\u2019](?=\\d{3}(?!\\d))", "", text)
    if re.search(r"\d[dD][-+]\d\d", middle):  # Fortran
        text = re.sub(r"(?<=\d)[dD](?=[-+]\d\d)", "e", text)
    ended = [line.find(";") == len(line) - 1 for line in map(str.rstrip, middle.split("\n")[1:-1]) if line]
    if sum(ended) > MOST * len(ended) and "," in middle:
        text = re.sub(r";[ \t]*$", "", text, flags=re.MULTILINE)  # statements, as of WISDM
    if re.search(r"\*[0-9A-F]{2}$", middle, re.MULTILINE):  # checksums as of NMEA 0183
        text = re.sub(r"\*[0-9A-F]{2}$", "", text, flags=re.MULTILINE)
    return text


def _fits(form: re.Pattern[str], text: str) -> bool:
    return bool(form.fullmatch(text.strip()))


def prefix_apart(rows: list[NumberedLine]) -> tuple[list[NumberedLine], tuple[str, list[str]] | None]:
    """Return the lines without the time that a terminal put in front, and its heading and stamps if there are any."""
    headless = bool(rows) and bool(_PLAIN.fullmatch(rows[0].text.strip()))
    for form, heading in (
        (_STAMPED, "time"),
        (_TICKED, "time [ms]"),
        *([(_PLAIN, "time")] if headless else []),
    ):
        matches: Callable[[str], bool] = partial(_fits, form)
        if not _alike(rows, matches):
            continue
        stamps = [form.fullmatch(line.text.strip()) for line in rows]
        kept = [(line, match) for line, match in zip(rows, stamps, strict=True) if match]
        return (
            [NumberedLine(line.number, match[form.groups]) for line, match in kept],
            (heading, [match[1] or match[2] for _, match in kept]),
        )
    return rows, None


def without_brackets(rows: list[NumberedLine]) -> list[NumberedLine]:
    """Return the lines without the brackets around them, as Python prints tuples and lists."""
    bracketed = re.compile(r"\s*[(\[](.*)[)\]]\s*")
    if not _alike(rows, lambda text: bool(bracketed.fullmatch(text))):
        return rows
    matches = [bracketed.fullmatch(line.text) for line in rows]
    return [
        NumberedLine(line.number, match[1]) if match else line
        for line, match in zip(rows, matches, strict=True)
    ]


def pairs_apart(rows: list[NumberedLine]) -> tuple[list[NumberedLine], list[str]]:
    """Return lines of pairs (``x:0.1, y:0.2``) as their values between tabs, and the names with units."""
    if not _alike(rows, lambda text: bool(pairs_in(text))):
        return rows, []
    pair_lists = [pairs_in(line.text) for line in rows]
    names = Counter(tuple(name for name, _, _ in pairs) for pairs in pair_lists if pairs).most_common(1)[0][0]
    if len(set(names)) < len(names):
        return rows, []
    kept = [
        (line, pairs)
        for line, pairs in zip(rows, pair_lists, strict=True)
        if pairs and tuple(name for name, _, _ in pairs) == names
    ]
    units = [next((pairs[i][2] for _, pairs in kept if pairs[i][2]), "") for i in range(len(names))]
    # A unit at the end of the line is that of all: ``X: 0.1 Y: 0.2 Z: 9.8 m/s^2``.
    shared = units[-1] if units[-1] and not any(units[:-1]) else ""
    headings = [
        f"{name} [{unit or shared}]" if unit or shared else name
        for name, unit in zip(names, units, strict=True)
    ]
    lines = [NumberedLine(line.number, "\t".join(value for _, value, _ in pairs)) for line, pairs in kept]
    return lines, headings


def _alike(rows: Sequence[NumberedLine], test: Callable[[str], bool]) -> bool:
    """Return whether most lines in the middle of a file pass a test."""
    sample = rows[len(rows) // 2 :][:SNIFFED]
    return sum(test(line.text) for line in sample) >= MOST * len(sample) > 0


def unstamped(text: str) -> str:
    """Return a line without the time that a terminal or firmware put in front."""
    stamp = next((match for form in (_STAMPED, _TICKED) if (match := form.fullmatch(text))), None)
    return stamp[stamp.lastindex or 0] if stamp else text


def pairs_in(text: str) -> list[tuple[str, str, str]]:
    """Return name, value and unit of each pair if a line consists of them."""
    text = text.strip().strip("{}").strip()
    pairs, position = [], 0
    if first := _FIRST.match(text):
        pairs, position = [("", first[1], "")], first.end()
    while position < len(text):
        match = _PAIR.match(text, position)
        if match is None:
            return [] if text[position:].strip(" ,;|\t") else pairs
        pairs.append((match[1].strip(), match[2], match[3]))
        position = match.end()
    return pairs if len(pairs) > 1 or (pairs and pairs[0][0]) else []


def is_ruler(text: str) -> bool:
    """Return whether a line divides a table, as ``----+----``."""
    return bool(_RULER.fullmatch(text))


@dataclass
class TextRows:
    """Lines of a text table and their separator; `divide` finds the first row of numbers."""

    path: Path
    lines: list[NumberedLine]
    separator: str
    width: int = 0  # cells of a row
    start: int = 0  # of the rows among the lines
    above: list[list[str]] = field(default_factory=list)  # cells of the lines before
    notes: list[str] = field(default_factory=list)

    def cells(self, text: str) -> list[str]:
        """Return the cells of a line."""
        try:
            return split(text, self.separator)
        except csv.Error as error:
            raise DataError(self.path, f"not a table: {error}; is a quote left open?") from None

    def divide(self) -> None:
        """Find width and first row; a `DataError` if there are no rows of numbers."""
        last = self.lines[-1]
        sample = self.lines[len(self.lines) // 2 :][:SNIFFED_ROWS]
        apart = [self.cells(line.text) for line in sample]
        whole = [
            cells for line, cells in zip(sample, apart, strict=True) if line is not last or len(sample) < 3
        ]
        self.width = Counter(map(len, whole)).most_common(1)[0][0]
        first = [self.cells(line.text) for line in self.lines[: 5 * SNIFFED_ROWS]]
        ended = self.separator != " " and all(self._ends_open(line.text) for line in sample)
        if ended and self.width > 1 and not any(len(row) >= self.width and row[-1] for row in first[:2]):
            self.width -= 1
        start = body_start(first, apart, self.width)
        if start is None:
            raise DataError(self.path, "no rows of numbers below the heading")
        self.start, self.above = start, first[:start]
        if self.separator == " ":
            self.above = [self._of_fixed_width(i) for i in range(start)]

    def check_commas(self) -> None:
        """Raise a `DataError` if decimal commas between commas doubled the cells of a heading."""
        short = next((len(row) for row in self.above if 2 * len(row) == self.width), None)
        if short is not None and self.separator == ",":
            raise self._wrong_count(self.lines[self.start], short, self.width)

    def rows(self, *, ended: bool) -> list[NumberedLine]:
        """Return the lines that hold a row each; others are noted, or too many of them an error.

        ``ended`` is whether the last line has an end, without which it may be cut off.
        """
        kept: list[NumberedLine] = []
        odd: list[tuple[NumberedLine, list[str]]] = []
        remarks: list[int] = []
        repeated = 0
        lines, heads = self.lines[self.start :], {tuple(row) for row in self.above}
        plain = self.separator != " " and not any('"' in line.text for line in lines)
        for line in lines:
            count = line.text.count(self.separator) + 1 if plain else len(self.cells(line.text))
            fits = count == self.width or (count == self.width + 1 and self._ends_open(line.text))
            if fits and not line.text[0].isalpha():
                kept.append(line)
                continue
            cells = self.cells(line.text)
            if tuple(cells) in heads:
                repeated += 1
            elif fits:
                kept.append(line)
            elif (
                not any(map(is_value, cells[self.width :]))
                and all(map(is_value, cells[: self.width]))
                and count > self.width
            ):
                kept.append(NumberedLine(line.number, self.separator.join(cells[: self.width])))
                remarks.append(line.number)
            else:
                odd.append((line, cells))
        if odd and odd[-1][0] is lines[-1]:
            self.notes.append(f"last line (row {odd.pop()[0].number}) is cut off: left out")
        elif kept and kept[-1] is lines[-1] and not ended and self._is_cut(kept):
            self.notes.append(f"last line (row {kept.pop().number}) is cut off: left out")
        chatter = [each for each in odd if not any(map(is_value, each[1]))]
        wrong = [each for each in odd if each not in chatter]
        if wrong or len(chatter) > MOST_ODD * len(lines):
            line, cells = (wrong or odd)[0]
            raise self._wrong_count(line, self.width, len(cells))
        self._note("remarks behind the numbers of {} rows left out, the first is row {}", remarks)
        self._note(
            "{} lines without numbers left out, the first is row {}", [line.number for line, _ in chatter]
        )
        if repeated:
            self.notes.append(
                f"headings stand again {repeated} times among the rows: the logger was started again there"
            )
        return kept

    def _note(self, form: str, rows: Sequence[int]) -> None:
        if rows:
            self.notes.append(form.format(len(rows), rows[0]))

    def _ends_open(self, text: str) -> bool:
        return text.rstrip(" ").endswith(self.separator)

    def _of_fixed_width(self, number: int) -> list[str]:
        """Return the cells of a line above columns of fixed width, whose headings may hold single blanks."""
        text = self.lines[number].text.strip()
        cells, apart = self.above[number], re.split(r"\s{2,}|\t", text)
        return apart if len(cells) != self.width and len(apart) == self.width else cells

    def _is_cut(self, rows: Sequence[NumberedLine]) -> bool:
        """Return whether the last number is missing, or has fewer decimals than all those above it have."""
        *before, last = (self.cells(line.text)[-1].partition(".")[2] for line in rows[-20:])
        alike = len(before) > 9 and len({len(decimals) for decimals in before}) == 1
        return not self.cells(rows[-1].text)[-1] or (alike and len(last) < len(before[0]))

    def _wrong_count(self, line: NumberedLine, expected: int, got: int) -> DataError:
        comma = self.separator == "," and got == 2 * expected
        hint = "; write decimal points, not commas" if comma else ""
        return DataError(f"{self.path}: row {line.number}", f"expected {expected} columns, got {got}{hint}")


def split(row: str, separator: str) -> list[str]:
    """Return the cells of a row; a `csv.Error` if a quote is left open."""
    if separator == " ":
        return _BLANK_SEPARATED.findall(row)
    if '"' in row:
        return [cell.strip() for cell in next(csv.reader([row], delimiter=separator, skipinitialspace=True))]
    return [cell.strip() for cell in row.split(separator)]


def separator_of(rows: Sequence[str]) -> str:
    """Return the separator that gives most rows the same number of cells, and these values; errors as `split`."""

    def fit(separator: str) -> tuple[float, int]:
        cells = [split(row.strip(" ") if separator == "\t" else row.strip(), separator) for row in rows]
        counts = Counter(map(len, cells))
        count, alike = max(counts.items(), key=lambda each: (each[1], each[0]))
        filled = [cell for row in cells for cell in row if not is_missing(cell)]
        values = sum(map(is_value, filled)) / max(len(filled), 1)
        return round(alike / len(cells) * (0.2 + values) * (1.0 if count > 1 else 0.7), 2), -SEPARATORS.index(
            separator
        )

    best = max(SEPARATORS, key=fit)
    if best == "," and all(DECIMAL_COMMA.fullmatch(row.strip()) for row in rows):
        parts = [row.strip().partition(",") for row in rows]
        if any(whole == "-0" or (len(part) > 1 and part[0] == "0") for whole, _, part in parts):
            return " "  # one column of numbers with decimal commas
    return best
