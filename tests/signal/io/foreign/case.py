"""Tables of other programs with their right answers: cases, the rows they share, and the check of one."""

from __future__ import annotations

import re
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from datetime import datetime, timedelta
from pathlib import Path
from typing import Any

import numpy as np

from tactogram.errors import TactogramError
from tactogram.signal.io import read_file

G = 9.80665
N = 100
K = np.arange(N)
T = K / 100  # s
X, Y, Z = 0.5 * np.sin(0.2 * np.pi * K), 0.25 * np.cos(0.14 * np.pi * K), 1 + 0.1 * np.sin(0.4 * np.pi * K)
SLOW = np.sin(0.02 * np.pi * K)  # of further quantities
PEAKS = {"x": float(np.abs(X).max()), "y": float(np.abs(Y).max()), "z": float(np.abs(Z).max())}
EPOCH = 1767350000  # s
PEAK_ERROR, RATE_ERROR = 5e-3, 1e-3  # relative; cells are rounded


@dataclass(frozen=True)
class Right:
    """The file is read: this stream, unit, rate and peaks, and the notes say what was left out."""

    stream: str  # pattern of the name
    unit: str
    peaks: Mapping[str, float] | Sequence[float]  # by axis, in order; without names if any name will do
    rate: float = 100.0
    samples: int = N
    others: Mapping[str, str] = field(default_factory=dict)  # unit of further streams; there may be more
    absent: Sequence[str] = ()  # names of streams that there are not
    left_out: Sequence[str] = ()  # named in the notes
    note: str = ""  # pattern of a note


@dataclass(frozen=True)
class Ask:
    """An error of one line says what to choose; with ``remedy``, which it names, the file is read."""

    error: str  # pattern
    remedy: Mapping[str, Any]
    then: Right


@dataclass(frozen=True)
class Refused:
    """An error of one line: this is no signal, or nothing in the file can complete it."""

    error: str  # pattern


@dataclass(frozen=True)
class Case:
    """A layout, where it is documented, a file in it, and the answers that are right, any of which will do."""

    name: str
    source: str
    file: str
    write: Callable[[Path], object]
    answers: tuple[Right | Ask | Refused, ...]
    options: Mapping[str, Any]


@dataclass(frozen=True)
class Verdict:
    """What a reader made of a case: right, asked, refused or WRONG, whether that is good, and what differs."""

    word: str
    good: bool
    differs: str


def case(
    name: str,
    source: str,
    content: str | bytes | Callable[[Path], object],
    *answers: Right | Ask | Refused,
    file: str = "table.csv",
    encoding: str = "utf-8",
    **options: Any,
) -> Case:
    """Return a case whose file holds ``content``, or is written by it; ``options`` are given to the reader."""
    if isinstance(content, str):
        content = content.encode(encoding)
    if isinstance(content, bytes):
        return Case(name, source, file, lambda path, data=content: path.write_bytes(data), answers, options)
    return Case(name, source, file, content, answers, options)


def rows(*columns: Any, sep: str = ",", decimal: str = ".", end: str = "\n", tail: str = "") -> str:
    """Return rows of cells: arrays and lists by row, anything else in each row."""
    cells = [[_cell(value, decimal) for value in _values(column)] for column in columns]
    return "".join(sep.join(row) + tail + end for row in zip(*cells, strict=True))


def table(heading: str, *columns: Any, **layout: Any) -> str:
    """Return a line of headings and the `rows` below it."""
    return heading + layout.get("end", "\n") + rows(*columns, **layout)


def fixed(values: Any, places: int) -> list[str]:
    """Return numbers with as many decimal places."""
    return [f"{value:.{places}f}" for value in values]


def stamps(form: str, step: float = 0.01, start: datetime = datetime(2026, 1, 2, 10, 23, 45)) -> list[str]:
    """Return calendar stamps; ``%L`` is milliseconds."""
    times = [start + timedelta(seconds=round(float(k * step), 9)) for k in K]
    return [time.strftime(form.replace("%L", f"{time.microsecond // 1000:03d}")) for time in times]


def acceleration(scale: float = 1.0, unit: str = "m/s^2", **further: Any) -> Right:
    """Return the answer of a table of `X`, `Y` and `Z`, times ``scale`` in the unit of the signal."""
    return Right("acceleration", unit, {axis: scale * peak for axis, peak in PEAKS.items()}, **further)


def plain(stream: str = "acceleration|vibration", **further: Any) -> Right:
    """Return the answer of a table of `X`, `Y` and `Z` that states no unit."""
    return Right(stream, "1", PEAKS, **{"note": "unit"} | further)


def measured(stream: str, unit: str, *columns: Any, axes: str | None = "xyz", **further: Any) -> Right:
    """Return the answer of a table of these columns, of axes with one letter each, or of any names."""
    peaks = [float(np.abs(np.asarray(column, float)).max()) for column in columns]
    return Right(stream, unit, peaks if axes is None else dict(zip(axes, peaks, strict=True)), **further)


