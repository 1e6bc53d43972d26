"""Logs of receivers, boards and recorders, written to files or a store with their gaps."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any, Literal

from annotated_types import Ge

from tactogram.errors import DataError, ParameterError, Remedy
from tactogram.parameters import Settings, checked

if TYPE_CHECKING:
    from tactogram.signal import Signal
    from tactogram_capture.logs import SensorLog

    Extracted = tuple[SensorLog, dict[str, Any], list[tuple[int, Signal]]]
    """A sensor, the report on it, and its signals with their first index."""

LICENCE = "not stated: own recordings"
Seconds = Annotated[float, Ge(0)]


@checked
def capture_log(
    path: Path | str,
    *,
    out: Path | str | None = None,
    data: Path | str | None = None,
    material: str | None = None,
    speed_mm_s: float | None = None,
    force_n: float | None = None,
    contactor: str | None = None,
    kind: Literal["twelite", "serial"] | None = None,
    sender: str | None = None,
    rate: float | None = None,
    fill: bool = False,
    most_s: Seconds = 0.1,
    least_s: Seconds = 0.5,
    options: Settings | None = None,
) -> dict[str, Any]:
    """Import a sensor's log into files or a store, with its gaps; without either, only return its facts.

    The default is a signal for each piece between two gaps; ``fill`` makes one signal of all and reports how much of
    it was filled.

    Parameters
    ----------
    path : Path or str
        A log of a TWE-Lite receiver or a board, or an .xdf file.
    out : Path or str, optional
        A file, by suffix; several signals are numbered.
    data : Path or str, optional
        A store; created if it does not exist.
    material : str, optional
        Material touched (required with a store).
    speed_mm_s : float, optional
        Stroking speed, mm/s.
    force_n : float, optional
        Normal force, N.
    contactor : str, optional
        What touched it, e.g. finger or pen.
    kind : {"twelite", "serial"}, optional
        What wrote the log, where it is not evident.
    sender : str, optional
        Only the sensor of this serial number.
    rate : float, optional
        Nominal rate, Hz; needed where the log has no times. A measured rate that contradicts it is used instead.
    fill : bool
        Fill gaps by straight lines (default: one signal for each stretch between them).
    most_s : float
        Longest gap that is filled, s.
    least_s : float
        Omit shorter stretches, s.
    options : dict, optional
        For a board: time, unit, scale, axes, …; for XDF: unit; as KEY=VALUE.

    Returns
    -------
    dict
        ``path``, ``simulated``, ``sensors`` (for each: ``name``, ``axes``, ``unit``, ``samples``, ``seconds``, ``rate``
        (of the written signal), ``facts``, ``signals`` (``first_index``, ``samples``, ``file``), ``short`` (pieces left
        out), ``filled``), and ``data``, ``added``, ``recordings`` where a store was written.

    Raises
    ------
    DataError, ParameterError
        If the log is empty, its rate is not known, or a gap is longer than ``most_s``; nothing is written then.
    """
    from tactogram.signal import check_rate

    path = Path(path)
    if data is not None and not material:
        raise ParameterError("a recording in a store needs a material", remedy=Remedy("give", "material"))
    if rate is not None:
        check_rate(rate)
    logged = _read(path, kind, dict(options or {}))
    if sender is not None:
        # As printed on the sensor, or as in its frames and other sources' names.
        spellings = (sender, f"8{sender.upper()[-7:]}")
        names = ", ".join(log.name for log in logged)
        logged = [log for log in logged if log.name in spellings]
        if not logged:
            raise ParameterError.must("sender", f"be one of {names}", sender)
    extracted = [
        _extracted(log, path, rate, most_s=most_s if fill else None, least_s=least_s) for log in logged
    ]
    result: dict[str, Any] = {
        "path": str(path),
        "simulated": any(log.simulated for log in logged),
        "sensors": [report for _, report, _ in extracted],
    }
    if not any(signals for *_, signals in extracted) and (out is not None or data is not None):
        raise DataError(
            path, f"no piece between two gaps is {least_s:g} s long; fill them, or use shorter ones"
        )
    if out is not None:
        _write(Path(out), extracted, path)
    if data is not None:
        touched = {"material": material, "speed_mm_s": speed_mm_s, "force_n": force_n, "contactor": contactor}
        result |= _store(Path(data), extracted, path, touched)
    return result


def _read(path: Path, kind: Literal["twelite", "serial"] | None, options: dict[str, Any]) -> list[SensorLog]:
    from tactogram.validation import validated
    from tactogram_capture.logs import read_log, read_xdf
    from tactogram_capture.stream.csv_lines import CsvFormat

    if path.suffix.lower() == ".xdf":
        unit = options.pop("unit", None)
        if options:
            raise ParameterError(f"of an XDF file only its unit can be given, got {', '.join(options)}")
        return read_xdf(path, unit=unit)
    csv = validated(CsvFormat, options, where="options") if options else None
    return read_log(path, kind=kind, csv=csv)


def _extracted(
    log: SensorLog, path: Path, rate: float | None, *, most_s: float | None, least_s: float
) -> Extracted:
    """Return a sensor's signals: one with its gaps of up to ``most_s`` filled, else the pieces of ``least_s``."""
    from tactogram_capture.session.take import rate_of
    from tactogram_capture.stream.gaps import filled, gap_free

    hz = rate_of(None if log.rate is None else log.rate.facts(), rate)
    if hz is None:
        problem = f"has no times, or too few, to measure the rate of {log.name}"
        raise DataError(path, problem, remedy=Remedy("give", "rate"))
    how, short = None, 0
    if most_s is not None:
        signal, how = filled(log.samples, hz, log.unit, log.axes, most_s=most_s)
        signals = [(0, signal)]
    else:
        pieces = gap_free(log.samples, hz, log.unit, log.axes)
        signals = [(piece.first_index, piece.signal) for piece in pieces if piece.signal.seconds >= least_s]
        short = len(pieces) - len(signals)
    report: dict[str, Any] = {
        "name": log.name,
        "axes": list(log.axes),
        "unit": log.unit,
        "samples": log.samples.shape[1],
        "seconds": log.samples.shape[1] / hz,
        "rate": hz,
        "facts": log.facts,
        "short": short,
        "filled": how,
        "signals": [
            {"first_index": first, "samples": len(signal), "file": None} for first, signal in signals
        ],
    }
    return log, report, signals


