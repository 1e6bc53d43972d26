"""Boards that print lines of numbers to a serial port: Arduino, Teensy and others."""

from __future__ import annotations

from pathlib import Path

from pydantic import Field

from tactogram.extras import imported
from tactogram_capture.source import SourceKind, required_place
from tactogram_capture.stream.byte_source import BAUD, SerialPort
from tactogram_capture.stream.csv_lines import CsvFormat
from tactogram_capture.stream.csv_source import CsvSource


class SerialOptions(CsvFormat):
    """Options of ``serial:PORT``: the format of the lines, and these."""

    baud: int = Field(default=BAUD, ge=300, le=12_000_000)
    log: Path | None = None
    """A new file for all bytes."""


def _open(place: str, options: SerialOptions, *, name: str) -> CsvSource:
    port = SerialPort(required_place(place, name, "the port"), options.baud)
    return CsvSource(port, options, name=name, log=options.log)


def _find(find_s: float) -> dict[str, str]:
    ports = imported("serial.tools.list_ports", extra="devices", what="sensors on a serial port")
    # A port does not tell whether a receiver or a board is connected; the description of a USB port helps.
    return {
        f"serial:{port.device}": port.description if port.description not in ("", "n/a") else "serial port"
        for port in ports.comports()
    }


SOURCE = SourceKind(
    "serial",
    "board on a serial port",
    "serial:/dev/ttyACM0?baud=115200",
    SerialOptions,
    _open,
    find=_find,
)
