"""Parser of lines of numbers, as boards print them, from bytes that may be cut or damaged anywhere."""

from __future__ import annotations

import math
import re
from collections import Counter

LONGEST_LINE = 4096
COMMENTS = ("#", "%", "//")

_NUMBER = re.compile(r"[+-]?(?:\d+\.?\d*|\.\d+)(?:[eE][+-]?\d+)?")
_NOT_FINITE = re.compile(r"[+-]?(?:nan|inf|infinity|ovf)", re.IGNORECASE)
_LABEL = re.compile(r"^\s*([A-Za-z_][\w ]*)\s*[:=]\s*(.*)$")


class CsvParser:
    """Parser of bytes in arbitrary pieces into rows of numbers."""

    def __init__(self) -> None:
        self.rejected: Counter[str] = Counter()
        """Lines after the first row that are not rows, by reason."""
        self.before = self.comments = 0
        """Lines before the first row: start-up messages, and the partial line at which reading begins."""
        self.headings: list[str] = []
        """Names of the columns; empty without a heading."""
        self.columns = 0
        self._buffer = bytearray()
        self._too_long = False
        self._heading_separator: str | None = None
        self._separator: str | None = None
        self._candidate: tuple[list[float], int] | None = None

    def feed(self, data: bytes) -> list[list[float] | None]:
        """Return the rows that ``data`` completes; None for a line that is not a row."""
        self._buffer += data
        rows: list[list[float] | None] = []
        while True:
            end = self._buffer.find(b"\n", 0, LONGEST_LINE)
            if end >= 0:
                line = bytes(self._buffer[:end])
                del self._buffer[: end + 1]
                if self._too_long:
                    self._too_long = False
                else:
                    self._line(line, rows)
            elif len(self._buffer) > LONGEST_LINE:
                if not self._too_long:
                    self._no_row("line without an end", rows)
                self._too_long = True
                del self._buffer[:LONGEST_LINE]
            else:
                return rows

    def finish(self) -> None:
        """Reject an unfinished last line, which may lack digits."""
        if self._buffer.strip():
            self.rejected["unfinished"] += 1
        self._buffer.clear()

    def rejected_text(self) -> str:
        """Return the count of unreadable lines, for an error."""
        return f"{self.before + sum(self.rejected.values())} unreadable lines, {self.comments} comments"

    def _line(self, line: bytes, rows: list[list[float] | None]) -> None:
        text = line.strip(b"\r \t\0").decode("latin-1")
        if not text:
            return
        if text.startswith(COMMENTS):
            self.comments += 1
            return
        labels, cells, separator = _cells(text)
        values = [_value(cell) for cell in cells]
        if any(value is None for value in values):
            if not self.columns and all(re.match(r"[A-Za-zµ]", cell) for cell in cells):
                self.headings, self._heading_separator = cells, separator
                self._candidate = None
                self.before += 1
            else:
                self._no_row("not numbers", rows)
            return
        row = [value for value in values if value is not None]
        if not self.columns:
            if self.headings and len(row) > 1 and separator != self._heading_separator:
                # A start-up message with as many words.
                self.headings = []
            if self._first(row, labels, rows):
                self._separator = separator
        elif len(row) != self.columns or (len(row) > 1 and separator != self._separator):
            self._no_row("number of columns", rows)
        else:
            rows.append(row)

    def _first(self, row: list[float], labels: list[str], rows: list[list[float] | None]) -> bool:
        """Return whether a row is the first complete one: as wide as the heading or the preceding row."""
        if self.headings and len(row) == len(self.headings):
            self.columns = len(row)
            rows.append(row)
            return True
        if self._candidate is not None and self._candidate[1] == len(row):
            # The preceding row has as many cells but may lack its first digits.
            self.before += 1
            self.columns = len(row)
            self.headings = self.headings if len(self.headings) == len(row) else labels
            rows.append(row)
            return True
        if self._candidate is not None:
            self.before += 1
        self._candidate = (row, len(row))
        return False

    def _no_row(self, why: str, rows: list[list[float] | None]) -> None:
        if self.columns:
            self.rejected[why] += 1
            rows.append(None)
        else:
            self.before += 1


def _cells(text: str) -> tuple[list[str], list[str], str | None]:
    """Return the labels (of ``name:value`` pairs, a format of serial plotters), cells and separator of a line."""
    separator = next((s for s in ("\t", ";", ",") if s in text), None)
    pieces = [piece.strip() for piece in (text.split(separator) if separator else text.split())]
    if separator and pieces and not pieces[-1]:
        pieces.pop()
    labelled = [_LABEL.match(piece) for piece in pieces]
    if all(labelled):
        return [m[1].strip() for m in labelled if m], [m[2].strip() for m in labelled if m], separator
    return [], pieces, separator


def _value(cell: str) -> float | None:
    if _NUMBER.fullmatch(cell):
        return float(cell)
    return math.nan if _NOT_FINITE.fullmatch(cell) else None
