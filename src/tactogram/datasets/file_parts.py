"""Parts of a take in a plain folder: the whole of its files, or what labels and holes divide them into.

Whatever readers of files return reaches a recording here alone.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Any

import numpy as np

from tactogram.datasets.importer import LeftOut
from tactogram.datasets.recording import FileReading
from tactogram.datasets.takes import QUANTITIES
from tactogram.errors import DataError, Message, Remedy, TactogramError
from tactogram.signal import Signal
from tactogram.signal.io import SignalFile, complete, read_contents
from tactogram.signal.io.content import MATERIAL, ColumnUse, FileContent, TableLayout
from tactogram.signal.io.labels import LONGEST_STEP, Interval, cut
from tactogram.signal.signal import UNITS
from tactogram.signal.timing import steps_alike
from tactogram.signal.units import parse_unit

LEAST_ROWS = 32
"""Rows of the shortest part of a table that is a recording: fewer say little about rate and spectrum."""
MOST_HOLES = 0.01
"""Share of steps above which long ones are the pauses between blocks of stamps rather than holes."""
HOLES = "a hole of more than three missing samples divides the recording"


@dataclass(frozen=True, eq=False)
class FilePart:
    """Streams of a part of a take, with its labels by role."""

    streams: Mapping[str, Signal]
    reading: FileReading
    metadata: Mapping[str, Any]
    labels: Mapping[str, str] = field(default_factory=dict)
    number: int | None = None  # from 1; None of a whole take


@dataclass(frozen=True, eq=False)
class _Source:
    """Content of one file, once for each stream of a mapping, and the quantity that the file's name states."""

    path: Path
    quantity: str | None
    content: FileContent


def read_parts(
    paths: Sequence[Path], streams: Sequence[str | None], info: Mapping[str, Any], *, name: str
) -> list[FilePart | LeftOut]:
    """Return the parts of a take in order, and those that are left out.

    Raises `DataError` if a file cannot be read, or no part of it is a recording.

    Parameters
    ----------
    paths : sequence of Path
        Files of the take.
    streams : sequence of str or None
        Quantity that the name of each file states.
    info : mapping
        ``unit``, ``rate``, ``axes``, ``stream`` and ``layouts``, as the importer of folders has them; ``problem``, an
        error of a take without a column of materials; ``whole``, if labels are not to be read.
    name : str
        Name of the take in messages.
    """
    labelled = not info.get("whole") and len(paths) == 1
    sources = [
        _Source(path, None if number else quantity, content)
        for path, quantity in zip(paths, streams, strict=True)
        for number, content in enumerate(_contents(path, info, labelled=labelled))
    ]
    labels = labelled and sources[0].content.labels
    if not labels and "problem" in info:
        raise DataError(info["problem"])
    intervals = cut([source.content for source in sources]) if labels else _without_holes(sources)
    if not intervals:
        return [_whole(sources, info)]
    heading = {use.role: use.heading for use in sources[0].content.uses}.get(MATERIAL) if labels else None
    parts: list[FilePart | LeftOut] = []
    unlabelled = number = 0
    for interval in intervals:
        if heading is not None and MATERIAL not in interval.labels:
            unlabelled += len(interval.contents[0].rows)
            continue
        number += 1
        parts.append(_part(sources, interval, number, info, name))
    if not any(isinstance(part, FilePart) or part.broken for part in parts):
        raise DataError(paths[0], _useless(heading, intervals, labels=bool(labels)))
    if not labels:
        first = next(part for part in parts if isinstance(part, FilePart) or part.broken)
        if isinstance(first, FilePart):
            reading = replace(first.reading, notes=(*first.reading.notes, HOLES))
            parts[parts.index(first)] = replace(first, reading=reading)
    if unlabelled:
        reason = f"{unlabelled} row{'s' * (unlabelled != 1)} without a label in column {heading!r}"
        parts.append(LeftOut("unlabelled", Message(reason, place=name)))
    return parts


def has_labels(path: Path, layouts: Sequence[TableLayout]) -> bool:
    """Return whether a table names the material of each row; False if it cannot be read."""
    try:
        return MATERIAL in read_contents(path, layouts=layouts, labelled=True)[0].labels
    except TactogramError:
        return False


