"""Logs of receivers, boards and recorders, written to files or a store with their gaps."""

from __future__ import annotations

from pathlib import Path
from typing import Any

from tactogram.datasets import Recording, add_recordings, create_store, open_store
from tactogram.errors import DataError, ParameterError
from tactogram.signal import Signal, check_rate
from tactogram.signal.io import write_signal
from tactogram.validation import validated
from tactogram.workflows import takes
from tactogram_capture import SensorLog, filled, gap_free, read_log, read_xdf
from tactogram_capture.logs import LogKind
from tactogram_capture.session.take import STREAM_OF_UNIT, rate_of
from tactogram_capture.stream.csv_lines import CsvFormat
from tactogram_capture.workflows.requests import LogRequest

LICENCE = "not stated: own recordings"


@takes(LogRequest)
def capture_log(request: LogRequest) -> dict[str, Any]:
    """Write a log's signals to files, or into a store; without either, only return its facts.

    Keys of the result: ``path``, ``simulated``, ``sensors`` (for each: ``name``, ``axes``, ``unit``, ``samples``,
    ``seconds``, ``rate`` (of the written signal), ``facts``, ``signals`` (``first_index``, ``samples``, ``file``),
    ``short`` (pieces left out), ``filled``), and ``data``, ``added``, ``recordings`` where a store was written.

    Raises `DataError` or `ParameterError` if the log is empty, its rate is not known, or a gap is longer than
    ``most_s``; nothing is written then.
    """
    path, data = Path(request.path), request.data
    if data is not None and not request.material:
        raise ParameterError("a recording in a store needs a material; give `material`")
    if request.rate is not None:
        check_rate(request.rate)
    logged = _read(path, request.kind, dict(request.options or {}))
    if request.sender is not None:
        # As printed on the sensor, or as in its frames and other sources' names.
        wanted = (request.sender, f"8{request.sender.upper()[-7:]}")
        names = ", ".join(one.name for one in logged)
        logged = [one for one in logged if one.name in wanted]
        if not logged:
            raise ParameterError(f"sender must be one of {names}, got {request.sender!r}")
    found = [_signals(one, path, request) for one in logged]
    result: dict[str, Any] = {
        "path": str(path),
        "simulated": any(one.simulated for one in logged),
        "sensors": [report for report, _ in found],
    }
    if not any(signals for _, signals in found) and (request.out is not None or data is not None):
        raise DataError(
            f"{path}: no piece between two gaps is {request.least_s:g} s long; fill them, or use shorter ones"
        )
    if request.out is not None:
        _write(Path(request.out), found, logged, path)
    if data is not None:
        result |= _store(Path(data), found, logged, request)
    return result


def _read(path: Path, kind: LogKind | None, options: dict[str, Any]) -> list[SensorLog]:
    if path.suffix.lower() == ".xdf":
        unit = options.pop("unit", None)
        if options:
            raise ParameterError(f"of an XDF file only its unit can be given, got {', '.join(options)}")
        return read_xdf(path, unit=unit)
    csv = validated(CsvFormat, options, where="options") if options else None
    return read_log(path, kind=kind, csv=csv)


def _signals(
    one: SensorLog, path: Path, request: LogRequest
) -> tuple[dict[str, Any], list[tuple[int, Signal]]]:
    """Return the report on one sensor, and its signals with their first index."""
    hz = rate_of(None if one.rate is None else one.rate.facts(), request.rate)
    if hz is None:
        raise DataError(f"{path}: has no times, or too few, to measure the rate of {one.name}; give `rate`")
    report: dict[str, Any] = {
        "name": one.name,
        "axes": list(one.axes),
        "unit": one.unit,
        "samples": one.samples.shape[1],
        "seconds": one.samples.shape[1] / hz,
        "rate": hz,
        "facts": one.facts,
        "short": 0,
        "filled": None,
    }
    if request.fill:
        signal, report["filled"] = filled(one.samples, hz, one.unit, one.axes, most_s=request.most_s)
        signals = [(0, signal)]
    else:
        pieces = gap_free(one.samples, hz, one.unit, one.axes)
        signals = [
            (piece.first_index, piece.signal) for piece in pieces if piece.signal.seconds >= request.least_s
        ]
        report["short"] = len(pieces) - len(signals)
    report["signals"] = [
        {"first_index": first, "samples": len(signal), "file": None} for first, signal in signals
    ]
    return report, signals


Found = list[tuple[dict[str, Any], list[tuple[int, Signal]]]]


def _write(out: Path, found: Found, logged: list[SensorLog], path: Path) -> None:
    several = sum(len(signals) for _, signals in found) > 1
    number = 0
    for (report, signals), one in zip(found, logged, strict=True):
        for place, (first, signal) in enumerate(signals):
            number += 1
            target = out.with_name(f"{out.stem}-{number:03d}{out.suffix}") if several else out
            metadata = {
                "source": path.name,
                "sensor": one.name,
                "first_index": first,
                "filled": report["filled"],
                "simulated": one.simulated,
                **({"notes": notes} if (notes := one.facts.get("notes")) else {}),
            }
            write_signal(target, signal, metadata=metadata)
            report["signals"][place]["file"] = str(target)


def _store(data: Path, found: Found, logged: list[SensorLog], request: LogRequest) -> dict[str, Any]:
    recordings, path = [], Path(request.path)
    for (report, signals), one in zip(found, logged, strict=True):
        how = report["filled"]
        done = "pieces between gaps" if how is None else f"{how['samples']} samples filled"
        for first, signal in signals:
            recordings.append(
                Recording(
                    streams={STREAM_OF_UNIT.get(signal.unit, "signal"): signal},
                    source=f"{path.name}#{one.name}@{first}",
                    labels={"sensor": one.name},
                    history=("read from a log", *one.facts.get("notes", ()), done),
                    simulated=one.simulated,
                    material=request.material,
                    speed_mm_s=request.speed_mm_s,
                    force_n=request.force_n,
                    contactor=request.contactor,
                )
            )
    before = len(open_store(data)) if data.exists() else 0
    if data.exists():
        store = add_recordings(open_store(data), recordings)
    else:
        store = create_store(data, recordings, name=data.name, licence=LICENCE, source=path.name)
    return {
        "data": str(data),
        "added": len(store) - before,
        "recordings": len(store),
        "sha256": store.sha256,
    }
