"""Conversion between file formats, of signals and of haptic files, one file or a folder."""

from __future__ import annotations

import re
from collections import Counter
from collections.abc import Iterator
from contextlib import suppress
from dataclasses import asdict
from pathlib import Path
from typing import Any, Literal

from tactogram.errors import DataError, ParameterError, Remedy, TactogramError
from tactogram.parameters import Count, Parameter, Positive, checked, parameters
from tactogram.signal.io.atomic import check_writable, sole_writer
from tactogram.workflows.progress import ProgressCallback, silent

READING = ("unit", "rate", "axes", "time", "sheet", "part")
"""Options of `convert` on how a file is read, which other verbs take, too."""


def reading_parameters() -> Iterator[Parameter]:
    """Yield the parameters named `READING`."""
    return (parameter for parameter in parameters(convert) if parameter.name in READING)


@checked
def convert(
    source: Path | str,
    target: Path | str | None = None,
    *,
    check: bool = False,
    format: str | None = None,
    axis: str | None = None,
    full_scale: float | None = None,
    modality: str | None = None,
    display: str | None = None,
    map: Literal["envelope", "pitch", "bands"] | None = None,
    play_at: Positive | None = None,
    width_mm: Positive | None = None,
    resample_to: Positive | None = None,
    subtype: str | None = None,
    unit: str | None = None,
    rate: Positive | None = None,
    axes: tuple[str, ...] | None = None,
    time: str | None = None,
    sheet: str | None = None,
    part: Count | None = None,
    progress: ProgressCallback = silent,
) -> dict[str, Any]:
    """Convert a signal from one file format to another, a folder of them, or check a haptic file.

    Metadata are kept. Haptic files (`tactogram.rendering.files`) are read and written, too. They hold parts of full
    scale, mostly events instead of samples: the scale and the loss are in the result, and in the file. From one of them
    to another events remain events; ``resample_to``, ``map`` and ``play_at`` make a waveform of them first.

    A photograph is drawn as a relief (`tactogram.rendering.photo_relief`): its brightness is no prediction of how a
    material feels. In a folder every readable file is converted, and those of the folders in it; ``progress`` is called
    after each.

    Parameters
    ----------
    source : Path or str
        A signal, a haptic file, a folder of them, or a photograph to draw.
    target : Path or str, optional
        A file, by suffix; it may be the source. A folder if the source is one.
    check : bool
        Only validate the source, and list its problems.
    format : str, optional
        Format of the target, one of `convert --list`: if several share its suffix (.json), or for a folder.
    axis : str, optional
        Write one axis: its name, dft321 or mean; formats that hold one take DFT321 of three, else the mean.
    full_scale : float, optional
        Value of 1 in a haptic target, or of integer full scale in the source, in the signal's unit.
    modality : str, optional
        Of HJIF and formats like it, e.g. "Vibrotactile Texture" (default: by unit).
    display : str, optional
        Motor of a pattern of on and off, by name or file, whose shortest_ms holds (default: phone-on-off).
    map : {"envelope", "pitch", "bands"}, optional
        Map a sound to touch: a tone with its strength (envelope) or at its pitch, or a tone for each band.
    play_at : float, optional
        Finger speed for a signal over displacement, or a photograph (then 100), mm/s.
    width_mm : float, optional
        Width that the photograph shows, mm (default: 100).
    resample_to : float, optional
        Rate of the target, Hz.
    subtype : str, optional
        Sample format of the target, e.g. PCM_16, PCM_24, FLOAT.
    unit : str, optional
        Unit of the samples, where the file does not state it: m/s^2, g, N, mm, V, 1, …
    rate : float, optional
        Sampling rate, Hz, where the file does not state it; of a haptic file that of the carrier.
    axes : tuple of str, optional
        Columns or channels to read, e.g. x,y,z.
    time : str, optional
        Column of the time stamps, e.g. 'ticks [us]'; none to use none.
    sheet : str, optional
        Sheet of a workbook, if it has several.
    part : int, optional
        Part of a table that is interrupted, from 1.

    Returns
    -------
    dict
        ``source``, ``target``, ``samples``, ``rate_hz`` (``rate_per_mm`` over displacement), ``unit``, ``axes``,
        ``rms`` (in ``unit``), ``timing`` (of the time stamps in ``source``, see
        `signal.timing.SamplingTiming`; None if there are none), ``metadata``; ``reduced_by`` where axes became one;
        ``mapped`` of a sound (facts of `sound_to_touch`) or a photograph (``by`` "relief", ``width_mm``,
        ``speed_mm_s``); ``read`` of a haptic source (its facts), ``written`` of a haptic target (as `write_haptic`);
        ``notes`` on what of a table was left out or assumed, and on rules that a haptic source breaks.

        Of a folder: ``source``, ``target``, ``format``, ``files`` (as above, each), ``failed`` (the error by file; the
        others are written), ``notes`` (names of ``.txt`` files without a table of numbers, skipped), ``left_out``
        (number of files of no known format), ``beside`` (the converted haptic file by each file beside it, of the same
        name, which is not converted: the signal of a design, or the design in another format than ``format``).

        With ``check``: ``file``, ``format``, ``valid``, ``problems`` (a line each; of haptic files all, of others the
        first), and of a file that is not haptic ``columns`` of a table (``heading``, ``role``, ``unit``, ``stream``,
        ``reason``) and ``notes``.

    Raises
    ------
    DataError, ParameterError
        As `read_signal`, `write_signal`, `read_haptic` and `write_haptic`, and if nothing in a folder can be read, two
        of its signals would become one, or a file in it would be overwritten; nothing is written then.

    Examples
    --------
    >>> tactogram.write_signal("tap.wav", tactogram.Signal([0, 1, 0, -1] * 500, 2000, "1"))
    >>> facts = tactogram.convert("tap.wav", "tap.csv")
    >>> facts["rate_hz"], facts["unit"], round(facts["rms"], 3)
    (2000.0, '1', 0.707)
    """
    options = {name: value for name, value in locals().items() if name != "check"}
    from tactogram.rendering.displays.catalogue import open_display
    from tactogram.rendering.drive.axes import to_one_axis
    from tactogram.rendering.files.catalogue import haptic_suffixes
    from tactogram.rendering.files.conversion import write_haptic
    from tactogram.signal.io import write_signal
    from tactogram.workflows.data.sources import read_source, target_format

    reading = {name: options[name] for name in READING}
    source = Path(source)
    if check:
        if target is not None:
            remedy = Remedy("omit", "target")
            raise ParameterError("takes one file and writes none", parameter="check", remedy=remedy)
        return _checked(source, format, reading)
    if target is None:
        remedy = Remedy("a source alone takes only", "check")
        raise ParameterError("must be given", parameter="target", remedy=remedy)
    target = Path(target)
    if source.is_dir():
        if format is None:
            raise ParameterError("a folder needs a format", remedy=Remedy("give", "format"))
        with sole_writer(target):
            return _convert_folder(**options)
    designed = source.suffix.lower() in haptic_suffixes()  # with what a format of ours cannot keep
    if designed and source.exists() and target.exists() and source.samefile(target):
        raise ParameterError(f"{target} would overwrite its source; choose another target")
    kind = target_format(target, format)
    if kind is not None and subtype is not None:
        raise ParameterError(f"is of WAV and FLAC; {kind.title} has none", parameter="subtype")
    for name, value in (("display", display), ("modality", modality)):
        if kind is None and value is not None:
            of = "patterns of on and off" if name == "display" else "haptic formats"
            raise ParameterError(f"is for {of}, {target.name} is none; omit it", parameter=name)
    content = read_source(
        source,
        reading | ({"full_scale": full_scale} if kind is None else {}),
        axis=axis,
        map=map,
        play_at=play_at,
        width_mm=width_mm,
        resample_to=resample_to,
    )
    signal, how, mapped = content.signal, content.reduced_by, content.mapped
    # A mapped sound or photograph has one axis, whatever it is called.
    axis = axis if mapped is None else None
    written = None
    if kind is not None:
        # Several channels are events of one only where the target holds no more.
        whole = len(signal.axes) == 1 or (axis is None and kind.holds != "waveform")
        written = write_haptic(
            target,
            content.events if content.events is not None and whole else signal,
            format=kind.name,
            axis=axis,
            full_scale=full_scale,
            modality=modality,
            motor=None if display is None else open_display(display),
            metadata=content.metadata,
        )
        how = how or written["reduced_by"]
    else:
        if axis is not None:
            signal, how = to_one_axis(signal, axis)
        write_signal(target, signal, metadata=content.metadata, subtype=subtype)
    facts = {
        "source": str(source),
        "target": str(target),
        "samples": len(signal),
        "rate_hz" if signal.domain == "time" else "rate_per_mm": signal.rate,
        "unit": signal.unit,
        "axes": list(signal.axes),
        "rms": float((signal.samples.astype(float) ** 2).mean() ** 0.5),
        "timing": content.timing,
        "metadata": content.metadata,
    }
    optional: dict[str, Any] = {"reduced_by": how, "mapped": mapped, "read": content.read, "written": written}
    optional["notes"] = list(content.notes) or None
    return facts | {name: value for name, value in optional.items() if value is not None}


