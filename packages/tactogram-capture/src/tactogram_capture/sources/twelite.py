"""TWE-Lite receivers on a serial port."""

from __future__ import annotations

from pathlib import Path

from pydantic import Field

from tactogram.validation import FrozenModel
from tactogram_capture.source import SourceKind, required_place
from tactogram_capture.stream.byte_source import BAUD, SerialPort
from tactogram_capture.twelite.source import TweliteSource


class TweliteOptions(FrozenModel):
    """Options of ``twelite:PORT``."""

    baud: int = Field(default=BAUD, ge=300, le=12_000_000)
    sender: str | None = None
    """Serial number of the sensor; by default the first one received."""
    rate: float | None = Field(default=None, gt=0, allow_inf_nan=False)
    """Nominal rate, Hz; the measured rate is reported with it."""
    scale: float = Field(default=1.0, gt=0, allow_inf_nan=False)
    """Factor of the samples; 0.9765625 follows the sensor's data sheet instead of its firmware."""
    log: Path | None = None
    """A new file for all bytes."""


def _open(place: str, options: TweliteOptions, *, name: str) -> TweliteSource:
    port = SerialPort(required_place(place, name, "the port"), options.baud)
    return TweliteSource(
        port, name=name, sender=options.sender, rate=options.rate, scale=options.scale, log=options.log
    )


SOURCE = SourceKind("twelite", "TWE-Lite receiver", "twelite:/dev/ttyUSB0", TweliteOptions, _open)
