"""Lines of terminals and loggers: time stamps in front, pairs of name and value, brackets."""

from __future__ import annotations

import re
from collections import Counter
from collections.abc import Callable, Sequence
from typing import NamedTuple

MOST = 0.8
"""Share of the lines that must be alike."""
SNIFFED = 200
"""Lines that are looked at for it."""
_STAMPED = re.compile(
    r"\[?((?:\d{4}[-/.]\d\d[-/.]\d\d[T ])?\d{1,2}:\d\d:\d\d(?:[.,:]\d+)?)\]?(?:\s*(?:->|>)\s*|:?[ \t]+)(?=[^\s,;])(.*)"
)
"""``10:23:45.123 -> 1,2`` (Arduino), ``[2026-01-02 10:23:45.123] 1,2`` (Tera Term, CoolTerm)."""
_TICKED = re.compile(r"[IWED] \((\d+)\) [\w.-]+: ()(.*)")
"""``I (1234) imu: 1,2`` (ESP-IDF), in ms."""
_NUMBER = r"[-+]?(?:\d+\.?\d*|\.\d+)(?:[eE][-+]?\d+)?|nan"
_PAIR = re.compile(
    rf"\s*[,;|\t]?\s*\"?([A-Za-z_][\w .\-/]*?(?:\s*[\[(][^\])]*[\])])?)\"?\s*[:=]\s*\"?({_NUMBER})\"?\s*((?:[^\s,;|:=\d][^\s,;|:=]*)?)(?=[\s,;|}}]|$)",
    re.IGNORECASE,
)


class NumberedLine(NamedTuple):
    """A line of a file, counted from 1."""

    number: int
    text: str


def prefix_apart(rows: list[NumberedLine]) -> tuple[list[NumberedLine], tuple[str, list[str]] | None]:
    """Return the lines without the time that a terminal put in front, and its heading and stamps if there are any."""
    for form, heading in ((_STAMPED, "time"), (_TICKED, "time [ms]")):
        if not _alike(rows, lambda text, form=form: bool(form.fullmatch(text.strip()))):
            continue
        found = [form.fullmatch(line.text.strip()) for line in rows]
        kept = [(line, match) for line, match in zip(rows, found, strict=True) if match]
        return (
            [NumberedLine(line.number, match[match.lastindex or 0]) for line, match in kept],
            (heading, [match[1] for _, match in kept]),
        )
    return rows, None


def without_brackets(rows: list[NumberedLine]) -> list[NumberedLine]:
    """Return the lines without the brackets around them, as Python prints tuples and lists."""
    bracketed = re.compile(r"\s*[(\[](.*)[)\]]\s*")
    if not _alike(rows, lambda text: bool(bracketed.fullmatch(text))):
        return rows
    found = [bracketed.fullmatch(line.text) for line in rows]
    return [NumberedLine(line.number, match[1]) if match else line for line, match in zip(rows, found, strict=True)]


def pairs_apart(rows: list[NumberedLine]) -> tuple[list[NumberedLine], list[str]]:
    """Return lines of pairs (``x:0.1, y:0.2``) as their values between tabs, and the names with units."""
    if not _alike(rows, lambda text: bool(_pairs(text))):
        return rows, []
    found = [_pairs(line.text) for line in rows]
    names = Counter(tuple(name for name, _, _ in pairs) for pairs in found if pairs).most_common(1)[0][0]
    if len(set(names)) < len(names):
        return rows, []
    kept = [
        (line, pairs)
        for line, pairs in zip(rows, found, strict=True)
        if pairs and tuple(name for name, _, _ in pairs) == names
    ]
    units = [next((pairs[i][2] for _, pairs in kept if pairs[i][2]), "") for i in range(len(names))]
    # A unit at the end of the line is that of all: ``X: 0.1 Y: 0.2 Z: 9.8 m/s^2``.
    shared = units[-1] if units[-1] and not any(units[:-1]) else ""
    headings = [f"{name} [{unit or shared}]" if unit or shared else name for name, unit in zip(names, units, strict=True)]
    lines = [NumberedLine(line.number, "\t".join(value for _, value, _ in pairs)) for line, pairs in kept]
    return lines, headings


def _alike(rows: Sequence[NumberedLine], test: Callable[[str], bool]) -> bool:
    """Return whether most lines in the middle of a file pass a test."""
    sample = rows[len(rows) // 2 :][:SNIFFED]
    return sum(test(line.text) for line in sample) >= MOST * len(sample) > 0


def _pairs(text: str) -> list[tuple[str, str, str]]:
    """Return name, value and unit of each pair if a line consists of them."""
    text = text.strip().strip("{}").strip()
    found, at = [], 0
    while at < len(text):
        match = _PAIR.match(text, at)
        if match is None:
            return [] if text[at:].strip(" ,;|\t") else found
        found.append((match[1].strip(), match[2], match[3]))
        at = match.end()
    return found