def _convert_folder(
    source: Path | str, target: Path | str, format: str, progress: ProgressCallback, **options: Any
) -> dict[str, Any]:
    """Convert every readable file of a folder to the same name in another, with the suffix of ``format``."""
    from tactogram.rendering.files.catalogue import haptic_suffixes
    from tactogram.signal.io import READABLE
    from tactogram.workflows.data.sources import suffix_of

    source, target = Path(source), Path(target)
    suffix = suffix_of(format)
    present = sorted(p for p in source.rglob("*") if p.is_file() and not p.name.startswith("."))
    if target.resolve() != source.resolve():
        present = [p for p in present if not p.resolve().is_relative_to(target.resolve())]
    known = (*READABLE, *haptic_suffixes())
    paths = [p for p in present if p.name.lower().endswith(known)]
    unreadable = DataError(source, f"no file in it can be read; known are {', '.join(known)}")
    if not paths:
        raise unreadable
    sources: dict[Path, Path] = {}
    beside: dict[str, str] = {}
    haptic = haptic_suffixes()
    suffixes = {path: path.suffix.lower() for path in paths}
    for path in sorted(paths, key=lambda path: (suffixes[path] not in haptic, suffixes[path] != suffix)):
        output = (target / path.relative_to(source)).with_suffix(suffix)
        first = sources.setdefault(output, path)
        if first is path:
            continue
        if suffixes[first] not in haptic:
            raise ParameterError(f"{first} and {path} would both become {output}; rename one")
        beside[str(path)] = str(first)
    for output in sources.keys() & set(present):
        raise ParameterError(f"{output} would be overwritten; choose another folder than that of the sources")
    check_writable(target, folder=True)
    files, failed, notes = [], {}, []
    for done, (output, path) in enumerate(sources.items()):
        progress("files", done, len(sources), path.name)
        try:
            files.append(convert(path, output, format=format, **options))
        except TactogramError as error:
            if path.suffix.lower() == ".txt" and _is_note(path):
                notes.append(str(path))
            else:
                failed[str(path)] = error.message
    progress("files", len(sources), len(sources))
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
    from tactogram.rendering.files.catalogue import haptic_formats
    from tactogram.workflows.data.sources import SIGNAL_FORMATS

    haptic = {
        name: {"title": kind.title, "suffix": kind.suffix, "holds": kind.holds}
        for name, kind in haptic_formats().items()
    }
    return haptic | {
        name: {"title": "", "suffix": f".{name}", "holds": "waveform"} for name in SIGNAL_FORMATS
    }


def _checked(path: Path, format: str | None, reading: dict[str, Any]) -> dict[str, Any]:
    from tactogram.rendering.files.reading import check_file
    from tactogram.signal.io import READABLE, read_columns, read_file
    from tactogram.signal.io.content import ColumnUse

    suffix = path.suffix.lower()
    if format is not None or not path.name.lower().endswith(READABLE) or not path.is_file():
        return check_file(path, format=format)
    problems: list[str] = []
    columns: tuple[ColumnUse, ...] = ()
    notes: tuple[str, ...] = ()
    try:
        file = read_file(path, **reading)
        columns, notes = file.columns, file.notes
    except TactogramError as error:
        problems.append(error.message)
        with suppress(TactogramError):
            columns = read_columns(path)
    return {
        "file": str(path),
        "format": suffix.removeprefix("."),
        "valid": not problems,
        "problems": problems,
        "columns": [asdict(column) for column in columns],
        "notes": list(notes),
    }
