"""Sounds through libsndfile; WAV and FLAC with unit, level, axes and exact rate in a comment."""

from __future__ import annotations

import io
import os
import re
import struct
from collections.abc import Callable, Iterator
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any, BinaryIO

import numpy as np
import soundfile
from numpy.typing import NDArray

from tactogram.errors import DataError, ParameterError, one_line
from tactogram.signal.io.content import FileContent, SignalDescription, decode
from tactogram.signal.signal import Signal

BITS = {"PCM_S8": 8, "PCM_U8": 8, "PCM_16": 16, "PCM_24": 24, "PCM_32": 32, "FLOAT": 32, "DOUBLE": 64}
SUBTYPES = {
    ".wav": ("FLOAT", "DOUBLE", "PCM_U8", "PCM_16", "PCM_24", "PCM_32"),
    ".flac": ("PCM_24", "PCM_16", "PCM_S8"),
}
"""Sample formats by suffix under libsndfile's names, the default first."""

_LARGEST_WAV = 2**32 - 2**20
_FLAC_CHANNELS = 8
_FLAC_RATE = 655_350
_BLOCK = 2**20
_CUT = re.compile(r": (\d+) \(should be (\d+)\)")
"""Chunk of a truncated file in libsndfile's log; it reads what is there without an error."""
_SLACK, _UNKNOWN = 8, 2**32 - 2
"""Bytes that padding may lack, and sizes of streams, which are not known when they begin."""
_UNKNOWN_SIZE = 0xFFFFFFFF


@dataclass(frozen=True)
class _SoundInfo:
    rate: int
    channels: int
    comment: str | None
    place: Callable[[int, int], str]


def read(path: Path, *, full_scale: float | None = None) -> FileContent:
    """Return the content of a sound file; ``full_scale`` is the value of 1.0, if the file does not state it.

    A `DataError` if it is not what its suffix says, is truncated, or was changed after it was described.
    """
    facts = _facts(path)
    description = _description(facts, path)
    try:
        with soundfile.SoundFile(_name(path)) as file:
            expected = file.frames
            blocks = list(_blocks(file))
    except soundfile.LibsndfileError as error:
        raise DataError(path, error.error_string) from error
    samples: NDArray[Any] = np.concatenate(blocks).T if blocks else np.zeros((facts.channels, 0), np.float32)
    if samples.shape[1] < expected:
        raise DataError(path, f"truncated: {expected} samples expected, {samples.shape[1]} are there")
    scale = full_scale
    if description is not None:
        scale = description.full_scale
        if full_scale is not None and full_scale != (scale or 1.0):
            raise DataError(
                path, f"full scale is {scale or 1.0:g} {description.unit}, expected {full_scale:g}"
            )
    if scale is not None and scale != 1.0:
        samples = samples.astype(np.float64) * scale
    return FileContent(
        samples=samples,
        axes=description.axes if description else (),
        rate=description.rate if description else float(facts.rate),
        times=None,
        unit=description.unit if description else None,
        description=description,
        place=facts.place,
        comment=facts.comment or None,
    )


def describe(path: Path) -> SignalDescription | str | None:
    """Return the description in the file, a foreign comment, or None."""
    facts = _facts(path)
    return _description(facts, path) or facts.comment or None


def write(
    path: Path,
    signal: Signal,
    description: SignalDescription,
    *,
    suffix: str,
    subtype: str | None = None,
    full_scale: float | None = None,
) -> None:
    """Write ``signal`` in the format of ``suffix``; `ParameterError` if that or ``full_scale`` cannot hold it."""
    subtype = subtype or SUBTYPES[suffix][0]
    if subtype not in SUBTYPES[suffix]:
        raise ParameterError.one_of(f"subtype of {suffix}", SUBTYPES[suffix], subtype)
    rate = max(1, round(signal.rate))
    _check_limits(signal, suffix, rate, BITS[subtype])
    if subtype in ("FLOAT", "DOUBLE"):
        if full_scale not in (None, 1.0):
            raise ParameterError(f"full_scale is for integer samples, got {full_scale} for {subtype}")
        samples: NDArray[np.float32] | NDArray[np.int32] = signal.samples
    else:
        samples, full_scale = _integers(signal, BITS[subtype], full_scale)
        description = replace(description, full_scale=full_scale)
    comment = description.encode()
    # More than two channels or 16 bits need WAVE_FORMAT_EXTENSIBLE (Microsoft, multichannel audio with WAV).
    extensible = len(samples) > 2 or subtype in ("PCM_24", "PCM_32")
    form = "FLAC" if suffix == ".flac" else "WAVEX" if extensible else "WAV"
    # In memory, since libsndfile does not say why it cannot write to a file, such as a full disk.
    encoded = io.BytesIO()
    try:
        with soundfile.SoundFile(encoded, "w", rate, len(samples), subtype, format=form) as file:
            if suffix == ".flac":
                file.comment = comment
            file.write(samples.T)
    except soundfile.LibsndfileError as error:
        raise ParameterError(
            f"{signal.rate:g} Hz, {len(samples)} axes as {form} {subtype}: {one_line(error)}"
        ) from error
    if suffix == ".wav":
        _append_comment(encoded, comment)
        _clear_time(encoded)
    path.write_bytes(encoded.getbuffer())