def one(stream: str, unit: str, peak: float = PEAKS["x"], **further: Any) -> Right:
    """Return the answer of a table of `X`, whatever its axis is called."""
    return Right(stream, unit, (peak,), **further)


def check(example: Case, folder: Path) -> Verdict:
    """Return what the reader makes of a case, in words; attributes that its answer does not have yet are absent."""
    path = folder / example.file
    path.parent.mkdir(parents=True, exist_ok=True)
    example.write(path)
    verdicts = [_against(answer, path, example.options) for answer in example.answers]
    return min(verdicts, key=lambda verdict: (not verdict.good, len(verdict.differs)))


def _against(answer: Right | Ask | Refused, path: Path, options: Mapping[str, Any]) -> Verdict:
    try:
        read = read_file(path, **options)
    except (TactogramError, TypeError) as error:
        if isinstance(error, TypeError) and "unexpected keyword" not in str(error):
            raise
        return _error(answer, path, str(error), options)
    if not isinstance(answer, Right):
        return Verdict(
            "WRONG", False, f"read without asking, expected an error like {answer.error!r}; {_outline(read)}"
        )
    differs = differences(answer, read)
    return Verdict("WRONG" if differs else "right", not differs, differs)


def _error(answer: Right | Ask | Refused, path: Path, text: str, options: Mapping[str, Any]) -> Verdict:
    said = text.replace(str(path), path.name)
    if isinstance(answer, Right):
        return Verdict("refused", False, said)
    if "\n" in said:
        return Verdict("refused", False, f"more than one line: {said!r}")
    if not re.search(answer.error, said, re.IGNORECASE):
        return Verdict("refused", False, f"expected an error like {answer.error!r}, got: {said}")
    if isinstance(answer, Refused):
        return Verdict("refused", True, "")
    if not any(f"{name}=" in said for name in answer.remedy):
        return Verdict("asked", False, f"names no remedy {' or '.join(answer.remedy)}: {said}")
    try:
        differs = differences(answer.then, read_file(path, **{**options, **answer.remedy}))
    except (TactogramError, TypeError) as error:
        return Verdict("asked", False, f"with {dict(answer.remedy)}: {error}".replace(str(path), path.name))
    return Verdict("asked", not differs, f"with {dict(answer.remedy)}: {differs}" if differs else "")


def differences(right: Right, read: Any) -> str:
    """Return what differs from the right answer, in one line; nothing if nothing does."""
    signal = read.signal
    found: list[str] = []

    def expect(what: str, wanted: Any, got: Any, same: bool) -> None:
        if not same:
            found.append(f"{what} {got} instead of {wanted}")

    stream = getattr(read, "stream", None)
    expect("stream", right.stream, stream, bool(re.fullmatch(right.stream, stream or "")))
    expect("unit", right.unit, signal.unit, signal.unit == right.unit)
    expect("rate", right.rate, f"{signal.rate:.6g}", abs(signal.rate / right.rate - 1) < RATE_ERROR)
    expect("samples", right.samples, signal.samples.shape[1], signal.samples.shape[1] == right.samples)
    named = isinstance(right.peaks, Mapping)
    wanted = [*right.peaks.values()] if isinstance(right.peaks, Mapping) else [*right.peaks]
    axes = tuple(right.peaks) if named else f"{len(wanted)} axes"
    expect(
        "axes", axes, signal.axes, tuple(signal.axes) == axes if named else len(signal.axes) == len(wanted)
    )
    peaks = np.abs(signal.samples).max(axis=1)
    if len(peaks) == len(wanted):
        close = np.allclose(peaks, wanted, rtol=PEAK_ERROR)
        expect("peaks", _numbers(wanted), _numbers(peaks), close)
    others = {name: other.unit for name, other in getattr(read, "others", {}).items()}
    for name, unit in right.others.items():
        expect(f"stream {name} in", unit, others.get(name), others.get(name) == unit)
    notes = " | ".join(getattr(read, "notes", ()))
    for name in right.absent:
        expect("stream", f"no {name}", f"{name} in {others.get(name)}", name not in others)
    for heading in right.left_out:
        expect("notes", f"{heading!r} left out", repr(notes), heading.lower() in notes.lower())
    expect("notes", repr(right.note), repr(notes), bool(re.search(right.note, notes, re.IGNORECASE)))
    return "; ".join(found)


def _outline(read: Any) -> str:
    signal, stream = read.signal, getattr(read, "stream", "")
    return f"{stream} {', '.join(signal.axes)} in {signal.unit}, {signal.samples.shape[1]} at {signal.rate:.6g} Hz"


def _numbers(values: Sequence[float]) -> str:
    return "(" + ", ".join(f"{value:.4g}" for value in values) + ")"


def _values(column: Any) -> Sequence[Any]:
    return column if isinstance(column, list | np.ndarray) else [column] * N


def _cell(value: Any, decimal: str) -> str:
    text = f"{value:.9g}" if isinstance(value, float) else str(value)
    return text.replace(".", decimal) if re.fullmatch(r"[-+]?\d*\.\d+([eE][-+]?\d+)?", text) else text
