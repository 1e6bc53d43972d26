"""Logs of receivers, boards and recorders.

Those of receivers and boards are read by the parser that reads live: the same bytes give the same samples. XDF files
are those of the recorders of Lab Streaming Layer.
"""

from __future__ import annotations

import logging
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Literal

import numpy as np
from numpy.typing import NDArray

from tactogram.errors import DataError, TactogramError, one_line
from tactogram.extras import imported
from tactogram.text_files import check_regular
from tactogram_capture.source import SourceEnded
from tactogram_capture.stream.byte_source import Replay
from tactogram_capture.stream.channels import described_axes, described_unit, split_at_gaps
from tactogram_capture.stream.csv_lines import CsvFormat
from tactogram_capture.stream.csv_source import CsvSource
from tactogram_capture.stream.rate_estimate import RateEstimate, estimate_rate
from tactogram_capture.stream.raw_log import log_facts, log_pieces
from tactogram_capture.twelite.messages import AXES
from tactogram_capture.twelite.parser import TweliteParser
from tactogram_capture.twelite.source import SensorTimelines, TimelineSegment, parser_facts

LogKind = Literal["twelite", "serial"]

_SEARCHED_BYTES = 1 << 18


@dataclass(frozen=True, eq=False)
class SensorLog:
    """Log of one sensor."""

    name: str
    """Serial number of the sensor, or the name of the log."""
    samples: NDArray[np.float32]
    """float32, shape (axis, time), ``unit``; NaN where lost. At least one sample."""
    axes: tuple[str, ...]
    unit: str
    rate: RateEstimate | None
    """Measured; None if the log has no times."""
    start_s: float
    """Arrival of the first packet, by the log's clock; NaN if it has none."""
    facts: dict[str, Any]
    """As `Source.facts`."""
    simulated: bool


def read_log(
    path: Path | str, *, kind: LogKind | None = None, csv: CsvFormat | None = None
) -> list[SensorLog]:
    """Return the samples of every sensor in a log, in the order in which they were first received.

    ``path``: our own log (`RawLog`), or another program's text or bytes, with or without a time in front of each line.
    ``kind``: by default that of our own log; for another program's, ``"twelite"`` if there is a packet near its
    beginning. ``csv``: format of a board's lines.

    Raises `DataError` if it is not readable, or contains no samples.
    """
    path = Path(path)
    simulated = bool((log_facts(path) or {}).get("simulated"))
    if (kind or log_kind(path)) == "serial":
        return [_read_csv(path, csv or CsvFormat(), simulated)]
    parser, senders = TweliteParser(), SensorTimelines()
    pieces: dict[str, list[TimelineSegment]] = {}
    for data, arrival in log_pieces(path):
        _collect(pieces, senders.add(parser.feed(data, arrival)))
    _collect(pieces, senders.add(parser.finish()))
    senders.finish()
    if not pieces:
        rejected = sum(parser.rejected.values())
        raise DataError(
            path,
            f"contains no packet of an acceleration sensor "
            f"({rejected} unreadable lines, {sum(parser.other.values())} of other devices)",
        )
    common = parser_facts(parser) | {"simulated": simulated}
    return [
        SensorLog(
            name=name,
            samples=np.concatenate([segment.samples for segment in segments], axis=1),
            axes=AXES,
            unit="m/s^2",
            rate=senders.timelines[name].estimate(),
            start_s=segments[0].arrival_s,
            facts=senders.timelines[name].facts() | common,
            simulated=simulated,
        )
        for name, segments in pieces.items()
    ]


def log_kind(path: Path) -> LogKind:
    """Return the kind of device that wrote a log: named in our own logs, else detected by a packet near the start."""
    facts = log_facts(path)
    if facts is not None:
        if facts.get("kind") not in ("twelite", "serial"):
            raise DataError(f"{path}, line 1: kind must be twelite or serial, got {facts.get('kind')!r}")
        return "twelite" if facts["kind"] == "twelite" else "serial"
    parser, searched = TweliteParser(), 0
    for data, arrival in log_pieces(path):
        if parser.feed(data, arrival) or parser.other:
            return "twelite"
        searched += len(data)
        if searched > _SEARCHED_BYTES:
            return "serial"
    return "twelite" if parser.finish() or parser.other else "serial"


