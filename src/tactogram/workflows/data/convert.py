"""Conversion between file formats, of signals and of haptic files, one file or a folder."""

from __future__ import annotations

import mimetypes
import re
from collections import Counter
from contextlib import suppress
from dataclasses import asdict, dataclass, replace
from pathlib import Path
from typing import Any

from tactogram.errors import DataError, ParameterError, TactogramError
from tactogram.rendering.displays.catalogue import open_display
from tactogram.rendering.drive.axes import to_one_axis
from tactogram.rendering.files.analysis import READ_RATE
from tactogram.rendering.files.catalogue import format_for, haptic_formats, haptic_suffixes
from tactogram.rendering.files.conversion import write_haptic
from tactogram.rendering.files.reading import HapticFile, check_file, read_haptic
from tactogram.rendering.photo_relief import SPEED_MM_S, WIDTH_MM, photo_to_touch
from tactogram.rendering.sound_map import sound_to_touch
from tactogram.signal import Signal
from tactogram.signal.displacement import played
from tactogram.signal.io import (
    READABLE,
    WRITABLE,
    SignalFile,
    read_columns,
    read_file,
    read_image,
    read_image_metadata,
    write_signal,
)
from tactogram.signal.io.atomic import check_writable
from tactogram.signal.io.content import ColumnUse
from tactogram.signal.resampling import resample
from tactogram.workflows.data.requests import ConversionRequest
from tactogram.workflows.progress import ProgressCallback, silent
from tactogram.workflows.request import takes

SIGNAL_FORMATS = tuple(suffix.removeprefix(".") for suffix in WRITABLE)
"""Formats of signals by name, in addition to `haptic_formats`."""


@takes(ConversionRequest)
def convert(request: ConversionRequest) -> dict[str, Any]:
    """Write a signal in the format of the target's suffix, with its metadata.

    Haptic files (`tactogram.rendering.files`) are read and written, too. They hold parts of full scale, mostly events
    instead of samples: the scale and the loss are in the result, and in the file. From one of them to another events
    remain events; ``resample_to``, ``map`` and ``play_at`` make a waveform of them first.

    Returns
    -------
    dict
        ``source``, ``target``, ``samples``, ``rate_hz`` (``rate_per_mm`` over displacement), ``unit``, ``axes``,
        ``rms`` (in ``unit``), ``timing`` (of the time stamps in ``source``, see
        `signal.timing.SamplingTiming`; None if there are none), ``metadata``; ``reduced_by`` where axes became one;
        ``mapped`` of a sound (facts of `sound_to_touch`) or a photograph (``by`` "relief", ``width_mm``,
        ``speed_mm_s``); ``read`` of a haptic source (its facts), ``written`` of a haptic target (as `write_haptic`);
        ``notes`` on what of a table was left out or assumed, and on rules that a haptic source breaks.

    Raises
    ------
    DataError, ParameterError
        As `read_signal`, `write_signal`, `read_haptic` and `write_haptic`; nothing is written then.
    """
    source, target = Path(request.source), Path(request.target)
    designed = source.suffix.lower() in haptic_suffixes()  # with what a format of ours cannot keep
    if designed and source.exists() and target.exists() and source.samefile(target):
        raise ParameterError(f"{target} would overwrite its source; choose another target")
    photograph = (mimetypes.guess_type(source.name)[0] or "").startswith("image/")
    kind = format_for(target, _haptic_name(request.format, target))
    known = (*WRITABLE, *haptic_suffixes())
    if kind is None and target.suffix.lower() not in known:
        raise ParameterError(
            f"{target}: suffix must be one of {', '.join(known)}, got {target.suffix or 'none'}"
        )
    if kind is not None and request.subtype is not None:
        raise ParameterError(f"`subtype` is of WAV and FLAC; {kind.title} has none")
    if kind is None and request.display is not None:
        raise ParameterError(f"`display` is for patterns of on and off, {target.name} is none; omit it")
    reading = request.reading
    if kind is None:
        reading["full_scale"] = request.full_scale
    given = _drawn(source, request, reading) if photograph else _over_time(source, request, reading)
    signal, how, mapped = given.signal, given.reduced_by, given.mapped
    metadata = given.metadata
    metadata |= {"played_at_mm_s": request.play_at} if request.play_at is not None else {}
    metadata |= {"mapped": mapped} if mapped is not None else {}
    # A mapped sound or photograph has one axis, whatever it is called.
    axis = request.axis if mapped is None else None
    written = None
    if kind is not None:
        # Several channels are events of one only where the target holds no more.
        whole = len(signal.axes) == 1 or (axis is None and kind.holds != "waveform")
        written = write_haptic(
            target,
            given.events if given.events is not None and whole else signal,
            format=kind.name,
            axis=axis,
            full_scale=request.full_scale,
            modality=request.modality,
            motor=None if request.display is None else open_display(request.display),
            metadata=metadata,
        )
        how = how or written["reduced_by"]
    else:
        if request.modality is not None:
            raise ParameterError(f"`modality` is for haptic formats, {target.name} is none; omit it")
        if axis is not None:
            signal, how = to_one_axis(signal, axis)
        write_signal(target, signal, metadata=metadata, subtype=request.subtype)
    facts = {
        "source": str(source),
        "target": str(target),
        "samples": len(signal),
        "rate_hz" if signal.domain == "time" else "rate_per_mm": signal.rate,
        "unit": signal.unit,
        "axes": list(signal.axes),
        "rms": float((signal.samples.astype(float) ** 2).mean() ** 0.5),
        "timing": given.timing,
        "metadata": metadata,
    }
    optional: dict[str, Any] = {"reduced_by": how, "mapped": mapped, "read": given.read, "written": written}
    optional["notes"] = list(given.notes) or None
    return facts | {name: value for name, value in optional.items() if value is not None}