def _write(out: Path, extracted: list[Extracted], path: Path) -> None:
    from tactogram.signal.io import write_signal

    several = sum(len(signals) for *_, signals in extracted) > 1
    number = 0
    for log, report, signals in extracted:
        for listed, (first, signal) in zip(report["signals"], signals, strict=True):
            number += 1
            target = out.with_name(f"{out.stem}-{number:03d}{out.suffix}") if several else out
            metadata = {
                "source": path.name,
                "sensor": log.name,
                "first_index": first,
                "filled": report["filled"],
                "simulated": log.simulated,
                **({"notes": notes} if (notes := log.facts.get("notes")) else {}),
            }
            write_signal(target, signal, metadata=metadata)
            listed["file"] = str(target)


def _store(data: Path, extracted: list[Extracted], path: Path, touched: dict[str, Any]) -> dict[str, Any]:
    from tactogram.datasets import Recording, add_recordings, create_store, open_store
    from tactogram_capture.session.take import STREAM_OF_UNIT

    recordings = [
        Recording(
            streams={STREAM_OF_UNIT.get(signal.unit, "signal"): signal},
            source=f"{path.name}#{log.name}@{first}",
            labels={"sensor": log.name},
            history=(
                "read from a log",
                *log.facts.get("notes", ()),
                f"{report['filled']['samples']} samples filled"
                if report["filled"]
                else "pieces between gaps",
            ),
            simulated=log.simulated,
            **touched,
        )
        for log, report, signals in extracted
        for first, signal in signals
    ]
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
