"""Rows of a text table: its separator, the cells of its lines, and which of the lines are rows."""

from __future__ import annotations

import csv
import re
from collections import Counter
from collections.abc import Sequence
from dataclasses import dataclass, field
from pathlib import Path

from tactogram.errors import DataError
from tactogram.signal.io.table_head import DECIMAL_COMMA, body_start, is_missing, is_value
from tactogram.signal.io.table_lines import NumberedLine

SEPARATORS = ("\t", ";", ",", "|", " ")
SNIFFED_ROWS = 200
MOST_ODD = 0.05
"""Share of lines among the numbers that may be something else, such as messages of a logger."""
_BLANK_SEPARATED = re.compile(r"[^\s\[(]+(?:\s*[\[(][^\])]*[\])])?")
"""A cell among blanks; in a heading, the unit in brackets belongs to it."""


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
            raise DataError(f"{self.path}: not a table: {error}; is a quote left open?") from None

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
            raise DataError(f"{self.path}: no rows of numbers below the heading")
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
        return DataError(f"{self.path}: row {line.number}: expected {expected} columns, got {got}{hint}")


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
