"""Files of one take: sensors' files in one folder, or of one base name, are streams of one recording."""

from __future__ import annotations

import re
from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from pathlib import PurePosixPath

from tactogram.signal.io.files import SOUND

QUANTITIES: Mapping[str, tuple[str | None, str]] = {
    "acceleration": ("m/s^2", "acc accel acceleration accelerations accelerometer"),
    "linear_acceleration": (
        "m/s^2",
        "linacc linearacc linearacceleration linearaccelerometer useracceleration",
    ),
    "total_acceleration": ("m/s^2", "totalacceleration"),
    "gravity": ("m/s^2", "gravity"),
    "force": ("N", "force forces ft loadcell normalforce"),
    "position": ("m", "pos position displacement"),
    "velocity": ("m/s", "vel velocity"),
    "speed": ("m/s", "speed"),
    "friction": ("1", "friction cof"),
    "vibration": (None, "vib vibration"),
    "angular_rate": ("rad/s", "gyro gyr gyroscope angularrate angularvelocity rotationrate"),
    "orientation": (None, "orientation attitude quaternion"),
    "magnetic_field": ("T", "mag magnetometer magneticfield"),
    "torque": (None, "torque"),
    "sound": ("1", "sound audio mic microphone"),
}
"""Streams by importance, each with its unit, if it has one, and the words that name it in files."""
_OTHER_TABLES = """metadata studymetadata annotation annotations device time location gps battery pedometer activity
heartrate light barometer pressure temperature network notes"""
NO_SIGNALS = frozenset(_OTHER_TABLES.split())
"""Names of tables that are none of a take's signals."""
_STREAM_OF = {word: stream for stream, (_, words) in QUANTITIES.items() for word in words.split()}


@dataclass(frozen=True)
class Take:
    """Files of one recording, by importance, each with the stream that its name states."""

    name: str  # path without suffix, and without what names a quantity
    files: tuple[tuple[str, str | None], ...]  # relative path, stream


def takes(names: Iterable[str]) -> list[Take]:
    """Return the recordings that files (relative paths) make up, in the order of their first files.

    A sound of the same name belongs to a table. Two files of a take that state one quantity are recordings of their
    own.
    """
    stated = {name: _stated(PurePosixPath(name)) for name in names}
    groups: dict[str, list[str]] = {}
    for name, (key, _) in stated.items():
        groups.setdefault(key, []).append(name)
    recordings: list[Take] = []
    for key, members in groups.items():
        sounds = {name for name in members if name.lower().endswith(SOUND)}
        beside = "sound" if len(sounds) < len(members) else None
        streams = [stated[name][1] or (beside if name in sounds else None) for name in members]
        if len(set(streams)) < len(members) or len(members) == 1:
            # A word in the name of a single file may be of the experiment.
            recordings += [Take(_plain(name), ((name, quantity_of(_stem(name))),)) for name in members]
        else:
            ranked = sorted(zip(members, streams, strict=True), key=lambda file: _rank(file[1]))
            recordings.append(Take(key, tuple(ranked)))
    order = {name: i for i, name in enumerate(stated)}
    return sorted(recordings, key=lambda take: min(order[name] for name, _ in take.files))


def quantity_of(text: str) -> str | None:
    """Return the stream that a name states, whatever its case and separators; None if it states none."""
    word = re.sub(r"[\W_]", "", text.lower())
    plain = word.removesuffix("uncalibrated")
    stream = _STREAM_OF.get(plain)
    return stream and (stream if plain == word else f"uncalibrated_{stream}")


def is_no_signal(name: str) -> bool:
    """Return whether a file beside those of a take is named as one that holds no signal."""
    return re.sub(r"[\W_]", "", _stem(name).lower()) in NO_SIGNALS


def _stated(path: PurePosixPath) -> tuple[str, str | None]:
    """Return the path without suffix and what names a quantity, and the stream named."""
    if stream := quantity_of(path.stem):
        return path.parent.as_posix(), stream
    words = re.split(r"([\s_.-]+)", path.stem)
    for count in (3, 1):  # words with the separators between them: linear_acc, acc
        for begin in (0, len(words) - count):
            stream = (
                quantity_of("".join(words[begin : begin + count]))
                if 0 <= begin <= len(words) - count
                else None
            )
            if stream:
                rest = "".join(words[:begin] + words[begin + count :]).strip(" _.-")
                return (path.parent / rest).as_posix(), stream
    if (numbered := re.fullmatch(r"([A-Za-z]+)(\d+)", path.stem)) and (stream := quantity_of(numbered[1])):
        return (path.parent / numbered[2]).as_posix(), stream
    for depth, folder in enumerate(path.parts[:-1]):
        if stream := quantity_of(folder):
            others = (*path.parts[:depth], *path.parts[depth + 1 : -1], path.stem)
            return PurePosixPath(*others).as_posix(), stream
    return _plain(path.as_posix()), None


def _rank(stream: str | None) -> int:
    return 0 if stream is None else 1 + list(QUANTITIES).index(stream) if stream in QUANTITIES else 99


def _stem(name: str) -> str:
    return PurePosixPath(name).stem


def _plain(name: str) -> str:
    return PurePosixPath(name).with_suffix("").as_posix()
