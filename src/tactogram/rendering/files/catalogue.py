"""Haptic file formats, from the folder ``formats`` and from plug-ins, by name and by suffix."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any, Literal

from tactogram.errors import DataError, ParameterError
from tactogram.plugins import PluginGroup
from tactogram.rendering.files.documents import DecodedDocument, DocumentHeader, Node, encoded, parse
from tactogram.rendering.files.events import Events
from tactogram.signal import Signal


@dataclass(frozen=True)
class HapticFormat:
    """A format that holds parts of full scale.

    Parameters
    ----------
    name : str
        Equals the name of the module's file.
    suffix : str
        May be shared with other formats.
    holds : {"waveform", "envelope", "on and off"}
        A waveform keeps all axes, the others hold events of one.
    encode : callable
        Returns the document of events within full scale.
    decode : callable
        Returns the content of a document as players take it. What it lacks, and what players clamp, is noted by
        `documents.Node`; rules of the format are noted in its ``notes``.
    recognise : callable
        Whether a document with an unknown or shared suffix looks like this format.
    encode_waveform : callable, optional
        Returns the document of a signal within full scale, of a format that holds waveforms.
    bands : tuple of (float, float), Hz
        In which the strength of a waveform is analysed, each on its own; by default all that is felt, with transients.
    resolution_s : float, s
        By how much the time of an event may differ in the file.
    instead : mapping of str
        What keeps more of a signal, for the same devices if possible, in words (see `verdict`), with the name or
        suffix of the format, if it is one.
    modalities : tuple of str
        Modalities that the format distinguishes, if any.
    highest_rate : float, Hz, optional
        Waveforms over time with a higher rate are resampled to it.
    engine : str
        What plays the files: an engine or a platform.
    commas_at_ends : bool
        Whether players forgive a comma after the last member of a list or an object.
    parse, serialise : callable
        Convert a file's bytes (and its path, for errors) to a document, and back. JSON by default.
    """

    name: str
    title: str
    suffix: str
    holds: Literal["waveform", "envelope", "on and off"]
    encode: Callable[[Events, DocumentHeader], Any]
    decode: Callable[[Node], DecodedDocument]
    recognise: Callable[[Any], bool]
    encode_waveform: Callable[[Signal, DocumentHeader], Any] | None = None
    bands: tuple[tuple[float, float], ...] = ()
    resolution_s: float = 0.001
    instead: Mapping[str, str] = field(
        default_factory=lambda: {"a format of waveforms (.wav, .hjif)": ".hjif"}
    )
    modalities: tuple[str, ...] = ()
    highest_rate: float | None = None
    engine: str = ""
    commas_at_ends: bool = False
    parse: Callable[[bytes, Path], Any] = parse
    serialise: Callable[[Any], bytes] = encoded

    @property
    def label(self) -> str:
        """What plays it, unless the title says so, title and suffix."""
        first = self.engine.split(" ")[0]
        engine = "" if self.title.startswith(first) else f"{self.engine}: "
        return f"{engine}{self.title} ({self.suffix})"


FORMATS = PluginGroup(
    "haptic format",
    "tactogram.rendering.files.formats",
    "tactogram.haptic_formats",
    "TACTOGRAM_HAPTIC_FORMATS",
)
"""Modules with a ``FORMAT``, a `HapticFormat`."""


def haptic_formats() -> dict[str, HapticFormat]:
    """Return every haptic format by name."""
    return {name: haptic_format(name) for name in FORMATS.names()}


def haptic_labels() -> dict[str, str]:
    """Return the label of every haptic format by name, those of an engine side by side."""
    formats = sorted(haptic_formats().values(), key=lambda format: (format.engine.lower(), format.name))
    return {format.name: format.label for format in formats}


def haptic_format(name: str) -> HapticFormat:
    """Return a haptic format by name; `ParameterError` if there is none, or its module does not define one."""
    return FORMATS.definition(name, "FORMAT", HapticFormat)


def haptic_suffixes() -> tuple[str, ...]:
    """Return the suffixes of all haptic formats."""
    return tuple(dict.fromkeys(format.suffix for format in haptic_formats().values()))


def formats_with(suffix: str) -> list[HapticFormat]:
    """Return the haptic formats with a suffix."""
    return [format for format in haptic_formats().values() if format.suffix == suffix.lower()]


def format_for(path: Path, name: str | None = None) -> HapticFormat | None:
    """Return the format to write a file in, by name or else by suffix; None if it is not haptic.

    Raises `ParameterError` if there is no such format, or several share the suffix and none is named.
    """
    if name is not None:
        return haptic_format(name)
    candidates = formats_with(path.suffix)
    if len(candidates) > 1:
        names = ", ".join(format.name for format in candidates)
        raise ParameterError(
            f"{path}: several formats are written as {path.suffix}; format must be one of {names}"
        )
    return candidates[0] if candidates else None


def recognised_format(document: Any, path: Path) -> HapticFormat:
    """Return the format of a document whose file's suffix is unknown or shared; `DataError` if none recognises it."""
    formats = haptic_formats()
    recognised = (format for format in formats.values() if format.recognise(document))
    format = next(recognised, None)
    if format is None:
        raise DataError(path, f"is none of {', '.join(formats)}; name its format")
    return format


def file_name(stem: str, format: str) -> str:
    """Return the name of a file of a format; it includes the format where several share the suffix."""
    suffix = haptic_format(format).suffix
    return f"{stem}-{format}{suffix}" if len(formats_with(suffix)) > 1 else f"{stem}{suffix}"
