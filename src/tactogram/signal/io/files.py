"""Signals from files and into files, by suffix: .wav, .flac, .csv, .tsv, .txt (read only), .npz, .xlsx."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from tactogram.errors import DataError, ParameterError
from tactogram.signal.io import arrays, sound, table, worksheet
from tactogram.signal.io.atomic import atomic_write
from tactogram.signal.io.content import FileContent, assemble
from tactogram.signal.io.description import SignalDescription
from tactogram.signal.signal import Signal
from tactogram.signal.timing import SamplingTiming, estimate_timing

SOUND = (".wav", ".flac")
TABLES = (".csv", ".tsv", ".txt")
READABLE = (*SOUND, *TABLES, ".npz", ".xlsx")
WRITABLE = tuple(suffix for suffix in READABLE if suffix != ".txt")


def read_signal(
    path: str | Path,
    *,
    unit: str | None = None,
    axes: Sequence[str] | None = None,
    rate: float | None = None,
    columns: Sequence[str] | None = None,
    time: str | None = None,
    sheet: str | None = None,
    full_scale: float | None = None,
) -> Signal:
    """Return the signal in a file.

    What this package wrote needs no argument: rate, unit, level, axes and domain come back as they were. The arguments
    say what other files do not; one that contradicts the file is refused. A file that names no unit is
    taken as unit ``"1"``; a WAV then is in parts of full scale.

    A table or NPZ with time stamps is brought to even spacing (`tactogram.signal.timing.to_uniform`);
    `read_file` reports the jitter.

    Parameters
    ----------
    path : Path
        Its suffix, in any case, is one of `READABLE`.
    unit : str, optional
        Unit of the samples: one of `UNITS`, or one that is brought to them, such as ``"g"`` or ``"mm"``.
    axes : sequence of str, optional
        Names of the axes to read, where the file names them; else names for all that it has.
    rate : float, Hz, optional
        Of the samples. With time stamps, of the result (by default the estimated one).
    columns : sequence of str, optional
        Columns of a table, or arrays of an NPZ, to read; by default all but the time.
    time : str, optional
        Column or array of time stamps; by default one called time, t or timestamp, ``[s]``, ``[ms]``, ``_ms`` …
    sheet : str, optional
        Worksheet, where there are several.
    full_scale : float, optional
        What 1.0 in a WAV or FLAC stands for, in ``unit``.

    Raises
    ------
    DataError
        One line that names file and row or byte.
    ParameterError
        For a suffix that is none of these, or an argument that the format has no use for.
    """
    signal, _ = _read(
        _existing(path),
        unit=unit,
        axes=axes,
        rate=rate,
        columns=columns,
        time=time,
        sheet=sheet,
        full_scale=full_scale,
    )
    return signal


@dataclass(frozen=True, eq=False)
class SignalFile:
    """A signal, and what else its file says.

    Parameters
    ----------
    signal : Signal
    metadata : dict
        As `read_metadata`.
    timing : Timing, optional
        What its time stamps say; None if it has none, or this package wrote it.
    """

    signal: Signal
    metadata: dict[str, Any]
    timing: SamplingTiming | None


def read_file(path: str | Path, **options: Any) -> SignalFile:
    """Return the signal in a file with its metadata and timing; ``options`` and errors as `read_signal`."""
    path = _existing(path)
    signal, content = _read(path, **options)
    timing = None if content.times is None else estimate_timing(content.times)
    return SignalFile(signal, _metadata(content.description or content.comment), timing)


def read_metadata(path: str | Path) -> dict[str, Any]:
    """Return the metadata that was given to `write_signal`; of a foreign WAV or FLAC its ``comment``, else nothing.

    Raises
    ------
    DataError
        If the file is not what its suffix says.
    """
    path = _existing(path)
    found: SignalDescription | str | None
    match _suffix(path, READABLE):
        case ".wav" | ".flac":
            found = sound.describe(path)
        case ".npz":
            found = arrays.describe(path)
        case ".xlsx":
            found = worksheet.describe(path)
        case _:
            found = table.describe(path)
    return _metadata(found)


def write_signal(
    path: str | Path,
    signal: Signal,
    *,
    metadata: Mapping[str, Any] | None = None,
    subtype: str | None = None,
    full_scale: float | None = None,
) -> None:
    """Write a signal so that `read_signal` gives it back: level, unit, axes, domain and rate.

    Float samples (WAV's default, CSV, TSV, NPZ, XLSX) come back exactly. Integer ones come back within half a step of
    the full scale, which is the peak, or 1 for a signal of unit 1 that fits; it is never clipped.
    The file is written beside its place and then renamed: there is the whole file or none.

    Parameters
    ----------
    path : Path
        Its suffix is one of `WRITABLE`. The folder is made if it is not there.
    signal : Signal
    metadata : mapping from str to JSON values, optional
        Whatever else is known, such as ``{"simulated": True}``; `read_metadata` gives it back.
    subtype : str, optional
        Sample format of WAV (``"FLOAT"``, ``"DOUBLE"``, ``"PCM_U8"``, ``"PCM_16"``, ``"PCM_24"``, ``"PCM_32"``) or FLAC
        (``"PCM_24"``, ``"PCM_16"``, ``"PCM_S8"``); the first of each is the default.
    full_scale : float, optional
        What the largest integer stands for, in the signal's unit.

    Raises
    ------
    ParameterError
        If the format cannot hold the signal, or the metadata is not JSON.
    """
    path = Path(path)
    suffix = _suffix(path, WRITABLE)
    if suffix not in SOUND and (subtype is not None or full_scale is not None):
        raise ParameterError(f"subtype and full_scale are for {' and '.join(SOUND)}, got {suffix}")
    description = SignalDescription.of(signal, metadata)
    description.encode()
    with atomic_write(path) as part:
        match suffix:
            case ".wav" | ".flac":
                sound.write(part, signal, description, suffix=suffix, subtype=subtype, full_scale=full_scale)
            case ".npz":
                arrays.write(part, signal, description)
            case ".xlsx":
                worksheet.write(part, signal, description)
            case _:
                table.write(part, signal, description, suffix=suffix)


def _read(
    path: Path,
    *,
    unit: str | None = None,
    axes: Sequence[str] | None = None,
    rate: float | None = None,
    columns: Sequence[str] | None = None,
    time: str | None = None,
    sheet: str | None = None,
    full_scale: float | None = None,
) -> tuple[Signal, FileContent]:
    suffix = _suffix(path, READABLE)
    _refuse(suffix not in SOUND and full_scale is not None, "full_scale", suffix)
    _refuse(suffix in SOUND and (columns is not None or time is not None), "columns or time", suffix)
    _refuse(suffix != ".xlsx" and sheet is not None, "sheet", suffix)
    match suffix:
        case ".wav" | ".flac":
            content = sound.read(path, full_scale=full_scale)
        case ".npz":
            content = arrays.read(path, columns=columns, time=time)
        case ".xlsx":
            content = worksheet.read(path, columns=columns, axes=axes, time=time, sheet=sheet)
        case _:
            content = table.read(path, columns=columns, axes=axes, time=time)
    return assemble(content, path, unit=unit, axes=axes, rate=rate), content


def _metadata(found: SignalDescription | str | None) -> dict[str, Any]:
    if isinstance(found, str):
        return {"comment": found}
    return dict(found.metadata) if found else {}


def _refuse(useless: bool, name: str, suffix: str) -> None:
    if useless:
        raise ParameterError(f"{suffix} has no use for {name}; leave it out")


def _existing(path: str | Path) -> Path:
    path = Path(path)
    if not path.is_file():
        raise DataError(f"{path}: {'is a folder' if path.is_dir() else 'no such file'}")
    return path


def _suffix(path: Path, known: Sequence[str]) -> str:
    suffix = path.suffix.lower()
    if suffix not in known:
        raise ParameterError(f"{path}: suffix must be one of {', '.join(known)}, got {suffix or 'none'}")
    return suffix
