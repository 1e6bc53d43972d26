"""The haptic file formats: names, suffixes, and what writes, reads and checks each."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Literal

from tactogram.errors import DataError, ParameterError
from tactogram.rendering.files import hjif_rules
from tactogram.rendering.files.documents import DecodedDocument
from tactogram.rendering.files.formats import ahap, android, gamepad, haptic, hjif, vibration
from tactogram.signal import Signal


@dataclass(frozen=True)
class HapticFormat:
    """A format that holds parts of full scale.

    Parameters
    ----------
    name : str
        As ``--format`` takes it.
    title : str
    suffix : str
        ``.json`` is shared.
    holds : {"waveform", "envelope", "on and off"}
        A waveform keeps all axes; the others are of one.
    encode : function of Signal and str
        The document of a signal within full scale, with a description.
    decode : function of a valid document and a rate in Hz
    validate : function of JSON values
        What is wrong with them, a line each.
    """

    name: str
    title: str
    suffix: str
    holds: Literal["waveform", "envelope", "on and off"]
    encode: Callable[[Signal, str], dict[str, Any]]
    decode: Callable[[Any, float], DecodedDocument]
    validate: Callable[[Any], list[str]]


FORMATS = {
    format.name: format
    for format in (
        HapticFormat("ahap", "AHAP (Apple)", ".ahap", "envelope", ahap.encode, ahap.decode, ahap.validate),
        HapticFormat(
            "haptic",
            ".haptic v1 (Meta)",
            ".haptic",
            "envelope",
            haptic.encode,
            haptic.decode,
            haptic.validate,
        ),
        HapticFormat(
            "hjif", "HJIF (MPEG)", ".hjif", "waveform", hjif.encode, hjif.decode, hjif_rules.validate
        ),
        HapticFormat(
            "android",
            "Android waveform",
            ".json",
            "envelope",
            android.encode,
            android.decode,
            android.validate,
        ),
        HapticFormat(
            "vibration",
            "W3C vibration pattern",
            ".json",
            "on and off",
            vibration.encode,
            vibration.decode,
            vibration.validate,
        ),
        HapticFormat(
            "gamepad",
            "Gamepad effects",
            ".json",
            "envelope",
            gamepad.encode,
            gamepad.decode,
            gamepad.validate,
        ),
    )
}
SHARED = ".json"
SUFFIXES = tuple(dict.fromkeys(format.suffix for format in FORMATS.values()))


def format_for(path: Path, name: str | None = None) -> HapticFormat | None:
    """Return the format that a file is to be written in: the named one, else by its suffix; None if it is not haptic.

    Raises
    ------
    ParameterError
        If there is no such format, or the suffix is shared and no name given.
    """
    if name is not None:
        if name not in FORMATS:
            raise ParameterError(f"--format must be one of {', '.join(FORMATS)}, got {name!r}")
        return FORMATS[name]
    suffix = path.suffix.lower()
    if suffix == SHARED:
        sharing = ", ".join(f.name for f in FORMATS.values() if f.suffix == SHARED)
        raise ParameterError(f"{path}: say with --format which kind of {SHARED}: {sharing}")
    return next((format for format in FORMATS.values() if format.suffix == suffix), None)


def format_of(document: Any, path: Path) -> HapticFormat:
    """Return the format of a document that was read: by the suffix, or by what is in it where that is shared.

    Raises
    ------
    DataError
        If it is none of these.
    """
    suffix = path.suffix.lower()
    if suffix != SHARED:
        found = next((format for format in FORMATS.values() if format.suffix == suffix), None)
        if found is not None:
            return found
    keys = set(document) if isinstance(document, dict) else set()
    for name, telling in (
        ("android", {"timings"}),
        ("gamepad", {"effects"}),
        ("vibration", {"pattern"}),
        ("ahap", {"Pattern"}),
        ("haptic", {"signals"}),
        ("hjif", {"perceptions"}),
    ):
        if telling <= keys:
            return FORMATS[name]
    if isinstance(document, list):
        return FORMATS["vibration"]
    raise DataError(f"{path}: is none of {', '.join(FORMATS)}; say with --format what it is meant to be")
