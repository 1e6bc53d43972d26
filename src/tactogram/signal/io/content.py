"""Content of a file before it becomes a Signal: raw columns and their layout, numbers, metadata."""

from __future__ import annotations

import json
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Annotated, Any, Self

import numpy as np
from numpy.typing import NDArray
from pydantic import Field, model_validator

from tactogram.errors import DataError, ParameterError, Remedy, TactogramError, UnitError
from tactogram.signal.signal import RATES, Domain, Signal, check_rate
from tactogram.signal.timing import steps_alike, to_uniform
from tactogram.signal.units import parse_seconds, parse_unit
from tactogram.text_files import parse_json
from tactogram.validation import DescribedModel, facts_of

VERSION = 1
TIME, RATE, IGNORED, UNCLEAR = "time", "rate", "ignored", "unclear"
LABELS = MATERIAL, SESSION, SUBJECT, TRIAL = "material", "session", "subject", "trial"
"""Roles of columns of words or codes."""


@dataclass(frozen=True)
class SignalDescription:
    """Everything about a signal but its samples, as one line of JSON in a comment of the file."""

    rate: float  # exact; a WAV header has whole Hz only
    unit: str
    axes: tuple[str, ...]
    domain: Domain = "time"
    full_scale: float | None = None  # value of the largest integer, in unit; for integer samples only
    metadata: Mapping[str, Any] = field(default_factory=dict)

    @classmethod
    def of(
        cls, signal: Signal, metadata: Mapping[str, Any] | None, *, full_scale: float | None = None
    ) -> SignalDescription:
        """Return the description of ``signal``."""
        return cls(signal.rate, signal.unit, signal.axes, signal.domain, full_scale, dict(metadata or {}))

    def encode(self) -> str:
        """Return it as one line of ASCII; `ParameterError` if the metadata is not JSON."""
        try:
            return json.dumps({"tactogram": VERSION, **vars(self)}, allow_nan=False)
        except (TypeError, ValueError) as error:
            raise ParameterError.must("metadata", f"be JSON values: {error}") from error


def decode(text: str, where: str) -> SignalDescription | None:
    """Return the description in ``text``, or None for a foreign comment; `DataError` if it is damaged or too new."""
    try:
        facts = parse_json(text, where)
    except DataError:
        return None
    if not isinstance(facts, dict) or "tactogram" not in facts:
        return None
    if facts["tactogram"] != VERSION:
        raise DataError(
            where, f"description must be of version {VERSION}, got {facts['tactogram']!r}; update"
        )
    return facts_of(SignalDescription, facts, where=f"{where}: description")


Column = NDArray[np.float64] | NDArray[np.object_]
"""Cells of a column, shape (row,): numbers, NaN where one is missing; or str, datetime and None where some are no
numbers."""


@dataclass(frozen=True, eq=False)
class RawTable:
    """Columns of equal length, whatever the format of the file: text, worksheet, arrays, channels of a measurement.

    A file whose columns are of several lengths or rates is several of these.
    """

    path: Path
    headings: tuple[str, ...]  # as in the file; "1", "2", … if it has none
    columns: tuple[Column, ...]
    units: tuple[str | None, ...] = ()
    """As the file spells them apart from the headings; empty if it does not."""
    groups: tuple[str, ...] = ()
    """Array, structure or sheet of each column; empty if there is none."""
    named: bool = True
    """Whether the headings are the file's."""
    rows: Sequence[int] = ()
    """Number of each row in the file, as an editor or spreadsheet counts; empty: from 0."""
    rate: float | None = None
    """Hz, if the file states one, in ``rate_name``."""
    rate_name: str | None = None
    description: SignalDescription | None = None
    """If this package wrote the file."""
    comment: str | None = None
    notes: tuple[str, ...] = ()
    """One line each, on what was left out or assumed while reading."""

    brief: bool = False
    """Whether these are the first rows of a longer table: what is constant or rises at times may be an axis."""

    rest: Callable[[], Iterable[RawTable]] | None = None
    """Reads the following rows of a table that is too long for memory."""
    most_rows: int = 0
    """At most so many rows are in all of such a table."""

    def __len__(self) -> int:
        return len(self.columns[0]) if self.columns else 0

    @property
    def numbered(self) -> bool:
        """Whether the columns are those of matrices or of a table without headings, and so have no names."""
        return not self.named or bool(self.groups and set(self.groups).isdisjoint(self.headings))


@dataclass(frozen=True)
class ColumnUse:
    """One column and what it is read as."""

    heading: str
    role: str  # name of the axis, or one of those above
    unit: str | None = None  # as the heading or the layout spells it
    stream: str | None = None  # of an axis of another stream than the signal's
    reason: str | None = None  # what an ignored column is, or why it is left out