def _name(path: Path) -> str | bytes:
    """Return a path as soundfile takes it; as bytes where its name need not be UTF-8."""
    return str(path) if os.name == "nt" else os.fsencode(path)


def _blocks(file: soundfile.SoundFile) -> Iterator[NDArray[Any]]:
    """Yield the available samples (time, axis): a damaged header may promise any number."""
    dtype = "float32" if file.subtype == "FLOAT" else "float64"
    while len(block := file.read(_BLOCK, dtype=dtype, always_2d=True)):
        yield block


def _facts(path: Path) -> _SoundInfo:
    if path.suffix.lower() in (".wav", ".rf64"):
        header = read_header(path)
        width = header.bits // 8

        def byte(axis: int, sample: int) -> str:
            return f"axis {axis}, sample {sample} (byte {header.start + (sample * header.channels + axis) * width})"

        return _SoundInfo(header.rate, header.channels, header.comment, byte)
    with path.open("rb") as stream:
        head = stream.read(4)
    if not head:
        raise DataError(path, "empty file")
    try:
        with soundfile.SoundFile(_name(path)) as file:
            for claimed, there in _CUT.findall(file.extra_info):
                if int(there) + _SLACK < int(claimed) < _UNKNOWN:
                    raise DataError(path, f"truncated: {claimed} bytes expected, {there} are there")
            return _SoundInfo(
                file.samplerate,
                file.channels,
                file.comment,
                lambda axis, sample: f"axis {axis}, sample {sample}",
            )
    except soundfile.LibsndfileError as error:
        kind = path.suffix[1:].upper()
        raise DataError(
            path, f"not a {kind} file, or damaged at byte 0, got {head!r}: {error.error_string}"
        ) from error


def _description(facts: _SoundInfo, path: Path) -> SignalDescription | None:
    description = decode(facts.comment or "", str(path))
    if description is None:
        return None
    if facts.rate != max(1, round(description.rate)) or facts.channels != len(description.axes):
        raise DataError(
            path,
            f"changed after it was described: described as {description.rate:g} Hz, {len(description.axes)} channels, "
            f"its header says {facts.rate} Hz, {facts.channels}; remove the comment",
        )
    return description


def _integers(signal: Signal, bits: int, full_scale: float | None) -> tuple[NDArray[np.int32], float]:
    """Return the samples as the upper ``bits`` of int32, and the value of full scale.

    By default full scale is the peak; or 1 for a signal of unit 1 that fits, so that sound is unchanged.
    """
    most = 2 ** (bits - 1)
    peak = float(np.abs(signal.samples).max())
    fixed = full_scale is not None
    if full_scale is None:
        full_scale = 1.0
        if signal.unit != "1" or not _fits(signal.samples, most, 1.0):
            full_scale = peak * most / (most - 1) or 1.0
    if not (full_scale > 0 and np.isfinite(full_scale)):
        raise ParameterError.must("full_scale", "be > 0 and finite", full_scale)
    if fixed and not _fits(signal.samples, most, full_scale):
        raise ParameterError.must("full_scale", f"hold the peak of {peak:g} {signal.unit}", full_scale)
    steps = np.round(signal.samples.astype(np.float64) / full_scale * most)
    return (np.clip(steps, -most, most - 1).astype(np.int64) << (32 - bits)).astype(np.int32), full_scale