def convert_folder(
    source: Path | str,
    target: Path | str,
    *,
    format: str,
    progress: ProgressCallback = silent,
    **options: Any,
) -> dict[str, Any]:
    """Convert every readable file of a folder, and of the folders in it; ``options`` are those of `convert`.

    ``target`` gets the same names with the suffix of ``format``: a suffix of `WRITABLE` without its dot, or a haptic
    format.

    Returns
    -------
    dict
        ``source``, ``target``, ``format``, ``files`` (as `convert`, each), ``failed`` (the error by file; the others
        are written), ``notes`` (names of ``.txt`` files without a table of numbers, skipped), ``left_out`` (number of
        files of no known format), ``beside`` (the converted haptic file by each file beside it, of the same name,
        which is not converted: the signal of a design, or the design in another format than ``format``).

    Raises
    ------
    DataError
        If nothing there can be read.
    ParameterError
        If there is no such format, two signals would become one, a file in ``source`` would be overwritten, or
        ``target`` cannot be written to.
    """
    source, target = Path(source), Path(target)
    suffix = _suffix_of(format)
    present = sorted(p for p in source.rglob("*") if p.is_file() and not p.name.startswith("."))
    if target.resolve() != source.resolve():
        present = [p for p in present if not p.resolve().is_relative_to(target.resolve())]
    suffixes = (*READABLE, *haptic_suffixes())
    paths = [p for p in present if p.name.lower().endswith(suffixes)]
    unreadable = DataError(f"{source}: no file in it can be read; known are {', '.join(suffixes)}")
    if not paths:
        raise unreadable
    made: dict[Path, Path] = {}
    beside: dict[str, str] = {}
    haptic = haptic_suffixes()
    suffix_of = {path: path.suffix.lower() for path in paths}
    for path in sorted(paths, key=lambda path: (suffix_of[path] not in haptic, suffix_of[path] != suffix)):
        place = (target / path.relative_to(source)).with_suffix(suffix)
        first = made.setdefault(place, path)
        if first is path:
            continue
        if suffix_of[first] not in haptic:
            raise ParameterError(f"{first} and {path} would both become {place}; rename one")
        beside[str(path)] = str(first)
    for place in made.keys() & set(present):
        raise ParameterError(f"{place} would be overwritten; choose another folder than that of the sources")
    check_writable(target, folder=True)
    files, failed, notes = [], {}, []
    for done, (place, path) in enumerate(made.items()):
        progress("files", done, len(made), path.name)
        try:
            files.append(convert(path, place, format=format, **options))
        except TactogramError as error:
            if path.suffix.lower() == ".txt" and _is_note(path):
                notes.append(str(path))
            else:
                failed[str(path)] = str(error)
    progress("files", len(made), len(made))
    if not files and not failed:
        raise unreadable
    return {
        "source": str(source),
        "target": str(target),
        "format": format,
        "files": files,
        "failed": failed,
        "notes": notes,
        "left_out": len(present) - len(paths),
        "beside": beside,
    }


def _is_note(path: Path) -> bool:
    """Return whether a text has no line of numbers alone, and no three lines that differ only in their numbers."""
    with path.open("rb") as file:
        lines = file.read(1 << 16).replace(b"\0", b"").decode("latin-1").splitlines()
    shapes = Counter(re.sub(r"\d[\d.,]*", "0", line).strip() for line in lines)
    numbered = {shape: count for shape, count in shapes.items() if "0" in shape}
    alone = any(re.fullmatch(r"[0\s,;:|/eE+-]+", shape) for shape in numbered)
    return any(shapes) and not alone and max(numbered.values(), default=0) < 3


def list_formats() -> dict[str, dict[str, str]]:
    """Return every format by name: ``title``, ``suffix``, and what it ``holds``."""
    haptic = {
        name: {"title": kind.title, "suffix": kind.suffix, "holds": kind.holds}
        for name, kind in haptic_formats().items()
    }
    return haptic | {
        name: {"title": "", "suffix": f".{name}", "holds": "waveform"} for name in SIGNAL_FORMATS
    }