def _collect(pieces: dict[str, list[TimelineSegment]], added: dict[str, list[TimelineSegment]]) -> None:
    for name, segments in added.items():
        if segments:
            pieces.setdefault(name, []).extend(segments)


def _read_csv(path: Path, form: CsvFormat, simulated: bool) -> SensorLog:
    source = CsvSource(Replay(str(path), log_pieces(path)), form, name=str(path), simulated=simulated)
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
        raise DataError(path, f"contains no row of numbers ({source.parser.rejected_text()})")
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


def read_xdf(path: Path | str, *, unit: str | None = None) -> list[SensorLog]:
    """Return every numeric stream in an XDF file, in file order.

    Clocks are synchronised by the format's own reader. Its smoothing of time stamps is not used: it fits
    one line across gaps of up to 5 s at 100 Hz. Where stamps jump (`stream.channels.split_at_gaps`), NaN takes the
    place of the missing samples.

    ``unit``: unit of the samples; by default the stream's own, or 1.

    Raises `MissingExtraError` if pyxdf is not installed; `DataError` if it is not readable as XDF, or contains no
    numbers.
    """
    pyxdf = imported("pyxdf", extra="lsl", what="XDF files")
    path = Path(path)
    try:
        check_regular(path)
        with path.open("rb") as file, _captured_warnings() as warnings:
            streams, _ = pyxdf.load_xdf(file, dejitter_timestamps=False, verbose=False)
        logs = [log for stream in streams if (log := _sensor_log(stream, unit, warnings)) is not None]
    except TactogramError:
        raise
    except Exception as error:  # pyxdf has no error of its own for damaged files
        raise DataError(path, f"not readable as XDF ({one_line(error)})") from error
    if not logs:
        raise DataError(path, "contains no stream of numbers")
    return logs


@contextmanager
def _captured_warnings() -> Iterator[list[str]]:
    """Collect pyxdf's log messages instead of printing them."""
    logger, lines = logging.getLogger("pyxdf"), list[str]()
    handler = logging.Handler(logging.WARNING)
    handler.emit = lambda record: lines.append(record.getMessage())  # type: ignore[method-assign]
    propagate, logger.propagate = logger.propagate, False
    logger.addHandler(handler)
    try:
        yield lines
    finally:
        logger.removeHandler(handler)
        logger.propagate = propagate


def _sensor_log(stream: dict[str, Any], unit: str | None, warnings: list[str]) -> SensorLog | None:
    info = stream["info"]
    rows, stamps = stream["time_series"], np.asarray(stream["time_stamps"], np.float64)
    if not isinstance(rows, np.ndarray) or rows.ndim != 2 or rows.dtype.kind not in "fiu" or not len(rows):
        return None
    labels, units = _channels(info, rows.shape[1])
    unit, factor = described_unit(unit, units)
    samples = (rows.T.astype(np.float64) * factor).astype(np.float32)
    rate = float(info["nominal_srate"][0])
    whole = np.concatenate(split_at_gaps(samples, stamps, rate or None, None), axis=1)
    # Positions of the received samples, missing ones counted.
    places = (
        np.flatnonzero(~np.isnan(whole[0])) + 1 if np.isfinite(samples).all() else np.arange(1, len(rows) + 1)
    )
    estimate = estimate_rate(places, stamps)
    facts = {
        "samples": len(rows),
        "lost": whole.shape[1] - len(rows),
        "rejected": {},
        "rate": None if estimate is None else estimate.facts(),
        "nominal_rate": rate or None,
        "simulated": False,
        **({"damaged": warnings} if warnings else {}),
    }
    return SensorLog(
        name=str(info["name"][0]),
        samples=whole,
        axes=described_axes(rows.shape[1], labels),
        unit=unit,
        rate=estimate,
        start_s=float(stamps[0]),
        facts=facts,
        simulated=False,
    )


def _channels(info: dict[str, Any], count: int) -> tuple[list[str], list[str]]:
    try:
        channels = info["desc"][0]["channels"][0]["channel"]
        labels = [str(channel["label"][0]) for channel in channels]
        units = [str((channel.get("unit") or [""])[0] or "") for channel in channels]
    except (KeyError, IndexError, TypeError):
        return [], []
    return (labels, units) if len(labels) == count else ([], [])
