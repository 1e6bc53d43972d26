"""Parts of a file in a plain folder: the whole of it, or what its columns of labels divide a table into."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from tactogram.datasets.importer import LeftOut
from tactogram.datasets.mapping import layouts_by_columns
from tactogram.errors import DataError, TactogramError
from tactogram.signal.io import SignalFile, complete, read_content
from tactogram.signal.io.content import FileContent
from tactogram.signal.io.labels import Interval, cut
from tactogram.signal.io.layout import MATERIAL

LEAST_ROWS = 32
"""Rows of the shortest part of a table that is a recording: fewer say little about rate and spectrum."""
STREAM_OF_UNIT = {
    "m/s^2": "acceleration",
    "m/s": "velocity",
    "m": "position",
    "N": "force",
    "V": "voltage",
    "1": "vibration",
}


@dataclass(frozen=True, eq=False)
class FilePart:
    """Streams of a part of a file, with its labels by role."""

    streams: Mapping[str, SignalFile]
    labels: Mapping[str, str] = field(default_factory=dict)
    number: int | None = None  # from 1; None of a whole file


def read_parts(path: Path, info: Mapping[str, Any], *, name: str) -> list[FilePart | LeftOut]:
    """Return the parts of a file in order, and those of a table that are left out.

    Parameters
    ----------
    path : Path
    info : mapping
        ``unit``, ``rate``, ``axes``, ``stream`` and ``layouts``, as the importer of folders has them; ``problem``, an
        error of a file without a column of materials; ``whole``, if labels are not to be read.
    name : str
        Name of the file in messages.

    Raises
    ------
    DataError
        If the file cannot be read, or no part of it is a recording.
    """
    contents = _contents(path, info)
    if not contents[0].labels or info.get("whole"):
        if "problem" in info:
            raise DataError(info["problem"])
        return [FilePart(_streams(contents, path, info))]
    heading = {use.role: use.heading for use in contents[0].uses}.get(MATERIAL)
    found: list[FilePart | LeftOut] = []
    unlabelled = number = 0
    intervals = cut(contents)
    for interval in intervals:
        if heading is not None and MATERIAL not in interval.labels:
            unlabelled += len(interval.contents[0].rows)
            continue
        number += 1
        found.append(_part(interval, number, path, info, name))
    if not any(isinstance(part, FilePart) or part.broken for part in found):
        raise DataError(f"{path}: {_useless(heading, intervals)}")
    if unlabelled:
        reason = f"{name}: {unlabelled} row{'s' * (unlabelled != 1)} without a label in column {heading!r}"
        found.append(LeftOut("unlabelled", reason))
    return found


def _contents(path: Path, info: Mapping[str, Any]) -> list[FileContent]:
    """Return the content of a file, once for each of the streams that the mapping finds in it."""
    labelled = not info.get("whole")
    layouts = [
        layout.model_copy(update={role: name for other in alike for role, name in other.labels.items()})
        for alike in layouts_by_columns(info.get("layouts", ())).values()
        for layout in alike
    ]
    first = read_content(path, axes=info.get("axes"), layouts=layouts, labelled=labelled)
    others = layouts_by_columns(layouts)[first.layout.columns][1:] if first.layout else ()
    return [first, *(read_content(path, layouts=(layout,), labelled=labelled) for layout in others)]


def _part(
    interval: Interval, number: int, path: Path, info: Mapping[str, Any], name: str
) -> FilePart | LeftOut:
    where = f"rows {interval.rows[0]} to {interval.rows[1]}"
    count = min(len(content.rows) for content in interval.contents)
    if count < LEAST_ROWS:
        what = f" of {interval.labels[MATERIAL]!r}" if MATERIAL in interval.labels else ""
        return LeftOut(
            str(number),
            f"{name}: {where}: {count} sample{'s' * (count != 1)}{what}, a recording needs {LEAST_ROWS}; correct "
            "the labels there, or record longer",
        )
    try:
        return FilePart(_streams(interval.contents, path, info), interval.labels, number)
    except TactogramError as error:
        reason = str(error).removeprefix(f"{path}: ")
        return LeftOut(str(number), f"{name}: {where}: {reason}", broken=True)


def _streams(contents: Sequence[FileContent], path: Path, info: Mapping[str, Any]) -> dict[str, SignalFile]:
    first, *others = contents
    rate = info.get("rate")
    file = complete(first, path, unit=info.get("unit"), axes=info.get("axes"), rate=rate)
    stream = info.get("stream") or (file.layout and file.layout.stream) or STREAM_OF_UNIT[file.signal.unit]
    files = {stream: file}
    for content in others:
        other = complete(content, path, rate=rate)
        files[str(other.layout and other.layout.stream)] = other
    return files


def _useless(heading: str | None, intervals: Sequence[Interval]) -> str:
    """Return why no part of a table is a recording."""
    labels = {interval.labels[MATERIAL] for interval in intervals if MATERIAL in interval.labels}
    if heading is None:
        return f"its labels change more often than every {LEAST_ROWS} rows; omit them from the mapping"
    if not labels:
        return f"column {heading!r} has no label in any row; fill it in, or omit it from the mapping"
    return (
        f"column {heading!r}: none of its {len(labels)} labels holds for {LEAST_ROWS} rows in succession; if these are "
        "no labels of materials, omit the column from a mapping"
    )
