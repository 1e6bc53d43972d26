"""Catalogue of haptic file formats by name and by suffix, from the folder ``formats`` and from plug-ins."""

from __future__ import annotations

from pathlib import Path
from typing import Any

from tactogram.errors import DataError, ParameterError
from tactogram.plugins import PluginGroup
from tactogram.rendering.files.format import HapticFormat

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
        raise DataError(f"{path}: is none of {', '.join(formats)}; name its format")
    return format


def file_name(stem: str, format: str) -> str:
    """Return the name of a file of a format; it includes the format where several share the suffix."""
    suffix = haptic_format(format).suffix
    return f"{stem}-{format}{suffix}" if len(formats_with(suffix)) > 1 else f"{stem}{suffix}"
