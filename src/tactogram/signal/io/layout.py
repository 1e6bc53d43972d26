"""Layout of a table: what its columns hold, read from the headings or stated by the user."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Annotated, Self

from pydantic import BaseModel, ConfigDict, Field, model_validator

from tactogram.errors import UnitError
from tactogram.signal.signal import RATES
from tactogram.signal.units import parse_seconds, parse_unit

TIME, RATE, IGNORED, UNCLEAR = "time", "rate", "ignored", "unclear"
LABELS = MATERIAL, SESSION, SUBJECT, TRIAL = "material", "session", "subject", "trial"
"""Roles of columns of words or codes."""


@dataclass(frozen=True)
class ColumnUse:
    """One column and what it is read as."""

    heading: str
    role: str  # name of the axis, or one of those above
    unit: str | None = None  # as the heading or the layout spells it
    stream: str | None = None  # of an axis of another stream than the signal's
    reason: str | None = None  # what an ignored column is, or why it is left out


class TableLayout(BaseModel):
    """Contents of the columns of a table, whatever their headings suggest."""

    model_config = ConfigDict(frozen=True, extra="forbid", use_attribute_docstrings=True)

    columns: Annotated[tuple[str, ...], Field(min_length=1)]
    """All headings of the tables to which it applies, in order (``"1"``, ``"2"``, … of a table without any), or the
    names of all arrays in an NPZ or MAT file (``"data:1"``, ``"data:2"``, … for the columns of a matrix)."""
    axes: dict[str, str] = {}
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
