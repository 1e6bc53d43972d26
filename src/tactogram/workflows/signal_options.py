"""Options for reading a signal file."""

from dataclasses import dataclass
from typing import Annotated, Any

from tactogram.workflows.request import Option, Request


@dataclass(frozen=True, kw_only=True)
class SignalOptions(Request):
    """Facts that a signal file may omit."""

    unit: Annotated[
        str | None, Option("unit of the samples, where the file does not state it: m/s^2, m/s, m, N, V or 1")
    ] = None
    rate: Annotated[float | None, Option("sampling rate, where the file does not state it", "HZ")] = None
    axes: Annotated[tuple[str, ...] | None, Option("columns or channels to read, e.g. x,y,z")] = None

    @property
    def reading(self) -> dict[str, Any]:
        """Keyword arguments of `read_signal`."""
        return {"unit": self.unit, "rate": self.rate, "axes": self.axes}
