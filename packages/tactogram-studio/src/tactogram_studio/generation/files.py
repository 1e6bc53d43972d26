"""Files of the page Make: uploads that a form refers to, named by their content, and results to download."""

from __future__ import annotations

import hashlib
from collections.abc import Mapping
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

import numpy as np
from PIL import Image as Pillow

from tactogram.errors import DataError
from tactogram.rendering import MotionFile, file_name, haptic_formats, haptic_labels
from tactogram.signal import Image, Signal
from tactogram.signal.io import atomic_write, write_image, write_signal
from tactogram.workflows import SIGNAL_FORMATS, convert, list_formats
from tactogram_studio.signals.sound import LISTENING, PLAYBACK_MM_S, listening_name, sound_of, sound_text
from tactogram_studio.signals.traits import unit_text
from tactogram_studio.workspace.commands import stem_of
from tactogram_studio.workspace.shelf import KeptResult
from tactogram_studio.workspace.uploads import check_upload, read_uploaded_image, safe_name

FOR_LISTENING = "listening"
"""Name of the WAV of `sound_of`, beside those of the formats of signals and haptic files."""
MOST_SIDE = 4096
"""Longest side of a stored photograph, pixels; models use far fewer."""


def store_photo(folder: Path, name: str, data: bytes) -> str:
    """Store an uploaded picture as PNG under a name with a hash of its pixels, and return the name.

    Raises
    ------
    DataError, ParameterError
        If it is not a picture, or too large.
    """
    image = _limited(read_uploaded_image(name, data))
    stored = _hashed(name, image.pixels.tobytes(), ".png")
    if not (folder / stored).is_file():
        write_image(folder / stored, image)
    return stored


def _limited(image: Image) -> Image:
    """Return an image scaled to at most `MOST_SIDE` on its longer side."""
    if max(image.size) <= MOST_SIDE:
        return image
    picture = Pillow.fromarray(image.pixels)
    picture.thumbnail((MOST_SIDE, MOST_SIDE), Pillow.Resampling.LANCZOS)
    return Image(np.asarray(picture))


def _hashed(name: str, content: bytes, suffix: str) -> str:
    """Return the name of a file with a hash of its content, so that a command keeps its meaning."""
    return f"{Path(safe_name(name)).stem[:60]}-{hashlib.sha256(content).hexdigest()[:8]}{suffix}"


def store_vibration(folder: Path, name: str, signal: Signal) -> str:
    """Store a signal as a file, so that a command can refer to it, and return its name."""
    stored = _hashed(name, signal.samples.tobytes(), ".npz")
    if not (folder / stored).is_file():
        folder.mkdir(parents=True, exist_ok=True)
        write_signal(folder / stored, signal)
    return stored


def store_motion(folder: Path, name: str, data: bytes) -> str:
    """Store an uploaded motion under a name with a hash, and return the name.

    Raises
    ------
    DataError
        If it is not a motion file.
    """
    name = check_upload(name, data, kind="signal")
    stored = _hashed(name, data, ".csv")
    with atomic_write(folder / stored) as part:
        part.write_bytes(data)
        try:
            MotionFile(part)
        except DataError as error:
            raise DataError(error.message.replace(str(part), name)) from None
    return stored


def downloads(result: KeptResult) -> dict[str, dict[str, str]]:
    """Return the titles of the formats of a result by name, by what they are for."""
    signal = result.signal()
    per = "Hz" if signal.domain == "time" else "per mm"
    stated = f"{unit_text(signal.unit)}, {signal.rate:,.6g} {per}, axes {', '.join(signal.axes)}"
    return {
        f"For listening: {LISTENING}": {FOR_LISTENING: "WAV"},
        f"For an actuator or analysis, as it is: {stated}": {name: name.upper() for name in SIGNAL_FORMATS}
        | {"wav": "WAV, 32-bit float"},
        "For an engine": haptic_labels(),
    }


def encoded(result: KeptResult, format: str) -> tuple[str, bytes, str]:
    """Return a result as a file: its name, its bytes, and what a haptic file or a sound loses.

    Raises
    ------
    TactogramError
        If the format cannot hold it.
    """
    if format == FOR_LISTENING:
        signal = result.signal()
        return (
            listening_name(stem_of(result.title)),
            sound_of(signal, subtype="PCM_16").wav,
            sound_text(signal),
        )
    suffix, haptic = list_formats()[format]["suffix"], format in haptic_formats()
    name = file_name(stem_of(result.title), format) if haptic else f"{stem_of(result.title)}{suffix}"
    over_time = result.signal().domain == "time"
    speed = PLAYBACK_MM_S if haptic and not over_time else None
    with TemporaryDirectory() as folder:
        path = Path(folder) / name
        facts = convert(result.file, path, format=format, play_at=speed)
        return name, path.read_bytes(), _sentence(facts["written"], speed) if haptic else ""


def _sentence(written: Mapping[str, Any], speed_mm_s: float | None) -> str:
    """Return what a haptic file keeps and loses, of several axes the first, and the verdict on all."""
    played = "" if speed_mm_s is None else f" Played at {speed_mm_s:g} mm/s."
    return f"{written['told'][0]}{played} Verdict: {written['verdict']}"