def _contents(path: Path, info: Mapping[str, Any], *, labelled: bool) -> tuple[FileContent, ...]:
    options = {name: info.get(name) for name in ("axes", "time", "rate")}
    return read_contents(path, layouts=info.get("layouts", ()), labelled=labelled, **options)


def _without_holes(sources: Sequence[_Source]) -> list[Interval]:
    """Return the intervals between holes in any of the files, which share a clock; none if there is no hole."""
    edges = [edge for source in sources for edge in _holes(source.content)]
    if not edges:
        return []
    starts = [-np.inf, *sorted(stop for _, stop in edges)]
    stops = [*sorted(start for start, _ in edges), np.inf]
    intervals = []
    for start, stop in zip(starts, stops, strict=True):
        parts = [_between(source.content, start, stop) for source in sources]
        rows = parts[0].rows
        if all(part.samples.shape[1] for part in parts):
            intervals.append(Interval({}, (rows[0], rows[-1]) if rows else (0, 0), tuple(parts)))
    return intervals


def _holes(content: FileContent) -> list[tuple[float, float]]:
    """Return the stamps around each hole."""
    times = content.times
    if times is None or len(times) < LEAST_ROWS or content.description is not None or steps_alike(times):
        return []
    steps = np.diff(times)
    if not (np.isfinite(steps).all() and (steps >= 0).all() and (steps > 0).any()):
        return []  # an error when it is read
    long = np.flatnonzero(steps > LONGEST_STEP * np.median(steps[steps > 0]))
    if len(long) > max(1, MOST_HOLES * len(steps)):
        return []
    return [(float(times[i]), float(times[i + 1])) for i in long]


def _between(content: FileContent, start: float, stop: float) -> FileContent:
    if content.times is None:
        raise DataError(f"{HOLES}, and a file of the take has no time stamps to divide it by")
    begin, end = np.searchsorted(content.times, [start, stop], side="left")
    end += int(end < len(content.times) and content.times[end] == stop)
    return replace(
        content,
        samples=content.samples[:, begin:end],
        times=content.times[begin:end],
        rows=content.rows[begin:end],
        place=lambda axis, sample: content.place(axis, begin + sample),
    )


def _part(
    sources: Sequence[_Source], interval: Interval, number: int, info: Mapping[str, Any], name: str
) -> FilePart | LeftOut:
    where = f"rows {interval.rows[0]} to {interval.rows[1]}"
    count = min(content.samples.shape[1] for content in interval.contents)
    if count < LEAST_ROWS:
        what = f" of {interval.labels[MATERIAL]!r}" if MATERIAL in interval.labels else ""
        reason = f"{count} sample{'s' * (count != 1)}{what}, a recording needs {LEAST_ROWS}"
        remedy = "correct the labels there, or record longer" if interval.labels else HOLES
        return LeftOut(str(number), Message(reason, remedy, place=f"{name}: {where}"))
    parts = [replace(source, content=c) for source, c in zip(sources, interval.contents, strict=True)]
    try:
        part = _whole(parts, info)
    except TactogramError as error:
        reason = Message(error.message.within(sources[0].path), place=f"{name}: {where}")
        return LeftOut(str(number), reason, broken=True)
    return replace(part, labels=interval.labels, number=number)


def _whole(sources: Sequence[_Source], info: Mapping[str, Any]) -> FilePart:
    streams: dict[str, Signal] = {}
    files: dict[str, SignalFile] = {}
    notes: list[str] = []
    begins: dict[str, float] = {}
    for number, source in enumerate(sources):
        main = number == 0
        axes = info.get("axes") if main else None
        unit = _unit_for(source, info.get("unit"))
        file = complete(source.content, source.path, unit=unit, axes=axes, rate=info.get("rate"))
        stream, note = _named(source, file, info.get("stream") if main else None)
        if stream in streams:
            raise DataError(source.path, f"{stream} is in another file of the same take, too; move one away")
        streams[stream] = file.signal
        files[stream] = file
        notes += [each for each in (*file.notes, *note) if each not in notes]
        if file.times is not None:
            begins[source.path.name] = float(file.times[0])
    first = next(iter(files.values()))
    notes += _late(begins, first.signal)
    if info.get("unit") != "1":
        notes += _without_unit(files)
    timing, tables = first.timing, _uses(sources, files)
    return FilePart(
        streams,
        FileReading(
            columns=tuple(use for uses in tables for use in uses),
            mapped=first.layout is not None,
            timing=timing,
            rate_estimated=timing is not None
            and (info.get("rate") or (first.layout and first.layout.rate)) is None,
            notes=tuple(notes),
            tables=tuple(map(len, tables)) if len(tables) > 1 else (),
        ),
        first.metadata,
    )


