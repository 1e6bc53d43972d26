"""Sources of a conversion: a file of a signal, a haptic file, or a photograph, as the signal to write."""

from __future__ import annotations

import mimetypes
from dataclasses import asdict, dataclass, replace
from pathlib import Path
from typing import Any

from tactogram.errors import Message, ParameterError, Remedy
from tactogram.rendering.drive.axes import to_one_axis
from tactogram.rendering.files.analysis import READ_RATE
from tactogram.rendering.files.catalogue import HapticFormat, format_for, haptic_formats, haptic_suffixes
from tactogram.rendering.files.reading import HapticFile, read_haptic
from tactogram.rendering.photo_relief import SPEED_MM_S, WIDTH_MM, photo_to_touch
from tactogram.rendering.sound_map import SoundMap, sound_to_touch
from tactogram.signal import Signal
from tactogram.signal.displacement import played
from tactogram.signal.io import WRITABLE, SignalFile, read_file, read_image, read_image_metadata
from tactogram.signal.resampling import resample

SIGNAL_FORMATS = tuple(suffix.removeprefix(".") for suffix in WRITABLE)
"""Formats of signals by name, in addition to `haptic_formats`."""


@dataclass(frozen=True)
class ConversionSource:
    """Signal to write, played, mapped and resampled as requested, and its facts as in the result of `convert`."""

    signal: Signal
    metadata: dict[str, Any]
    reduced_by: str | None = None
    mapped: dict[str, Any] | None = None
    timing: dict[str, Any] | None = None
    read: dict[str, Any] | None = None
    notes: tuple[str, ...] = ()
    events: HapticFile | None = None


def read_source(
    source: Path,
    reading: dict[str, Any],
    *,
    axis: str | None,
    map: SoundMap | None,
    play_at: float | None,
    width_mm: float | None,
    resample_to: float | None,
) -> ConversionSource:
    """Return what a file holds, as `convert` writes it; ``reading`` are the arguments of `read_file`."""
    if (mimetypes.guess_type(source.name)[0] or "").startswith("image/"):
        useless = [name for name, value in {**reading, "map": map, "axis": axis}.items() if value]
        if useless:
            raise ParameterError(f"{source}: a photograph has no use for {' or '.join(useless)}; omit it")
        content = _drawn(source, width_mm or WIDTH_MM, play_at or SPEED_MM_S, resample_to or READ_RATE)
    else:
        if width_mm is not None:
            raise ParameterError(f"is of a photograph, {source.name} is none; omit it", parameter="width_mm")
        content = _read(source, reading)
        if play_at is not None:
            if map is not None:
                remedy = Remedy("omit", "play_at")
                raise ParameterError("is for a sound, which is over time", parameter="map", remedy=remedy)
            signal = played(content.signal, play_at, resample_to or content.signal.rate * play_at)
            content = replace(content, signal=signal, events=None)
        else:
            if map is not None:
                signal, how = to_one_axis(content.signal, axis)
                signal, mapped = sound_to_touch(signal, map)
                content = replace(content, signal=signal, reduced_by=how, mapped=mapped, events=None)
            if resample_to is not None:
                content = replace(content, signal=resample(content.signal, resample_to), events=None)
    further = {"played_at_mm_s": play_at, "mapped": content.mapped}
    known = {name: value for name, value in further.items() if value is not None}
    return replace(content, metadata=content.metadata | known)


def _drawn(source: Path, width_mm: float, speed_mm_s: float, rate: float) -> ConversionSource:
    signal = photo_to_touch(read_image(source, width_mm=width_mm), speed_mm_s=speed_mm_s, rate=rate)
    mapped = {"by": "relief", "width_mm": width_mm, "speed_mm_s": speed_mm_s}
    return ConversionSource(signal, read_image_metadata(source), mapped=mapped)


def target_format(target: Path, format: str | None) -> HapticFormat | None:
    """Return the haptic format to write, by its name or else by suffix; None of a signal.

    `ParameterError` if the target has another suffix than the format, or one of neither.
    """
    if format is not None:
        suffix = suffix_of(format)
        if target.suffix.lower() != suffix:
            raise ParameterError(f"format {format} is written as {suffix}, got {target.name}")
    kind = format_for(target, None if format in SIGNAL_FORMATS else format)
    known = (*WRITABLE, *haptic_suffixes())
    if kind is None and target.suffix.lower() not in known:
        raise ParameterError(
            f"{target}: suffix must be one of {', '.join(known)}, got {target.suffix or 'none'}"
        )
    return kind


def suffix_of(format: str) -> str:
    """Return the suffix of a format by name; `ParameterError` if there is none."""
    formats = haptic_formats()
    if format in formats:
        return formats[format].suffix
    if format not in SIGNAL_FORMATS:
        raise ParameterError.one_of("format", (*formats, *SIGNAL_FORMATS), format)
    return f".{format}"


def _read(source: Path, options: dict[str, Any]) -> ConversionSource:
    # Android has an XML of effects, too, of which only `read_haptic` can say what to write instead.
    if source.suffix.lower() not in (*haptic_suffixes(), ".xml"):
        file = read_file(source, **options)
        metadata = file.metadata
        timing = None if file.timing is None else asdict(file.timing)
        if timing is not None:
            metadata["timing"] = timing
        return ConversionSource(file.signal, metadata, timing=timing, notes=_notes(file))
    useless = [name for name in ("unit", "time", "sheet", "part", "full_scale") if options.get(name)]
    if useless:
        raise ParameterError(f"{source}: a haptic file has no use for {' or '.join(useless)}; omit it")
    haptic = read_haptic(source, rate=options["rate"])
    signal = haptic.signal.select(*options["axes"]) if options["axes"] else haptic.signal
    whole = haptic if haptic.events is not None and signal is haptic.signal else None
    metadata = haptic.metadata | {"read_from": haptic.facts}
    return ConversionSource(signal, metadata, read=haptic.facts, notes=haptic.warnings, events=whole)


def _notes(file: SignalFile) -> tuple[str, ...]:
    """Return the notes on a file, and the streams beside the signal, which are not written."""
    others = ", ".join(
        f"{name} ({', '.join(signal.axes)}, {signal.unit})" for name, signal in file.others.items()
    )
    beside = Message(f"not written: {others}", Remedy("to read them,", "axes", "NAME,NAME"))
    return (*file.notes, *([beside] if others else []))
