"""Signal files, by suffix."""

from __future__ import annotations

import logging
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from tactogram.errors import DataError, Message, ParameterError, TactogramError, remedies_of
from tactogram.signal.io import arrays, hdf5, labview, matlab, records, sound, table, worksheet
from tactogram.signal.io.archives import reason, unpacked
from tactogram.signal.io.atomic import atomic_write
from tactogram.signal.io.content import (
    IGNORED,
    UNCLEAR,
    ColumnUse,
    FileContent,
    RawTable,
    SignalDescription,
    TableLayout,
    assemble,
)
from tactogram.signal.io.numeric_rows import long_table
from tactogram.signal.io.roles import roles_of
from tactogram.signal.io.table_content import only_part, table_contents
from tactogram.signal.io.vocabulary import STREAM_OF_UNIT
from tactogram.signal.signal import Signal, signal_of
from tactogram.signal.timing import SamplingTiming, estimate_timing
from tactogram.text_files import check_regular, path_of

LOG = logging.getLogger("tactogram")
SOUND = (
    *(".wav", ".flac", ".aif", ".aiff", ".au", ".snd", ".caf", ".mp3", ".oga", ".ogg", ".opus"),
    *(".rf64", ".w64"),
)
TEXTS = (".csv", ".tsv", ".txt", ".dat", ".asc", ".log", ".tab")
PACKED = (".gz", ".bz2", ".xz", ".zip")
WORKBOOKS = (".xlsx", ".xlsm", ".xls", ".ods")
ARRAYS = (".npz", ".npy")
MATRICES = (".mat", ".h5", ".hdf5")
RECORDS = (".parquet", ".feather", ".arrow")
JSON_LINES = (".jsonl", ".ndjson")
TABLES = (*TEXTS, *ARRAYS, *WORKBOOKS, *MATRICES, ".lvm", ".tdms", *RECORDS, *JSON_LINES)
READABLE = (
    *SOUND,
    *TABLES,
    *(f"{text}{packed}" for text in (".csv", ".tsv", ".txt") for packed in PACKED[:-1]),
    ".zip",
)
"""Ends of the names of files that can be read, in lower case."""
USUAL = (
    ".wav, .flac, .csv, .txt, .xlsx, .mat, .npz, .h5, .lvm, .tdms, .parquet … (docs/table-files.md lists all)"
)
"""The ones that people are told."""
WRITABLE = (".wav", ".flac", ".csv", ".tsv", ".npz", ".xlsx")
ELSEWHERE = (".m4a", ".aac", ".wma", ".mp4")
"""Sounds of phones that libsndfile does not read."""
LONG_TEXT_BYTES = 2**26
"""Larger text tables are read in blocks, if their rows are plain numbers."""
MOST_TEXT_BYTES = 2**30
"""Largest other text table, unpacked."""


