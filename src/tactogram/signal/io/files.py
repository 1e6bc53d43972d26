"""Signal files, by suffix: .wav, .flac, .csv, .tsv, .npz, .xlsx, and, read only, .txt, .mat, .lvm."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass, replace
from functools import cached_property
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from tactogram.errors import DataError, ParameterError
from tactogram.signal.io import arrays, labview, matlab, sound, table, worksheet
from tactogram.signal.io.atomic import atomic_write
from tactogram.signal.io.content import FileContent, assemble
from tactogram.signal.io.description import SignalDescription
from tactogram.signal.io.layout import IGNORED, UNCLEAR, ColumnUse, TableLayout
from tactogram.signal.signal import Signal
from tactogram.signal.timing import SamplingTiming, estimate_timing

SOUND = (".wav", ".flac")
TABLES = (".csv", ".tsv", ".txt")
READABLE = (*SOUND, *TABLES, ".npz", ".xlsx", ".mat", ".lvm")
WRITABLE = tuple(suffix for suffix in READABLE if suffix not in (".txt", ".mat", ".lvm"))


@dataclass(frozen=True, eq=False)
class SignalFile:
    """A signal with the metadata of its file, and its time stamps (s) if it has any."""

    signal: Signal
    metadata: dict[str, Any]
    times: NDArray[np.float64] | None
    columns: tuple[ColumnUse, ...] = ()
    """What each column of a table, or array of an NPZ, was read as."""
    layout: TableLayout | None = None
    """The given layout that applied."""

    @cached_property
    def timing(self) -> SamplingTiming | None:
        """Rate and jitter of the time stamps."""
        return None if self.times is None else estimate_timing(self.times)


def read_file(
    path: str | Path,
    *,
    unit: str | None = None,
    axes: Sequence[str] | None = None,
    rate: float | None = None,
    columns: Sequence[str] | None = None,
    time: str | None = None,
    sheet: str | None = None,
    layouts: Sequence[TableLayout] = (),
    full_scale: float | None = None,
) -> SignalFile:
    """Return the signal in a file, with metadata and timing.

    Files of this package need no argument: rate, unit, level, axes and domain come back as they were. The arguments
    complete other files; one that contradicts the file is refused. Without a unit it is ``"1"``; a WAV is then in parts
    of full scale. A table or NPZ with time stamps is resampled to even spacing (`tactogram.signal.timing.to_uniform`);
    `read_file` reports the jitter.

    Parameters
    ----------
    path : Path
        Its suffix, in any case, is one of `READABLE`.
    unit : str, optional
        Unit of the samples: one of `UNITS`, or one that is converted to them, such as ``"g"`` or ``"mm"``.
    axes : sequence of str, optional
        Axes to read, if the file names them; else names for all its axes.
    rate : float, Hz, optional
        Of the samples. With time stamps, of the result (by default the estimated one).
    columns : sequence of str, optional
        Columns of a table, or arrays of an NPZ, to read; by default all but the time.
    time : str, optional
        Column or array of time stamps; by default one called time, t or timestamp, ``[s]``, ``[ms]``, ``_ms`` …
    sheet : str, optional
        Worksheet, if there are several.
    layouts : sequence of TableLayout, optional
        What the columns of tables with certain headings hold; not for files of this package, or with ``columns``.
    full_scale : float, optional
        Value of 1.0 in a WAV or FLAC, in ``unit``.

    Raises
    ------
    DataError
        One line that names file and row or byte.
    ParameterError
        For another suffix, or an argument that does not apply to the format.
    """
    path = _existing(path)
    content = _content(
        path,
        columns=columns,
        axes=axes,
        time=time,
        sheet=sheet,
        layouts=layouts,
        full_scale=full_scale,
    )
    return complete(content, path, unit=unit, axes=axes, rate=rate)


def read_content(
    path: str | Path,
    *,
    axes: Sequence[str] | None = None,
    layouts: Sequence[TableLayout] = (),
    labelled: bool = False,
) -> FileContent:
    """Return the content of a file as `read_file` reads it, if ``labelled`` with the labels of a table's rows.

    It is for `complete`, or with labels for `tactogram.signal.io.labels.cut` before.
    """
    return _content(_existing(path), axes=axes, layouts=layouts, labelled=labelled)


def complete(
    content: FileContent,
    path: str | Path,
    *,
    unit: str | None = None,
    axes: Sequence[str] | None = None,
    rate: float | None = None,
) -> SignalFile:
    """Return the signal in the content of a file; arguments and errors as `read_file`."""
    if rate is None and content.layout is not None:
        rate = content.layout.rate
    signal = assemble(content, Path(path), unit=unit, axes=axes, rate=rate)
    metadata = _metadata(content.description or content.comment)
    return SignalFile(signal, metadata, content.times, _uses(content, signal.axes), content.layout)


def _content(
    path: Path,
    *,
    columns: Sequence[str] | None = None,
    axes: Sequence[str] | None = None,
    time: str | None = None,
    sheet: str | None = None,
    layouts: Sequence[TableLayout] = (),
    full_scale: float | None = None,
    labelled: bool = False,
) -> FileContent:
    suffix = _suffix(path, READABLE)
    for name, useless in (
        ("full_scale", suffix not in SOUND and full_scale is not None),
        ("columns or time", suffix in SOUND and (columns is not None or time is not None)),
        ("sheet", suffix != ".xlsx" and sheet is not None),
    ):
        if useless:
            raise ParameterError(f"{name} does not apply to {suffix}; omit it")
    match suffix:
        case ".wav" | ".flac":
            return sound.read(path, full_scale=full_scale)
        case ".npz":
            return arrays.read(path, columns=columns, time=time, layouts=layouts)
        case ".mat":
            return matlab.read(path, columns=columns, time=time, layouts=layouts)
        case ".lvm":
            return labview.read(
                path, columns=columns, axes=axes, time=time, layouts=layouts, labelled=labelled
            )
        case ".xlsx":
            return worksheet.read(
                path,
                columns=columns,
                axes=axes,
                time=time,
                sheet=sheet,
                layouts=layouts,
                labelled=labelled,
            )
        case _:
            return table.read(path, columns=columns, axes=axes, time=time, layouts=layouts, labelled=labelled)


def read_signal(path: str | Path, **options: Any) -> Signal:
    """Return the signal in a file; options and errors as `read_file`."""
    return read_file(path, **options).signal


def read_metadata(path: str | Path) -> dict[str, Any]:
    """Return the metadata of `write_signal`, or the ``comment`` of a foreign WAV or FLAC; else nothing."""
    path = _existing(path)
    match _suffix(path, READABLE):
        case ".wav" | ".flac":
            return _metadata(sound.describe(path))
        case ".npz":
            return _metadata(arrays.describe(path))
        case ".xlsx":
            return _metadata(worksheet.describe(path))
        case ".mat" | ".lvm":
            return {}
        case _:
            return _metadata(table.describe(path))


def read_columns(path: str | Path, *, layouts: Sequence[TableLayout] = ()) -> tuple[ColumnUse, ...]:
    """Return the columns of a table, or arrays of an NPZ, that `read_file` cannot read; none of other files.

    Their roles are those that headings and ``layouts`` suggest, or `UNCLEAR`. A `DataError` if there are no headings.
    """
    path = _existing(path)
    match _suffix(path, READABLE):
        case ".wav" | ".flac":
            return ()
        case ".npz":
            return arrays.array_uses(arrays.load_arrays(path), path)
        case ".mat":
            return arrays.array_uses(matlab.variables(path), path)
        case ".lvm":
            headings = labview.headings(path)
        case ".xlsx":
            headings = worksheet.headings(path)
        case _:
            headings = table.headings(path)
            with suppress(DataError):
                return table.uses(path, layouts)
    return tuple(ColumnUse(heading, UNCLEAR) for heading in headings)


def write_signal(
    path: str | Path,
    signal: Signal,
    *,
    metadata: Mapping[str, Any] | None = None,
    subtype: str | None = None,
    full_scale: float | None = None,
) -> None:
    """Write a signal so that `read_signal` returns it with level, unit, axes, domain and rate.

    Float samples (WAV's default, CSV, TSV, NPZ, XLSX) come back exactly. Integer ones come back within half a step of
    the full scale, which is the peak, or 1 for a signal of unit 1 that fits; it is never clipped. The file is written
    atomically.

    Parameters
    ----------
    path : Path
        Its suffix is one of `WRITABLE`. The folder is made if missing.
    signal : Signal
    metadata : mapping from str to JSON values, optional
        Further metadata, such as ``{"simulated": True}``, for `read_metadata`.
    subtype : str, optional
        Sample format of WAV (``"FLOAT"``, ``"DOUBLE"``, ``"PCM_U8"``, ``"PCM_16"``, ``"PCM_24"``, ``"PCM_32"``) or FLAC
        (``"PCM_24"``, ``"PCM_16"``, ``"PCM_S8"``); the first of each is the default.
    full_scale : float, optional
        Value of the largest integer, in the signal's unit.

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


def _metadata(description: SignalDescription | str | None) -> dict[str, Any]:
    if isinstance(description, str):
        return {"comment": description}
    return dict(description.metadata) if description else {}


def _uses(content: FileContent, axes: tuple[str, ...]) -> tuple[ColumnUse, ...]:
    """Return the uses of the columns, with the axes of the signal as they were selected or renamed."""
    names = [use.role for use in content.uses if use.role in content.axes]
    if set(axes) <= set(names):
        kept = dict(zip(axes, axes, strict=True))
        others = dict.fromkeys(names, IGNORED)
    else:
        kept, others = dict(zip(content.axes, axes, strict=False)), {}
    roles = others | kept
    return tuple(replace(use, role=roles.get(use.role, use.role)) for use in content.uses)


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
