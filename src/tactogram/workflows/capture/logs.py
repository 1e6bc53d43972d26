"""Logs of receivers, boards and recorders, offline: into files or a store, with their gaps."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import Any, Literal, cast

from tactogram.capture import SensorLog, filled, gap_free, read_log, read_xdf
from tactogram.capture.logs.log import LogKind
from tactogram.capture.session.take import STREAM_OF_UNIT, rate_of
from tactogram.capture.stream.csv_source import CsvFormat
from tactogram.datasets import Recording, add_recordings, create_store, open_store
from tactogram.errors import DataError, ParameterError
from tactogram.signal import Signal
from tactogram.signal.io import write_signal
from tactogram.signal.signal import check_rate
from tactogram.validation import validated

LICENCE = "not stated: own recordings"


def capture_log(
    path: Path | str,
    *,
    out: Path | str | None = None,
    data: Path | str | None = None,
    kind: LogKind | None = None,
    sender: str | None = None,
    rate: float | None = None,
    fill: Literal["linear", "hold"] | None = None,
    most_s: float = 0.1,
    least_s: float = 0.5,
    options: Mapping[str, Any] | None = None,
    **known: Any,
) -> dict[str, Any]:
    """Read a log and write what is in it to files, or into a store; or only say what is in it.

    Where samples were lost, the default is a signal for every piece between two gaps; ``fill`` makes one signal of
    them all and reports how much of it was filled.

    Parameters
    ----------
    path : Path
        A log of a TWE-Lite receiver or a board (`tactogram.capture.read_log`), or an ``.xdf`` file.
    out : Path, optional
        A file in any format of `write_signal`; of several signals each gets a number behind the name.
    data : Path, optional
        A store; made if it is not there.
    kind : {"twelite", "serial"}, optional
        What wrote the log, where it does not show.
    sender : str, optional
        Only this sensor.
    rate : float, Hz, optional
        Nominal rate; needed where the log has no times. A measured one that contradicts it goes before it
        (`tactogram.capture.session.take.rate_of`).
    fill : {"linear", "hold"}, optional
    most_s : float
        Longest gap that is filled.
    least_s : float
        Shorter pieces are left out, and counted.
    options : mapping, optional
        How a board's lines are to be read: fields of `CsvFormat`; ``unit`` also for XDF.
    **known
        Fields of `Recording`: ``material``, ``speed_mm_s``, ``force_n``, ``contactor``, ``session``, ``subject``.

    Returns
    -------
    dict
        ``path``, ``simulated``, ``sensors`` (for each: ``name``, ``axes``, ``unit``, ``samples``, ``seconds``,
        ``rate`` (what it is written with), ``facts``, ``signals`` (``first_index``, ``samples``, ``file``), ``short``
        (pieces left out), ``filled``), and ``data``, ``added``, ``recordings`` where a store was written.

    Raises
    ------
    DataError, ParameterError
        If the log holds nothing, its rate is not known, or a gap is longer than ``most_s``; nothing is written then.
    """
    path = Path(path)
    if data is not None and not known.get("material"):
        raise ParameterError("a recording in a store needs a material; give --material")
    if rate is not None:
        check_rate(rate)
    logged = _read(path, kind, dict(options or {}))
    if sender is not None:
        # As it is printed on the sensor, or as its frames and other sources' names have it.
        wanted = (sender, f"8{sender.upper()[-7:]}")
        names = ", ".join(one.name for one in logged)
        logged = [one for one in logged if one.name in wanted]
        if not logged:
            raise ParameterError(f"sender must be one of {names}, got {sender!r}")
    found = [_signals(one, path, rate, fill, most_s, least_s) for one in logged]
    result: dict[str, Any] = {
        "path": str(path),
        "simulated": any(one.simulated for one in logged),
        "sensors": [report for report, _ in found],
    }
    if not any(signals for _, signals in found) and (out is not None or data is not None):
        raise DataError(
            f"{path}: no piece between two gaps is {least_s:g} s long; fill them, or take shorter ones"
        )
    if out is not None:
        _write(Path(out), found, logged, path)
    if data is not None:
        result |= _store(Path(data), found, logged, path, known)
    return result


def _read(path: Path, kind: LogKind | None, options: dict[str, Any]) -> list[SensorLog]:
    if path.suffix.lower() == ".xdf":
        unit = options.pop("unit", None)
        if options:
            raise ParameterError(f"of an XDF file only its unit can be said, got {', '.join(options)}")
        return read_xdf(path, unit=unit)
    csv = validated(CsvFormat, options, where="options") if options else None
    return read_log(path, kind=kind, csv=csv)


def _signals(
    one: SensorLog,
    path: Path,
    rate: float | None,
    fill: Literal["linear", "hold"] | None,
    most_s: float,
    least_s: float,
) -> tuple[dict[str, Any], list[tuple[int, Signal]]]:
    """Return what one sensor left: the report on it, and its signals with their places."""
    hz = rate_of(None if one.rate is None else one.rate.facts(), rate)
    if hz is None:
        raise DataError(f"{path}: has no times, or too few, to know the rate of {one.name} by; give --rate")
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
    if fill is not None:
        signal, how = filled(one.samples, hz, one.unit, one.axes, how=fill, most_s=most_s)
        signals = [(0, signal)]
        report["filled"] = how.facts()
    else:
        pieces = gap_free(one.samples, hz, one.unit, one.axes)
        signals = [(piece.first_index, piece.signal) for piece in pieces if piece.signal.seconds >= least_s]
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
            }
            write_signal(target, signal, metadata=metadata)
            report["signals"][place]["file"] = str(target)


def _store(
    data: Path, found: Found, logged: list[SensorLog], path: Path, known: Mapping[str, Any]
) -> dict[str, Any]:
    recordings = []
    for (report, signals), one in zip(found, logged, strict=True):
        how = report["filled"]
        done = "pieces between gaps" if how is None else f"{how['samples']} samples filled ({how['how']})"
        for first, signal in signals:
            recordings.append(
                Recording(
                    streams={STREAM_OF_UNIT.get(signal.unit, "signal"): signal},
                    source=f"{path.name}#{one.name}@{first}",
                    labels={"sensor": one.name},
                    history=("read from a log", done),
                    simulated=one.simulated,
                    **cast(Any, known),
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