@dataclass(frozen=True, eq=False)
class SignalFile:
    """A signal with the metadata of its file, its time stamps (s) if it has any, and further streams beside it."""

    signal: Signal
    metadata: dict[str, Any]
    times: NDArray[np.float64] | None
    columns: tuple[ColumnUse, ...] = ()
    """What each column of a table, or array, was read as."""
    layout: TableLayout | None = None
    """The given layout that applied."""
    stream: str = "vibration"
    """Name of the quantity: acceleration, force, position, …"""
    others: Mapping[str, Signal] = field(default_factory=dict)
    """Further quantities of the same recording by stream."""
    notes: tuple[str, ...] = ()
    """What was left out or assumed, a line each."""

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
    time: str | None = None,
    sheet: str | None = None,
    layouts: Sequence[TableLayout] = (),
    full_scale: float | None = None,
    part: int | None = None,
) -> SignalFile:
    """Return the signal in a file, with metadata, timing and the further streams of a table.

    Files of this package need no argument: rate, unit, level, axes and domain come back as they were. Of other tables
    headings, units and values tell time stamps, counters, and which columns are the axes of which quantity
    (`tactogram.signal.io.roles`): one quantity is the signal, others with units are further streams, and the rest is
    named in ``notes``. The arguments complete what a file does not state; one that contradicts it is refused. Without a
    unit it is ``"1"``; a WAV is then in parts of full scale. A table with time stamps is resampled to even spacing
    (`tactogram.signal.timing.to_uniform`), which bridges up to three missing samples.

    Parameters
    ----------
    path : Path
        Its suffix, in any case, is one of `READABLE`.
    unit : str, optional
        Unit of the samples: one of `UNITS`, or one that is converted to them, such as ``"g"`` or ``"mm"``.
    axes : sequence of str, optional
        Axes, columns or arrays to read, if the file names any of them; else names for all its axes.
    rate : float, Hz, optional
        Of the samples. With time stamps, of the result (by default the estimated one).
    time : str, optional
        Column of time stamps, with its unit if the file states none (``"ticks [us]"``); ``"none"`` to use none.
    sheet : str, optional
        Worksheet, if there are several.
    layouts : sequence of TableLayout, optional
        What the columns of tables with certain headings hold; not for files of this package.
    full_scale : float, optional
        Value of 1.0 in a sound file, in ``unit``.
    part : int, optional
        Of a table with longer holes, or whose time goes back: which of the parts between, from 1.

    Raises
    ------
    DataError
        One line that names file and row or byte, and where two readings are plausible, what to choose.
    ParameterError
        For another suffix, or an argument that does not apply to the format.
    """
    path = _existing(path)
    contents = _contents(
        path,
        axes=axes,
        time=time,
        rate=rate,
        sheet=sheet,
        layouts=layouts,
        full_scale=full_scale,
    )
    try:
        first, *others = only_part(contents, part)
    except DataError as error:
        raise DataError(path, error) from None
    file = complete(first, path, unit=unit, axes=axes, rate=rate)
    streams: dict[str, Signal] = {}
    notes = [*file.notes]
    for content in others:
        try:
            other = complete(content, path, rate=rate)
        except TactogramError as error:
            notes.append(Message(error.message.within(path), place=f"{content.stream} left out"))
            continue
        if other.stream in (file.stream, *streams):
            left = ", ".join(use.heading for use in content.uses if use.role in content.axes)
            notes.append(f"left out: {left}, further {other.stream.replace('_', ' ')} at a rate of its own")
        else:
            streams[other.stream] = other.signal
    return replace(file, others=streams, notes=tuple(notes))


def read_contents(
    path: str | Path,
    *,
    axes: Sequence[str] | None = None,
    time: str | None = None,
    rate: float | None = None,
    layouts: Sequence[TableLayout] = (),
    labelled: bool = False,
) -> tuple[FileContent, ...]:
    """Return the streams in a file as `read_file` reads them, if ``labelled`` with the labels of a table's rows.

    They are for `complete`, before which `tactogram.signal.io.labels.cut` can take them apart.
    """
    return _contents(_existing(path), axes=axes, time=time, rate=rate, layouts=layouts, labelled=labelled)


def complete(
    content: FileContent,
    path: str | Path,
    *,
    unit: str | None = None,
    axes: Sequence[str] | None = None,
    rate: float | None = None,
) -> SignalFile:
    """Return the signal in one stream of a file; arguments and errors as `read_file`."""
    if rate is None and content.layout is not None:
        rate = content.layout.rate
    signal = assemble(content, Path(path), unit=unit, axes=None if content.chosen else axes, rate=rate)
    metadata = _metadata(content.description or content.comment)
    stream = content.stream if content.stream else STREAM_OF_UNIT[signal.unit]
    notes = tuple(
        note
        for note in content.notes
        if unit is None or not any(r.parameter == "unit" for r in remedies_of(note))
    )
    uses = _uses(content, signal.axes)
    return SignalFile(signal, metadata, content.times, uses, content.layout, stream, notes=notes)


def _contents(
    path: Path,
    *,
    sheet: str | None = None,
    full_scale: float | None = None,
    time: str | None = None,
    **how: Any,
) -> tuple[FileContent, ...]:
    suffix = _suffix(path, READABLE)
    for name, useless in (
        ("full_scale", suffix not in SOUND and full_scale is not None),
        ("time", suffix in SOUND and time is not None),
        ("sheet", suffix not in WORKBOOKS and sheet is not None),
    ):
        if useless:
            raise ParameterError(f"{name} does not apply to {suffix}; omit it")
    try:
        if suffix in SOUND:
            return (sound.read(path, full_scale=full_scale),)
        return table_contents(_tables(path, suffix, sheet), time=time, **how)
    except TactogramError:
        raise
    except Exception as error:  # whatever a reader trips over, the user needs the name of the file
        raise DataError(path, f"not readable{reason(error)}; save it as CSV") from error