def check(path: Path | str, *, format: str | None = None, **reading: Any) -> dict[str, Any]:
    """Validate a file; return ``file``, ``format``, ``valid``, ``problems`` (a line each).

    Of haptic files `tactogram.rendering.files.check_file` lists all problems; of others, read as `read_file` does with
    the same arguments, only the first is found, and the result also has ``columns`` of a table (``heading``, ``role``,
    ``unit``, ``stream``, ``reason``) and ``notes``.
    """
    path = Path(path)
    suffix = path.suffix.lower()
    if format is not None or not path.name.lower().endswith(READABLE) or not path.is_file():
        return check_file(path, format=format)
    problems: list[str] = []
    found: tuple[ColumnUse, ...] = ()
    notes: tuple[str, ...] = ()
    try:
        file = read_file(path, **reading)
        found, notes = file.columns, file.notes
    except TactogramError as error:
        problems.append(str(error))
        with suppress(TactogramError):
            found = read_columns(path)
    return {
        "file": str(path),
        "format": suffix.removeprefix("."),
        "valid": not problems,
        "problems": problems,
        "columns": [asdict(column) for column in found],
        "notes": list(notes),
    }


@dataclass(frozen=True)
class _Given:
    """Signal to write, played, mapped and resampled as requested, and its facts as in the result of `convert`."""

    signal: Signal
    metadata: dict[str, Any]
    reduced_by: str | None = None
    mapped: dict[str, Any] | None = None
    timing: dict[str, Any] | None = None
    read: dict[str, Any] | None = None
    notes: tuple[str, ...] = ()
    events: HapticFile | None = None


def _over_time(source: Path, request: ConversionRequest, reading: dict[str, Any]) -> _Given:
    """Return a file of a signal, or a haptic one."""
    if request.width_mm is not None:
        raise ParameterError(f"`width_mm` is of a photograph, {source.name} is none; omit it")
    given = _read(source, reading)
    if request.play_at is not None:
        if request.map is not None:
            raise ParameterError("`map` is for a sound, which is over time; omit `play_at`")
        rate = request.resample_to or given.signal.rate * request.play_at
        return replace(given, signal=played(given.signal, request.play_at, rate), events=None)
    if request.map is not None:
        signal, how = to_one_axis(given.signal, request.axis)
        signal, mapped = sound_to_touch(signal, request.map)
        given = replace(given, signal=signal, reduced_by=how, mapped=mapped, events=None)
    if request.resample_to is None:
        return given
    return replace(given, signal=resample(given.signal, request.resample_to), events=None)


def _drawn(source: Path, request: ConversionRequest, reading: dict[str, Any]) -> _Given:
    useless = [name for name in (*reading, "map", "axis") if reading.get(name, getattr(request, name))]
    if useless:
        raise ParameterError(f"{source}: a photograph has no use for {' or '.join(useless)}; omit it")
    width, speed = request.width_mm or WIDTH_MM, request.play_at or SPEED_MM_S
    photograph = read_image(source, width_mm=width)
    signal = photo_to_touch(photograph, speed_mm_s=speed, rate=request.resample_to or READ_RATE)
    return _Given(
        signal, read_image_metadata(source), mapped={"by": "relief", "width_mm": width, "speed_mm_s": speed}
    )


def _haptic_name(format: str | None, target: Path) -> str | None:
    """Return the name of the haptic format to write; None where the suffix implies it, or the format is not haptic."""
    if format is None:
        return None
    suffix = _suffix_of(format)
    if target.suffix.lower() != suffix:
        raise ParameterError(f"format {format} is written as {suffix}, got {target.name}")
    return format if format not in SIGNAL_FORMATS else None


def _suffix_of(format: str) -> str:
    formats = haptic_formats()
    if format in formats:
        return formats[format].suffix
    if format not in SIGNAL_FORMATS:
        raise ParameterError(
            f"format must be one of {', '.join((*formats, *SIGNAL_FORMATS))}, got {format!r}"
        )
    return f".{format}"


def _read(source: Path, options: dict[str, Any]) -> _Given:
    # Android has an XML of effects, too, of which only `read_haptic` can say what to write instead.
    if source.suffix.lower() not in (*haptic_suffixes(), ".xml"):
        file = read_file(source, **options)
        metadata = file.metadata
        timing = None if file.timing is None else asdict(file.timing)
        if timing is not None:
            metadata["timing"] = timing
        return _Given(file.signal, metadata, timing=timing, notes=_notes(file))
    useless = [name for name in ("unit", "time", "sheet", "part", "full_scale") if options.get(name)]
    if useless:
        raise ParameterError(f"{source}: a haptic file has no use for {' or '.join(useless)}; omit it")
    haptic = read_haptic(source, rate=options["rate"])
    signal = haptic.signal.select(*options["axes"]) if options["axes"] else haptic.signal
    whole = haptic if haptic.events is not None and signal is haptic.signal else None
    metadata = haptic.metadata | {"read_from": haptic.facts}
    return _Given(signal, metadata, read=haptic.facts, notes=haptic.warnings, events=whole)


def _notes(file: SignalFile) -> tuple[str, ...]:
    """Return the notes on a file, and the streams beside the signal, which are not written."""
    others = ", ".join(
        f"{name} ({', '.join(signal.axes)}, {signal.unit})" for name, signal in file.others.items()
    )
    return (*file.notes, *([f"not written: {others}; `axes=NAME,NAME` reads them"] if others else []))
