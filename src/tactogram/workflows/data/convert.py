"""Conversion between file formats, of signals and of haptic files, one file or a folder."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import asdict
from pathlib import Path
from typing import Any

from tactogram.errors import DataError, ParameterError, TactogramError
from tactogram.rendering.files.catalogue import format_for, haptic_formats, haptic_suffixes
from tactogram.rendering.files.conversion import check_file, read_haptic, write_haptic
from tactogram.rendering.files.reduction import to_one_axis
from tactogram.signal import Signal
from tactogram.signal.displacement import played
from tactogram.signal.io import READABLE, WRITABLE, read_file, write_signal
from tactogram.signal.io.writable import check_writable
from tactogram.signal.resampling import resample
from tactogram.workflows.progress import ProgressCallback, silent

SIGNAL_FORMATS = tuple(suffix.removeprefix(".") for suffix in WRITABLE)
"""Formats of signals by name, beside `haptic_formats`."""


def convert(
    source: Path | str,
    target: Path | str,
    *,
    format: str | None = None,
    unit: str | None = None,
    rate: float | None = None,
    axes: Sequence[str] | None = None,
    columns: Sequence[str] | None = None,
    time: str | None = None,
    sheet: str | None = None,
    full_scale: float | None = None,
    play_at: float | None = None,
    resample_to: float | None = None,
    subtype: str | None = None,
    axis: str | None = None,
    modality: str | None = None,
) -> dict[str, Any]:
    """Write the signal in ``source`` to ``target``, in the format of its suffix; metadata goes along.

    Haptic files (`tactogram.rendering.files`) are read and written, too. What they hold is parts of full scale,
    mostly an envelope instead of samples: what was scaled and what is lost is in the result, and in the file.

    Parameters
    ----------
    source, target : Path
        As in `tactogram.signal.io.read_signal` and `write_signal`, or a haptic file. ``target`` is replaced if it is
        there, once all is written, and may be ``source``.
    format : str, optional
        Of ``target``, where several haptic formats share its suffix. Any other must agree with it.
    unit, rate, axes, columns, time, sheet : optional
        What ``source`` does not say, as in `read_signal`; of a haptic file ``rate`` is that of the carrier.
    full_scale : float, optional
        Of a haptic ``target`` what 1 stands for; else what 1.0 in a WAV or FLAC ``source`` does. In the signal's unit.
    play_at : float, mm/s, optional
        Speed of a finger that moves over a signal over displacement: ``target`` is what it meets, over time.
    resample_to : float, Hz, optional
        Rate of ``target``; by default that of the signal.
    subtype : str, optional
        Sample format of ``target``, as in `write_signal`.
    axis : str, optional
        Write one axis: a name, ``dft321`` or ``mean``. Formats that hold one take DFT321 of three, else the mean.
    modality : str, optional
        Of a haptic format that distinguishes modalities; by default by unit.

    Returns
    -------
    dict
        ``source``, ``target``, ``samples``, ``rate_hz`` (``rate_per_mm`` over displacement), ``unit``, ``axes``,
        ``rms`` (in ``unit``), ``timing`` (what time stamps in ``source`` say, see
        `signal.timing.SamplingTiming`; None if there are none), ``metadata``; ``reduced_by`` where axes became one;
        ``read`` of a haptic source (its facts), ``written`` of a haptic target (as `write_haptic`).

    Raises
    ------
    DataError, ParameterError
        As `read_signal`, `write_signal`, `read_haptic` and `write_haptic`; nothing is written then.
    """
    source, target = Path(source), Path(target)
    kind = format_for(target, _haptic_name(format, target))
    if kind is not None and subtype is not None:
        raise ParameterError(f"--subtype is of WAV and FLAC; {kind.title} has none")
    reading = {"unit": unit, "rate": rate, "axes": axes, "columns": columns, "time": time, "sheet": sheet}
    if kind is None:
        reading["full_scale"] = full_scale
    signal, metadata, timing, read = _read(source, reading)
    if play_at is not None:
        if not (play_at > 0 and math.isfinite(play_at)):
            raise ParameterError(f"--play-at must be a speed > 0 mm/s, got {play_at:g}")
        signal = played(signal, play_at, resample_to or signal.rate * play_at)
        metadata["played_at_mm_s"] = play_at
    elif resample_to is not None:
        signal = resample(signal, resample_to)
    written, how = None, None
    if kind is not None:
        written = write_haptic(
            target,
            signal,
            format=kind.name,
            axis=axis,
            full_scale=full_scale,
            modality=modality,
            metadata=metadata,
        )
        how = written["reduced_by"]
    else:
        if modality is not None:
            raise ParameterError(f"modality is for haptic formats, {target.name} is none; leave it out")
        if axis is not None:
            signal, how = to_one_axis(signal, axis)
        write_signal(target, signal, metadata=metadata, subtype=subtype)
    facts = {
        "source": str(source),
        "target": str(target),
        "samples": len(signal),
        "rate_hz" if signal.domain == "time" else "rate_per_mm": signal.rate,
        "unit": signal.unit,
        "axes": list(signal.axes),
        "rms": float((signal.samples.astype(float) ** 2).mean() ** 0.5),
        "timing": timing,
        "metadata": metadata,
    }
    optional = {"reduced_by": how, "read": read, "written": written}
    return facts | {name: value for name, value in optional.items() if value is not None}


def convert_folder(
    source: Path | str,
    target: Path | str,
    *,
    format: str,
    progress: ProgressCallback = silent,
    **options: Any,
) -> dict[str, Any]:
    """Convert every file of a folder, and of the folders in it, that can be read.

    Parameters
    ----------
    source, target : Path
        Folders; ``target`` gets the same names with the suffix of ``format``.
    format : str
        A suffix of `WRITABLE` without its dot, or a haptic format.
    progress : Progress
    options
        As `convert`, for every file.

    Returns
    -------
    dict
        ``source``, ``target``, ``format``, ``files`` (as `convert`, each), ``failed`` (by file, why; the others are
        written), ``left_out`` (how many files are of no format that is known).

    Raises
    ------
    DataError
        If nothing there can be read.
    ParameterError
        If there is no such format, two files would become one, or ``target`` cannot be written to.
    """
    source, target = Path(source), Path(target)
    suffix = _suffix_of(format)
    present = sorted(p for p in source.rglob("*") if p.is_file() and not p.name.startswith("."))
    if target.resolve() != source.resolve():
        present = [p for p in present if not p.resolve().is_relative_to(target.resolve())]
    suffixes = (*READABLE, *haptic_suffixes())
    paths = [p for p in present if p.suffix.lower() in suffixes]
    if not paths:
        raise DataError(f"{source}: no file in it can be read; known are {', '.join(suffixes)}")
    made: dict[Path, Path] = {}
    for path in paths:
        place = (target / path.relative_to(source)).with_suffix(suffix)
        if place in made:
            raise ParameterError(f"{made[place]} and {path} would both become {place}; rename one")
        made[place] = path
    check_writable(target, folder=True)
    files, failed = [], {}
    for done, (place, path) in enumerate(made.items()):
        progress("files", done, len(made), path.name)
        try:
            files.append(convert(path, place, format=format, **options))
        except TactogramError as error:
            failed[str(path)] = str(error)
    progress("files", len(made), len(made))
    return {
        "source": str(source),
        "target": str(target),
        "format": format,
        "files": files,
        "failed": failed,
        "left_out": len(present) - len(paths),
    }


def list_formats() -> dict[str, dict[str, str]]:
    """Return every format by name: ``title``, ``suffix``, and what it ``holds``."""
    haptic = {
        name: {"title": kind.title, "suffix": kind.suffix, "holds": kind.holds}
        for name, kind in haptic_formats().items()
    }
    return haptic | {
        name: {"title": "", "suffix": f".{name}", "holds": "waveform"} for name in SIGNAL_FORMATS
    }


def check(path: Path | str, *, format: str | None = None) -> dict[str, Any]:
    """Return whether a file is valid: ``file``, ``format``, ``valid``, ``problems`` (a line each).

    Haptic files as `tactogram.rendering.files.check_file`; others are read, and the first thing that is wrong is said.
    """
    path = Path(path)
    suffix = path.suffix.lower()
    if format is not None or suffix not in READABLE or not path.is_file():
        return check_file(path, format=format)
    problems = []
    try:
        read_file(path)
    except TactogramError as error:
        problems.append(str(error))
    return {
        "file": str(path),
        "format": suffix.removeprefix("."),
        "valid": not problems,
        "problems": problems,
    }


def _haptic_name(format: str | None, target: Path) -> str | None:
    """Return the name of the haptic format to write; None where the suffix says it, or the format is not haptic."""
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


def _read(
    source: Path, options: dict[str, Any]
) -> tuple[Signal, dict[str, Any], dict[str, Any] | None, dict[str, Any] | None]:
    """Return signal, metadata, timing and, of a haptic file, how it was read."""
    if source.suffix.lower() not in haptic_suffixes():
        file = read_file(source, **options)
        metadata = file.metadata
        timing = None if file.timing is None else asdict(file.timing)
        if timing is not None:
            metadata["timing"] = timing
        return file.signal, metadata, timing, None
    useless = [name for name in ("unit", "columns", "time", "sheet", "full_scale") if options.get(name)]
    if useless:
        raise ParameterError(f"{source}: a haptic file has no use for {' or '.join(useless)}; leave it out")
    haptic = read_haptic(source, rate=options["rate"])
    signal = haptic.signal.select(*options["axes"]) if options["axes"] else haptic.signal
    return signal, haptic.metadata | {"read_from": haptic.facts}, None, haptic.facts
