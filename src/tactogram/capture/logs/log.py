"""A log of a receiver or a board, read offline by the parser that reads live: the same bytes give the same samples."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import Any, Literal

import numpy as np
from numpy.typing import NDArray

from tactogram.capture.source import SourceEnded
from tactogram.capture.sources.serial_csv import CsvFormat, CsvSource
from tactogram.capture.sources.twelite import SensorTimelines, facts_of_bytes
from tactogram.capture.stream.byte_stream import Replay
from tactogram.capture.stream.rate_estimate import RateEstimate
from tactogram.capture.stream.raw_log import log_facts, log_pieces
from tactogram.capture.twelite.parser import TweliteParser
from tactogram.capture.twelite.sequence import TimelineSegment
from tactogram.errors import DataError

Kind = Literal["twelite", "serial"]

_SNIFFED = 1 << 18


@dataclass(frozen=True, eq=False)
class SensorLog:
    """Log of one sensor.

    Parameters
    ----------
    name : str
        Serial number of the sensor, or the name of the log.
    samples : float32 array, shape (axis, time), ``unit``
        NaN where lost. At least one sample.
    axes : tuple of str
    unit : str
    rate : RateEstimate or None
        Measured; None where the log has no times.
    start_s : float
        When the first packet arrived, by the log's clock; NaN where it has none.
    facts : dict
        As `Source.facts`.
    simulated : bool
    """

    name: str
    samples: NDArray[np.float32]
    axes: tuple[str, ...]
    unit: str
    rate: RateEstimate | None
    start_s: float
    facts: dict[str, Any]
    simulated: bool


def read_log(path: Path | str, *, kind: Kind | None = None, csv: CsvFormat | None = None) -> list[SensorLog]:
    """Return what every sensor left in a log, the one heard first in front.

    Parameters
    ----------
    path : Path
        Our own log (`RawLog`), or another program's text or bytes, with or without a time in front of each line.
    kind : {"twelite", "serial"}, optional
        By default what our own log says; of another's, ``"twelite"`` if a packet is found near its beginning.
    csv : CsvFormat, optional
        How the lines of a board are to be read.

    Raises
    ------
    DataError
        If it cannot be read, or holds no sample.
    """
    path = Path(path)
    facts = log_facts(path)
    simulated = bool((facts or {}).get("simulated"))
    kind = kind or kind_of(path)
    if kind == "serial":
        return [_read_csv(path, csv or CsvFormat(), simulated)]
    parser, senders = TweliteParser(), SensorTimelines()
    pieces: dict[str, list[TimelineSegment]] = {}
    starts: dict[str, float] = {}
    for data, arrival in log_pieces(path):
        _collect(pieces, starts, senders.add(parser.feed(data, arrival)))
    _collect(pieces, starts, senders.add(parser.finish()))
    senders.finish()
    if not any(pieces.values()):
        rejected = sum(parser.rejected.values())
        raise DataError(
            f"{path}: holds no packet of an acceleration sensor "
            f"({rejected} lines not understood, {sum(parser.other.values())} of something else)"
        )
    common = facts_of_bytes(parser) | {"simulated": simulated}
    return [
        SensorLog(
            name=name,
            samples=np.concatenate([piece.samples for piece in found], axis=1),
            axes=senders.timelines[name].axes,
            unit="m/s^2",
            rate=senders.timelines[name].estimate(),
            start_s=starts[name],
            facts=senders.timelines[name].facts() | common,
            simulated=simulated,
        )
        for name, found in pieces.items()
        if found
    ]


def kind_of(path: Path) -> Kind:
    """Return what wrote a log: our own ones say it, in others a packet near the beginning does."""
    facts = log_facts(path)
    if facts is not None:
        if facts.get("kind") not in ("twelite", "serial"):
            raise DataError(f"{path}, line 1: kind must be twelite or serial, got {facts.get('kind')!r}")
        return "twelite" if facts["kind"] == "twelite" else "serial"
    parser, seen = TweliteParser(), 0
    for data, arrival in log_pieces(path):
        if parser.feed(data, arrival) or parser.other:
            return "twelite"
        seen += len(data)
        if seen > _SNIFFED:
            return "serial"
    return "twelite" if parser.finish() or parser.other else "serial"


def _collect(
    pieces: dict[str, list[TimelineSegment]],
    starts: dict[str, float],
    added: dict[str, list[TimelineSegment]],
) -> None:
    for name, found in added.items():
        if found:
            starts.setdefault(name, found[0].arrival_s)
            pieces.setdefault(name, []).extend(found)


def _read_csv(path: Path, form: CsvFormat, simulated: bool) -> SensorLog:
    source = CsvSource(Replay(str(path), log_pieces(path)), form, name=f"log:{path}", simulated=simulated)
    blocks = []
    with source:
        try:
            while True:
                block = source.read(0.0)
                if block is not None:
                    blocks.append(block)
        except SourceEnded:
            pass
    if not blocks:
        raise DataError(f"{path}: holds no row of numbers ({source.parser.rejected_text()})")
    return SensorLog(
        name=path.stem,
        samples=np.concatenate([block.samples for block in blocks], axis=1),
        axes=source.axes,
        unit=source.unit,
        rate=source.estimate(),
        start_s=blocks[0].arrival_s,
        facts=source.facts(),
        simulated=simulated,
    )