class TableLayout(DescribedModel):
    """Contents of the columns of a table, whatever their headings suggest."""

    columns: Annotated[tuple[str, ...], Field(min_length=1)]
    """All headings of the tables to which it applies, in order (``"1"``, ``"2"``, … of a table without any), or the
    names of all arrays in an NPZ or MAT file (``"data:1"``, ``"data:2"``, … for the columns of a matrix)."""
    axes: dict[str, str] = Field(default_factory=dict)
    """Heading of each axis by the axis's name: the other columns are ignored. Without any, the headings decide."""
    unit: str | None = None
    """Unit of the axes; by default that of their headings."""
    time: str | None = None
    """Heading of the time stamps; with ``axes`` there are none by default."""
    material: str | None = None
    """Heading of the materials, words or codes, one recording as long as they stay; with ``axes`` there are none by
    default."""
    session: str | None = None
    """Heading of the sessions, which also divide the recordings, as the two below."""
    subject: str | None = None
    trial: str | None = None
    time_unit: str | None = None
    """``"s"``, ``"ms"``, ``"us"`` or ``"ns"`` of the time stamps; by default as their heading says."""
    rate: Annotated[float, Field(ge=RATES[0], le=RATES[1])] | None = None
    """Sampling rate in Hz; tables with time stamps are resampled to it."""
    stream: str | None = None
    """Name of the stream in a store; by default after the unit."""

    @model_validator(mode="after")
    def _consistent(self) -> Self:
        for key, heading in {
            **{f"axes.{name}": h for name, h in self.axes.items()},
            "time": self.time,
            **self.labels,
        }.items():
            if heading is not None and heading not in self.columns:
                raise ValueError(
                    f"{key} must be one of the columns {', '.join(self.columns)}, got {heading!r}"
                )
        used = [*self.axes.values(), *([] if self.time is None else [self.time]), *self.labels.values()]
        if len(set(used)) < len(used):
            raise ValueError(f"a column must be used once, got {', '.join(used)}")
        if self.time_unit is not None and self.time is None:
            raise ValueError("time_unit must come with time, the column of the stamps")
        if self.time_unit is not None and parse_seconds(self.time_unit) is None:
            raise ValueError(f"time_unit must be s, ms, us or ns, got {self.time_unit!r}")
        if self.unit is not None:
            try:
                parse_unit(self.unit)
            except UnitError as error:
                raise ValueError(str(error)) from None
        return self

    @property
    def labels(self) -> Mapping[str, str]:
        """Headings of the columns of labels by role."""
        return {role: heading for role in LABELS if (heading := getattr(self, role)) is not None}


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
        raise DataError(path, "no samples")
    with np.errstate(over="ignore", invalid="ignore"):
        finite = np.isfinite(content.samples.astype(np.float32, copy=False))
    if not finite.all():
        bad = np.argwhere(~finite.T)
        sample, axis = (int(i) for i in bad[0])
        value = content.samples[axis, sample]
        raise DataError(path, f"{content.place(axis, sample)}: expected a finite number, got {value:g}")
    if content.times is None or steps_alike(content.times):
        return
    back = np.flatnonzero(np.diff(content.times) < 0)
    if len(back):
        i = int(back[0])
        before, after = content.times[i : i + 2]
        raise DataError(
            path, f"{content.place(-1, i + 1)}: time goes backwards, {after:.9g} s after {before:.9g} s"
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
        raise DataError(path, error) from error


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
            path,
            f"expected {_counted(len(axes), 'axis', 'axes')} ({', '.join(axes)}), "
            f"got {count} ({', '.join(named)}); name all of them, or choose among these",
        )
    return content.samples, axes


def _unit(
    content: FileContent, samples: NDArray[np.float32] | NDArray[np.float64], path: Path, unit: str | None
) -> tuple[NDArray[np.float32] | NDArray[np.float64], str]:
    if unit is None:
        return samples, content.unit or "1"
    asked, factor = parse_unit(unit)
    if content.unit is None:
        if factor == 1:
            return samples, asked
        scaled = np.empty_like(samples)
        np.multiply(samples, factor, out=scaled, dtype=np.float64, casting="same_kind")
        return scaled, asked
    if asked != content.unit:
        raise DataError(
            path, f"the file is in {content.unit}, expected {unit}", remedy=Remedy("omit", "unit")
        )
    return samples, asked


def _rate(content: FileContent, rate: float | None) -> float:
    known, rate = content.rate, rate if rate is None else check_rate(rate)
    if known is None:
        if rate is None:
            remedy = Remedy("give the rate in Hz, e.g.", "rate", 1000)
            raise DataError("no time column and no rate in the file", remedy=remedy)
        return rate
    check_rate(known)
    # A header of whole Hz does not contradict the fractional rate that it was rounded from.
    exact = content.description is not None
    if rate is not None and (rate != known if exact else abs(rate - known) >= 1):
        remedy = Remedy("resample afterwards, here omit", "rate")
        raise DataError(f"the file is at {known:g} Hz, expected {rate:g}", remedy=remedy)
    return known if rate is None else rate


def _counted(count: int, one: str, many: str) -> str:
    return f"{count} {one if count == 1 else many}"
