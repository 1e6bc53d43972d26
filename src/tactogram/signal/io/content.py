"""Content of a file before it becomes a Signal: numbers, metadata, and their place in the file."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from tactogram.errors import DataError, TactogramError
from tactogram.signal.io.description import SignalDescription
from tactogram.signal.io.layout import ColumnUse, TableLayout
from tactogram.signal.signal import Signal, check_rate
from tactogram.signal.timing import to_uniform
from tactogram.signal.units import parse_unit


@dataclass(frozen=True, eq=False)
class FileContent:
    """Numbers of one stream in a file, with what the file states about them."""

    samples: NDArray[np.float32] | NDArray[np.float64]  # shape (axis, time), in unit if that is known
    axes: tuple[str, ...]  # empty if the file names none
    rate: float | None  # None if the file has time stamps or does not state it
    times: NDArray[np.float64] | None  # time stamps, s, shape (time,)
    unit: str | None  # one of `UNITS`, if the file states it
    description: SignalDescription | None  # if this package wrote the file
    place: Callable[[int, int], str]  # of (axis, sample): "row 7, column 'x'"; axis -1 is the time stamp
    comment: str | None = None  # of a foreign WAV or FLAC
    uses: tuple[ColumnUse, ...] = ()  # of the columns of a table, or the arrays of an NPZ
    layout: TableLayout | None = None  # which decided about them
    labels: Mapping[str, Sequence[str]] = field(
        default_factory=dict
    )  # of each row by role, if they were to be read
    rows: Sequence[int] = ()  # numbers of the rows in the file, of a table
    stream: str = ""  # name of the quantity, where headings or units tell it
    notes: tuple[str, ...] = ()  # one line each, for people
    chosen: bool = False  # whether the axes asked for were columns of the file, and are selected already


def check(content: FileContent, path: Path) -> None:
    """Raise a `DataError` with the place if there are no samples, one is not finite (in float32), or time goes back."""
    if content.samples.size == 0:
        raise DataError(f"{path}: no samples")
    with np.errstate(over="ignore", invalid="ignore"):
        bad = np.argwhere(~np.isfinite(content.samples.astype(np.float32, copy=False)).T)
    if len(bad):
        sample, axis = (int(i) for i in bad[0])
        value = content.samples[axis, sample]
        raise DataError(f"{path}: {content.place(axis, sample)}: expected a finite number, got {value:g}")
    if content.times is None:
        return
    back = np.flatnonzero(np.diff(content.times) < 0)
    if len(back):
        i = int(back[0])
        before, after = content.times[i : i + 2]
        raise DataError(
            f"{path}: {content.place(-1, i + 1)}: time goes backwards, {after:.9g} s after {before:.9g} s"
        )


def assemble(
    content: FileContent, path: Path, *, unit: str | None, axes: Sequence[str] | None, rate: float | None
) -> Signal:
    """Return the signal in ``content``, completed by the arguments; `DataError` if they contradict the file."""
    check(content, path)
    samples, names = _axes(content, path, axes)
    samples, unit = _unit(content, samples, path, unit)
    domain = content.description.domain if content.description else "time"
    try:
        if content.times is not None:
            return to_uniform(content.times, samples, unit, axes=names, rate=rate)
        known = _rate(content, rate)
        return Signal(samples.astype(np.float32, copy=False), known, unit, names, domain)
    except TactogramError as error:
        raise DataError(f"{path}: {error}") from error


def default_axes(count: int) -> tuple[str, ...]:
    """Return the names of axes that have none."""
    return {1: ("z",), 3: ("x", "y", "z")}.get(count) or tuple(map(str, range(1, count + 1)))


def _axes(
    content: FileContent, path: Path, axes: Sequence[str] | None
) -> tuple[NDArray[np.float32] | NDArray[np.float64], tuple[str, ...]]:
    """Return the rows that ``axes`` names, or all of them under those names."""
    count = len(content.samples)
    named = content.axes or default_axes(count)
    if axes is None:
        return content.samples, named
    axes = tuple(axes)
    if all(name in named for name in axes):
        return content.samples[[named.index(name) for name in axes]], axes
    if len(axes) != count:
        raise DataError(
            f"{path}: expected {_counted(len(axes), 'axis', 'axes')} ({', '.join(axes)}), "
            f"got {count} ({', '.join(named)}); name all of them, or choose among these"
        )
    return content.samples, axes


def _unit(
    content: FileContent, samples: NDArray[np.float32] | NDArray[np.float64], path: Path, unit: str | None
) -> tuple[NDArray[np.float32] | NDArray[np.float64], str]:
    if unit is None:
        return samples, content.unit or "1"
    asked, factor = parse_unit(unit)
    if content.unit is None:
        return samples if factor == 1 else samples.astype(np.float64) * factor, asked
    if asked != content.unit:
        raise DataError(f"{path}: the file is in {content.unit}, expected {unit}; leave the unit out")
    return samples, asked


def _rate(content: FileContent, rate: float | None) -> float:
    known = content.rate
    if known is None:
        if rate is None:
            raise DataError("no time column and no rate in the file; give the rate in Hz, e.g. `rate=1000`")
        return rate
    check_rate(known)
    # A header of whole Hz does not contradict the fractional rate that it was rounded from.
    exact = content.description is not None
    if rate is not None and (rate != known if exact else abs(rate - known) >= 1):
        raise DataError(f"the file is at {known:g} Hz, expected {rate:g}; leave the rate out, then resample")
    return known if rate is None else rate


def _counted(count: int, one: str, many: str) -> str:
    return f"{count} {one if count == 1 else many}"
