"""Columns of a board's lines, by the rules that hold for the tables in files."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray
from pydantic import BaseModel, ConfigDict, Field

from tactogram.capture.stream.channels import axis_names
from tactogram.signal.io.content import default_axes
from tactogram.signal.io.raw_table import RawTable
from tactogram.signal.io.roles import roles_of
from tactogram.signal.io.table_content import unit_note
from tactogram.signal.io.table_head import TableHead
from tactogram.signal.units import parse_unit

FIRST_ROWS = 32
"""Rows from which the columns, and the nominal rate if none is given, are learnt."""


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
    tick_s: float
    places: tuple[int, ...]
    axes: tuple[str, ...]
    unit: str
    factors: NDArray[np.float64]
    """To the unit, float64, shape (axis, 1)."""
    period_s: float | None
    """Typical step of the time."""
    named: bool
    """Whether there is a heading."""
    notes: tuple[str, ...]
    """One line each: which column is the time, what is left out, a missing unit."""


def columns_of(head: TableHead, rows: NDArray[np.float64], form: CsvFormat, *, place: str) -> BoardColumns:
    """Return the columns of lines of numbers.

    Parameters
    ----------
    head : TableHead
        Their headings.
    rows : float64 array, shape (row, column)
        The first ones, see `since_reset`.
    form : CsvFormat
        What is known of them.
    place : str
        Where they come from, for errors.

    Raises
    ------
    DataError
        If the columns have two plausible readings; it ends with what to state.
    ParameterError, UnitError
        If what is stated does not fit the lines.
    """
    table = RawTable(
        Path(place), head.headings, tuple(rows.T), units=head.units, named=head.named, brief=True
    )
    wanted = [name.strip() for name in form.axes.split(",")] if form.axes else None
    roles = roles_of(table, axes=wanted, time=form.time, rate=form.rate)
    stream, *others = roles.streams
    axes = stream.axes if head.named else default_axes(len(stream.axes))
    if form.axes and not stream.chosen:
        axes = axis_names(len(axes), form.axes, where=place)
    unit, factors = stream.unit or "1", stream.factors
    if form.unit is not None:
        unit, factor = parse_unit(form.unit)
        factors = (factor,) * len(axes)
    period, name = None, ""
    names = [text if head.named and text else f"column {i}" for i, text in enumerate(head.headings, 1)]
    notes = ["no column of time: only damaged lines are counted as lost"]
    if roles.time is not None:
        name, steps = names[roles.time], np.diff(rows[:, roles.time]) * (roles.seconds or 1.0)
        period = float(np.median(steps[steps > 0])) if (steps > 0).any() else None
        notes = [f"time from {name}"] if head.named else []
    notes += [*roles.notes, f"{', '.join(axes)} in {unit} from {', '.join(names[i] for i in stream.places)}"]
    if form.unit is None and (note := unit_note(stream, roles.uses, rows.T[[*stream.places]])):
        notes.append(note)
    for other in others:
        listed = ",".join(head.headings[i] for i in other.places)
        notes.append(
            f"left out: {listed} ({other.name.replace('_', ' ')}); `axes={listed}` reads them instead"
        )
    return BoardColumns(
        time=roles.time,
        time_name=head.headings[roles.time or 0],
        tick_s=roles.seconds or 1.0,
        places=stream.places,
        axes=axes,
        unit=unit,
        factors=form.scale * np.array(factors)[:, None],
        period_s=period,
        named=head.named,
        notes=tuple(notes),
    )


def since_reset(rows: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return the rows after the only step back in the first column: the board was reset, or its counter overflowed."""
    back = np.flatnonzero(np.diff(rows[:, 0]) < 0) if len(rows) else np.zeros(0, int)
    return rows[back[0] + 1 :] if len(back) == 1 and len(rows) - back[0] > 2 else rows
