"""Options for reading a signal file."""

from dataclasses import dataclass
from typing import Annotated, Any

from tactogram.workflows.request import Option, Request


@dataclass(frozen=True, kw_only=True)
class SignalOptions(Request):
    """Facts that a signal file may omit, and choices where it holds more than one signal."""

    unit: Annotated[
        str | None, Option("unit of the samples, where the file does not state it: m/s^2, g, N, mm, V, 1, …")
    ] = None
    rate: Annotated[float | None, Option("sampling rate, where the file does not state it", "HZ")] = None
    axes: Annotated[tuple[str, ...] | None, Option("columns or channels to read, e.g. x,y,z")] = None
    time: Annotated[
        str | None, Option("column of the time stamps, e.g. 'ticks [us]'; none to use none", "COLUMN")
    ] = None
    sheet: Annotated[str | None, Option("sheet of a workbook, if it has several")] = None
    part: Annotated[int | None, Option("part of a table that is interrupted, from 1", "N", least=1)] = None

    @property
    def reading(self) -> dict[str, Any]:
        """Keyword arguments of `read_signal`."""
        return {name: getattr(self, name) for name in ("unit", "rate", "axes", "time", "sheet", "part")}
