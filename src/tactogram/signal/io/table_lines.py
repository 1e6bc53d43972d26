"""Lines of terminals and loggers: time stamps in front, pairs of name and value, brackets."""

from __future__ import annotations

import re
from collections import Counter
from collections.abc import Callable, Sequence
from functools import partial
from typing import NamedTuple

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
        found = [form.fullmatch(line.text.strip()) for line in rows]
        kept = [(line, match) for line, match in zip(rows, found, strict=True) if match]
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
    found = [bracketed.fullmatch(line.text) for line in rows]
    return [
        NumberedLine(line.number, match[1]) if match else line
        for line, match in zip(rows, found, strict=True)
    ]


def pairs_apart(rows: list[NumberedLine]) -> tuple[list[NumberedLine], list[str]]:
    """Return lines of pairs (``x:0.1, y:0.2``) as their values between tabs, and the names with units."""
    if not _alike(rows, lambda text: bool(pairs_in(text))):
        return rows, []
    found = [pairs_in(line.text) for line in rows]
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
    found = next((match for form in (_STAMPED, _TICKED) if (match := form.fullmatch(text))), None)
    return found[found.lastindex or 0] if found else text


def pairs_in(text: str) -> list[tuple[str, str, str]]:
    """Return name, value and unit of each pair if a line consists of them."""
    text = text.strip().strip("{}").strip()
    found, at = [], 0
    if first := _FIRST.match(text):
        found, at = [("", first[1], "")], first.end()
    while at < len(text):
        match = _PAIR.match(text, at)
        if match is None:
            return [] if text[at:].strip(" ,;|\t") else found
        found.append((match[1].strip(), match[2], match[3]))
        at = match.end()
    return found if len(found) > 1 or (found and found[0][0]) else []


def is_ruler(text: str) -> bool:
    """Return whether a line divides a table, as ``----+----``."""
    return bool(_RULER.fullmatch(text))