def _fits(samples: NDArray[np.float32], most: int, full_scale: float) -> bool:
    steps = np.round(np.array([samples.min(), samples.max()], dtype=np.float64) / full_scale * most)
    return bool(steps[0] >= -most and steps[1] <= most - 1)


def _check_limits(signal: Signal, suffix: str, rate: int, bits: int) -> None:
    channels = len(signal.axes)
    if suffix == ".flac" and channels > _FLAC_CHANNELS:
        raise ParameterError(f"FLAC holds at most {_FLAC_CHANNELS} axes, got {channels}; write .wav or .npz")
    if suffix == ".flac" and rate > _FLAC_RATE:
        raise ParameterError(f"FLAC holds at most {_FLAC_RATE} Hz, got {rate}; write .wav or .npz")
    if suffix == ".wav" and signal.samples.size * bits // 8 > _LARGEST_WAV:
        raise ParameterError("WAV holds at most 4 GiB; write .npz or .flac, or cut the signal")


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
            raise DataError(path, "empty file")
        if head[:4] not in (b"RIFF", b"RIFX", b"RF64") or head[8:12] != b"WAVE":
            raise DataError(path, f"not a WAV file: expected RIFF … WAVE at byte 0, got {head!r}")
        return _header(file, path, length, ">" if head[:4] == b"RIFX" else "<")


def _header(file: BinaryIO, path: Path, length: int, order: str) -> WavHeader:
    form = data = comment = None
    large = 0
    offset = 12
    while offset + 8 <= length:
        file.seek(offset)
        name, size = struct.unpack(f"{order}4sI", file.read(8))
        if name == b"ds64":
            large = struct.unpack("<QQ", file.read(16))[1]
        if name == b"data" and size == _UNKNOWN_SIZE:
            size = large or length - offset - 8
        if offset + 8 + size > length:
            raise DataError(
                path,
                f"truncated: chunk {name.decode('latin-1')!r} at byte {offset} says {size} bytes, "
                f"{length - offset - 8} are there",
            )
        if name == b"fmt ":
            form = (offset, file.read(size))
        elif name == b"data":
            data = (offset + 8, size)
        elif name == b"LIST":
            comment = _comment(file.read(size)) or comment
        offset += 8 + size + size % 2
    if form is None or len(form[1]) < 16 or data is None:
        missing = "data" if form is not None and len(form[1]) >= 16 else "fmt"
        raise DataError(path, f"truncated: no {missing} chunk before the end at byte {length}")
    _, channels, rate, _, _, bits = struct.unpack(f"{order}HHIIHH", form[1][:16])
    if rate == 0:
        raise DataError(path, f"rate must be > 0 Hz, got 0 at byte {form[0] + 12}")
    if channels == 0:
        raise DataError(path, f"channels must be > 0, got 0 at byte {form[0] + 10}")
    if data[1] == 0:
        raise DataError(path, f"no samples: the data chunk before byte {data[0]} is empty")
    return WavHeader(channels, rate, bits, *data, comment)


def _comment(chunk: bytes) -> str | None:
    if chunk[:4] != b"INFO":
        return None
    offset = 4
    while offset + 8 <= len(chunk):
        name, size = struct.unpack_from("<4sI", chunk, offset)
        if name == b"ICMT":
            return chunk[offset + 8 : offset + 8 + size].split(b"\0")[0].decode("utf-8", "replace")
        offset += 8 + size + size % 2
    return None


def _append_comment(file: BinaryIO, text: str) -> None:
    """Append ``text`` (ASCII) to a RIFF file as the INFO chunk's ICMT.

    libsndfile writes such comments too, but silently drops them from some 4,000 characters on.
    """
    value = text.encode("ascii") + b"\0"
    info = b"INFO" + struct.pack("<4sI", b"ICMT", len(value)) + value + b"\0" * (len(value) % 2)
    end = file.seek(0, os.SEEK_END)
    file.write(b"\0" * (end % 2) + struct.pack("<4sI", b"LIST", len(info)) + info)
    length = file.tell()
    file.seek(4)
    file.write(struct.pack("<I", length - 8))


def _clear_time(file: io.BytesIO) -> None:
    """Set the time in the chunk PEAK, which stands before the samples of floats, to 0."""
    head, _, _ = bytes(file.getbuffer()[:256]).partition(b"data")
    if (peak := head.find(b"PEAK")) > 0:
        file.seek(peak + 12)  # name, size and version of the chunk
        file.write(bytes(4))
