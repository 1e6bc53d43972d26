"""Columns of a board's lines, by the rules that hold for the tables in files."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray
from pydantic import BaseModel, ConfigDict, Field

from tactogram.signal import parse_unit
from tactogram.signal.io import RawTable, TableHead, default_axes, roles_of, unit_note
from tactogram_capture.stream.channels import axis_names


class CsvFormat(BaseModel):
    """Format of a board's lines; by default the columns are understood as those of a table in a file."""

    model_config = ConfigDict(frozen=True, extra="forbid")

    time: str | None = None
    """Column of the board's time, by name or number (from 1), with its unit if need be (``ticks [us]``); ``"none"`` if
    there is none."""
    unit: str | None = None
    """Unit of the samples: m/s^2, g, mg, V, N, …, or of counts: g/16384; by default the heading's, or 1."""
    scale: float = Field(default=1.0, allow_inf_nan=False)
    """Factor from the printed numbers to that unit."""
    rate: float | None = Field(default=None, gt=0, allow_inf_nan=False)
    """Nominal rate, Hz; by default learnt from the board's time."""
    axes: str | None = None
    """Columns of the samples by name or number, separated by commas, or new names for them."""


@dataclass(frozen=True, eq=False)
class BoardColumns:
    """Columns of a board's lines: its time, and the axes of one quantity."""

    time: int | None
    time_name: str
    guessed: bool  # since it has no name
    tick_s: float
    period_s: float | None  # typical step of the time
    places: tuple[int, ...]  # of the axes
    axes: tuple[str, ...]
    unit: str
    factors: NDArray[np.float64]  # to the unit, shape (axis, 1)
    notes: tuple[str, ...]

    def samples(self, row: Sequence[float]) -> NDArray[np.float64]:
        """Return the sample in a row, float64, shape (axis, 1), ``unit``."""
        return np.array([[row[place]] for place in self.places]) * self.factors


def columns_of(head: TableHead, rows: NDArray[np.float64], form: CsvFormat, *, place: Path) -> BoardColumns:
    """Return the columns of lines, by their headings and the first rows, float64, shape (row, column).

    A `DataError` that begins with ``place`` says what to state if there are two plausible readings; a `ParameterError`
    or `UnitError` that ``form`` does not fit the lines.
    """
    table = RawTable(place, head.headings, tuple(rows.T), units=head.units, named=head.named, brief=True)
    wanted = [name.strip() for name in form.axes.split(",")] if form.axes else None
    roles = roles_of(table, axes=wanted, time=form.time, rate=form.rate)
    stream, *others = roles.streams
    axes = stream.axes if head.named else default_axes(len(stream.axes))
    if form.axes and not stream.chosen:
        axes = axis_names(len(axes), form.axes, where=str(place))
    unit, factors = stream.unit or "1", stream.factors
    if form.unit is not None:
        unit, factor = parse_unit(form.unit)
        factors = (factor,) * len(axes)
    notes, steps = ["no column of time: only damaged lines are counted as lost"], np.zeros(0)
    if roles.time is not None:
        notes = [f"time from {head.headings[roles.time]}"] if head.named else []
        steps = np.diff(rows[:, roles.time]) * (roles.seconds or 1.0)
    listed = ", ".join(head.headings[i] for i in stream.places)
    notes += [*roles.notes, f"{', '.join(axes)} from {'' if head.named else 'column '}{listed}, unit {unit}"]
    if form.unit is None and (note := unit_note(stream, roles.uses, rows.T[[*stream.places]])):
        notes.append(note)
    for other in others:
        listed = ",".join(head.headings[i] for i in other.places)
        notes.append(
            f"left out: {listed} ({other.name.replace('_', ' ')}); `axes={listed}` reads them instead"
        )
    return BoardColumns(
        roles.time,
        head.headings[roles.time or 0],
        guessed=form.time is None and not head.named,
        tick_s=roles.seconds or 1.0,
        period_s=float(np.median(steps[steps > 0])) if (steps > 0).any() else None,
        places=stream.places,
        axes=axes,
        unit=unit,
        factors=form.scale * np.array(factors)[:, None],
        notes=tuple(notes),
    )


def since_reset(rows: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return the rows after the only step back in the first column: the board was reset, or its counter overflowed."""
    back = np.flatnonzero(np.diff(rows[:, 0]) < 0) if len(rows) else np.zeros(0, int)
    return rows[back[0] + 1 :] if len(back) == 1 and len(rows) - back[0] > 2 else rows
