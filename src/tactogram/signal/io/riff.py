"""Chunks of a WAV file that libsndfile does not check or keep (truncation, long comments)."""

from __future__ import annotations

import os
import struct
from dataclasses import dataclass
from pathlib import Path
from typing import BinaryIO

from tactogram.errors import DataError

_UNKNOWN_SIZE = 0xFFFFFFFF


@dataclass(frozen=True)
class WavHeader:
    """Header of a WAV file, place and size of its samples in bytes, and the ICMT of its INFO chunk."""

    channels: int
    rate: int
    bits: int
    start: int
    size: int
    comment: str | None


def read_header(path: Path) -> WavHeader:
    """Return the header of a WAV file (RIFF, RIFX or RF64); a `DataError` names the byte."""
    length = path.stat().st_size
    with path.open("rb") as file:
        head = file.read(12)
        if not head:
            raise DataError(f"{path}: empty file")
        if head[:4] not in (b"RIFF", b"RIFX", b"RF64") or head[8:12] != b"WAVE":
            raise DataError(f"{path}: not a WAV file: expected RIFF … WAVE at byte 0, got {head!r}")
        return _header(file, path, length, ">" if head[:4] == b"RIFX" else "<")


def _header(file: BinaryIO, path: Path, length: int, order: str) -> WavHeader:
    form = data = comment = None
    large = 0
    at = 12
    while at + 8 <= length:
        file.seek(at)
        name, size = struct.unpack(f"{order}4sI", file.read(8))
        if name == b"ds64":
            large = struct.unpack("<QQ", file.read(16))[1]
        if name == b"data" and size == _UNKNOWN_SIZE:
            size = large or length - at - 8
        if at + 8 + size > length:
            raise DataError(
                f"{path}: truncated: chunk {name.decode('latin-1')!r} at byte {at} says {size} bytes, "
                f"{length - at - 8} are there"
            )
        if name == b"fmt ":
            form = (at, file.read(size))
        elif name == b"data":
            data = (at + 8, size)
        elif name == b"LIST":
            comment = _comment(file.read(size)) or comment
        at += 8 + size + size % 2
    if form is None or len(form[1]) < 16 or data is None:
        missing = "data" if form is not None and len(form[1]) >= 16 else "fmt"
        raise DataError(f"{path}: truncated: no {missing} chunk before the end at byte {length}")
    _, channels, rate, _, _, bits = struct.unpack(f"{order}HHIIHH", form[1][:16])
    if rate == 0:
        raise DataError(f"{path}: rate must be > 0 Hz, got 0 at byte {form[0] + 12}")
    if channels == 0:
        raise DataError(f"{path}: channels must be > 0, got 0 at byte {form[0] + 10}")
    if data[1] == 0:
        raise DataError(f"{path}: no samples: the data chunk before byte {data[0]} is empty")
    return WavHeader(channels, rate, bits, *data, comment)


def _comment(chunk: bytes) -> str | None:
    if chunk[:4] != b"INFO":
        return None
    at = 4
    while at + 8 <= len(chunk):
        name, size = struct.unpack_from("<4sI", chunk, at)
        if name == b"ICMT":
            return chunk[at + 8 : at + 8 + size].split(b"\0")[0].decode("utf-8", "replace")
        at += 8 + size + size % 2
    return None


def append_comment(path: Path, text: str) -> None:
    """Append ``text`` (ASCII) to a RIFF file as the INFO chunk's ICMT.

    libsndfile writes such comments too, but silently drops them from some 4,000 characters on.
    """
    value = text.encode("ascii") + b"\0"
    info = b"INFO" + struct.pack("<4sI", b"ICMT", len(value)) + value + b"\0" * (len(value) % 2)
    with path.open("r+b") as file:
        end = file.seek(0, os.SEEK_END)
        file.write(b"\0" * (end % 2) + struct.pack("<4sI", b"LIST", len(info)) + info)
        length = file.tell()
        file.seek(4)
        file.write(struct.pack("<I", length - 8))