def _tables(path: Path, suffix: str, sheet: str | None) -> list[RawTable]:
    """Return the tables in a file that is no sound, by the module of its format, which is imported when one is met."""
    if suffix in TEXTS:
        size = path.stat().st_size
        if size > LONG_TEXT_BYTES and (content := long_table(path, table.table_by_lines)) is not None:
            return [content]
        if size > MOST_TEXT_BYTES:
            raise DataError(
                path, f"must have at most {MOST_TEXT_BYTES >> 20} MiB, or nothing but rows of numbers; cut it"
            )
        return [table.text_table(path, path.read_bytes())]
    if suffix in PACKED:
        return [table.text_table(Path(name), raw) for name, raw in unpacked(path).items()]
    if suffix in WORKBOOKS:
        return worksheet.tables(path, sheet=sheet)
    if suffix in ARRAYS:
        return arrays.tables(path)
    if suffix in MATRICES:
        return matlab.tables(path) if suffix == ".mat" else hdf5.tables(path)
    if suffix in JSON_LINES:
        return records.json_tables(path)
    if suffix in (".lvm", ".tdms"):
        return (labview.lvm_tables if suffix == ".lvm" else labview.tdms_tables)(path)
    return records.tables(path)


def read_signal(path: str | Path, **options: Any) -> Signal:
    """Return the signal in a file; options and errors as `read_file`, whose notes become warnings of the log.

    >>> tactogram.read_signal("log.csv", unit="g", axes=("x", "y", "z"))   # doctest: +SKIP
    """
    file = read_file(path, **options)
    notes = [*file.notes, *([f"also holds {', '.join(file.others)}, not read"] if file.others else [])]
    for note in notes:
        LOG.warning("%s: %s", Path(path).name, note)
    return file.signal


def read_metadata(path: str | Path) -> dict[str, Any]:
    """Return the metadata of `write_signal`, or the ``comment`` of a foreign sound file; else nothing."""
    path = _existing(path)
    match _suffix(path, READABLE):
        case suffix if suffix in SOUND:
            return _metadata(sound.describe(path))
        case suffix if suffix in TEXTS:
            return _metadata(table.describe(path))
        case ".npz":
            return _metadata(arrays.describe(path))
        case ".xlsx":
            return _metadata(worksheet.describe(path))
        case _:
            return {}


def read_columns(path: str | Path, *, layouts: Sequence[TableLayout] = ()) -> tuple[ColumnUse, ...]:
    """Return the columns of a file that `read_file` cannot read; none of sounds.

    Their roles are those that headings and ``layouts`` suggest, or `UNCLEAR`. A `DataError` if there are no headings.
    """
    path = _existing(path)
    suffix = _suffix(path, READABLE)
    if suffix in SOUND:
        return ()
    uses: list[ColumnUse] = []
    for each in _tables(path, suffix, None):
        try:
            uses += roles_of(each, layouts=layouts, labelled=True).uses
        except DataError:
            uses += [ColumnUse(heading, UNCLEAR) for heading in each.headings]
    return tuple(uses)


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
        If it is no signal, the format cannot hold it, or the metadata is not JSON.

    Examples
    --------
    >>> import tempfile
    >>> with tempfile.TemporaryDirectory() as folder:
    ...     tactogram.write_signal(f"{folder}/tick.wav", tactogram.Signal([0, 1, -1, 0], 1000, "m/s^2"))
    ...     tactogram.read_signal(f"{folder}/tick.wav")
    <Signal: z in m/s^2, 0.004 s at 1000 Hz>
    """
    path, signal = path_of(path, "path"), signal_of(signal)
    suffix = _suffix(path, WRITABLE)
    if suffix not in SOUND and (subtype is not None or full_scale is not None):
        raise ParameterError(f"subtype and full_scale are for .wav and .flac, got {suffix}")
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
    path = path_of(path, "path")
    check_regular(path)
    return path


def _suffix(path: Path, known: Sequence[str]) -> str:
    suffix = path.suffix.lower()
    if suffix in ELSEWHERE:
        raise ParameterError(
            f"{path}: {suffix} is not read; convert it to .wav, e.g. `ffmpeg -i {path.name} {path.stem}.wav`"
        )
    if suffix in PACKED[:-1] and Path(path.stem).suffix.lower() in TEXTS and known is READABLE:
        return suffix
    if suffix not in known:
        told = USUAL if known is READABLE else ", ".join(known)
        raise ParameterError(f"{path}: suffix must be one of {told}, got {suffix or 'none'}")
    return suffix