def _unit_for(source: _Source, units: str | None) -> str | None:
    """Return the one of several units, separated by commas, that a file may have; alone it is for any quantity."""
    if units is None:
        return None
    expected = _expected(source.quantity)
    named = [unit.strip() for unit in units.split(",")]
    if len(named) == 1 and expected is None:
        return named[0]
    fitting = [unit for unit in named if parse_unit(unit)[0] == (expected or source.content.unit)]
    return fitting[0] if fitting else None


def _expected(quantity: str | None) -> str | None:
    """Return the unit of a quantity; None if it may have several, or is not known."""
    return QUANTITIES.get((quantity or "").removeprefix("uncalibrated_"), (None,))[0]


def _without_unit(files: Mapping[str, SignalFile]) -> list[str]:
    """Return a note on the streams of tables whose unit no heading states, with the option that states it."""
    without = {
        stream: _expected(stream) or "g"
        for stream, file in files.items()
        if file.signal.unit == "1"
        and _expected(stream) != "1"
        and file.columns
        and not any(use.unit == "1" for use in file.columns)
    }
    known = ",".join(dict.fromkeys(unit for unit in without.values() if unit in UNITS or unit == "g"))
    remedies = [Remedy("state it,", "unit", known)] if known else []
    return [Message(f"no unit stated for {', '.join(without)}", *remedies)] * bool(without)


def _late(begins: Mapping[str, float], first: Signal) -> list[str]:
    """Return a note on each file whose first stamp is later than another's."""
    late = {name: start - min(begins.values()) for name, start in begins.items()}
    return [
        f"{name} begins {1e3 * by:.4g} ms late"
        if by < first.extent
        else f"{name}: its clock is another; taken to begin with the other files of the take"
        for name, by in late.items()
        if by * first.rate > 1
    ]


def _named(source: _Source, file: SignalFile, stream: str | None) -> tuple[str, tuple[str, ...]]:
    """Return the name of a file's stream, and a note if its own name states another quantity than its unit."""
    unit, quantity = file.signal.unit, source.quantity
    stated = stream or (file.layout and file.layout.stream)
    if stated:
        return stated, ()
    by_unit = file.stream
    if quantity is None:
        return by_unit, ()
    if unit in (_expected(quantity), "1") or _expected(quantity) is None:
        return quantity, ()
    return by_unit, (f"{source.path.name}: read as {by_unit}, for its unit is {unit}",)


def _uses(sources: Sequence[_Source], files: Mapping[str, SignalFile]) -> list[list[ColumnUse]]:
    """Return what the columns of each file were read as; of several streams, axes have their stream's name in front."""
    uses: dict[Path, list[ColumnUse]] = {}
    for source, (stream, file) in zip(sources, files.items(), strict=True):
        if source.path in uses:
            continue  # the streams of a file share its columns
        axes = {axis for other in files.values() for axis in other.signal.axes}
        uses[source.path] = [
            replace(use, role=f"{use.stream or stream}: {use.role}")
            if len(files) > 1 and use.role in axes
            else use
            for use in file.columns
        ]
    return list(uses.values())


def _useless(heading: str | None, intervals: Sequence[Interval], *, labels: bool) -> Message:
    """Return why no part of a table is a recording."""
    mapping = "mapping", "FILE.toml"
    named = {interval.labels[MATERIAL] for interval in intervals if MATERIAL in interval.labels}
    if not labels:
        return Message(f"{HOLES}, of which none has {LEAST_ROWS} samples", "record without losses")
    if heading is None:
        problem = f"its labels change more often than every {LEAST_ROWS} rows"
        return Message(problem, Remedy("omit its column,", *mapping))
    if not named:
        problem = f"column {heading!r} has no label in any row"
        return Message(problem, "fill it in", Remedy("omit it,", *mapping))
    return Message(
        f"none of its {len(named)} labels holds for {LEAST_ROWS} rows in succession",
        Remedy("if these are no labels of materials, omit the column,", *mapping),
        place=f"column {heading!r}",
    )
