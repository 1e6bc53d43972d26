"""Uploads: signals, tables, pictures and study files, checked before they are unpacked and never executed.

The suffix must match the content, and the unpacked size is read from the file's header first: samples of a WAV, members
of a ZIP, pixels of a picture. Nothing is unpickled (`numpy.load` with ``allow_pickle=False``). Each refusal is a
`DataError` or `ParameterError` of one sentence that begins with the file's name, and leaves nothing behind.
"""

from __future__ import annotations

import io
import re
import tempfile
import threading
import unicodedata
from pathlib import Path
from typing import Any, BinaryIO, Literal

import soundfile

from tactogram.errors import DataError, ParameterError, TactogramError
from tactogram.rendering import haptic_suffixes
from tactogram.signal import Image, Signal
from tactogram.signal.io import (
    JSON_LINES,
    MAGIC,
    PACKED,
    READABLE,
    SOUND,
    TEXTS,
    UnpackedSizeError,
    atomic_write,
    check_archive,
    check_unpacked,
    decode_image,
    picture_size,
    read_header,
    read_signal,
)
from tactogram.text_files import decode_text, detected_text, parse_toml
from tactogram_study.study_file import Study

Kind = Literal["signal", "image", "table", "study", "haptic"]

SUFFIXES: dict[Kind, tuple[str, ...]] = {
    "signal": READABLE,
    "image": (".png", ".jpg", ".jpeg", ".webp", ".tif", ".tiff", ".bmp", ".gif", ".ppm", ".heic", ".heif"),
    "table": (".csv", ".tsv", ".xlsx", ".parquet"),
    "study": (".toml",),
}
MIB = 2**20
MOST_BYTES: dict[str, int] = {".wav": 256 * MIB, ".flac": 128 * MIB, ".npz": 256 * MIB, ".toml": MIB}
"""By suffix, with `MOST_OTHER_BYTES` for all others: reading a text table takes many times its size."""
MOST_OTHER_BYTES = 32 * MIB
MOST_SAMPLES = 2**25
"""Of all axes: 11 minutes of one axis at 48 kHz, 256 MiB in memory."""
MOST_UNPACKED = 8 * MOST_SAMPLES
"""Unpacked bytes of a ZIP (NPZ, XLSX) or MAT file."""
MOST_MEMBERS = 200
MOST_CHANNELS = 64
LONGEST_NAME = 160
"""Bytes of a name without its suffix; file systems allow 255 in all."""
ZIPPED = (".npz", ".xlsx", ".xlsm", ".ods", ".zip")
HEADS: dict[str, tuple[bytes, ...]] = {
    ".wav": (b"RIFF", b"RF64"),
    ".flac": (b"fLaC",),
    **dict.fromkeys((".aif", ".aiff"), (b"FORM",)),
    **dict.fromkeys((".au", ".snd"), (b".snd",)),
    **dict.fromkeys((".ogg", ".oga", ".opus"), (b"OggS",)),
    ".caf": (b"caff",),
    ".w64": (b"riff",),
    ".rf64": (b"RF64", b"RIFF"),
    **dict.fromkeys(ZIPPED, (b"PK\x03\x04",)),
    ".xls": (b"\xd0\xcf\x11\xe0",),
    ".npy": (b"\x93NUMPY",),
    ".parquet": (b"PAR1",),
    **dict.fromkeys((".feather", ".arrow"), (b"ARROW1", b"FEA1")),
    ".mat": (b"MATLAB 5.0", b"MATLAB 7.3", MAGIC),
    **dict.fromkeys((".h5", ".hdf5"), (MAGIC,)),
    ".tdms": (b"TDSm",),
    ".gz": (b"\x1f\x8b",),
    ".bz2": (b"BZh",),
    ".xz": (b"\xfd7zXZ",),
    ".lvm": (b"LabVIEW Measurement",),
}
"""First bytes by suffix; all others are text, or pictures, which Pillow recognises."""
_TEXT = (*TEXTS, ".lvm", *JSON_LINES)
RESERVED = {"con", "prn", "aux", "nul", *(f"{port}{n}" for port in ("com", "lpt") for n in range(1, 10))}
"""Names that Windows keeps for devices."""
_saving = threading.Lock()


def safe_name(name: str) -> str:
    """Return a browser's file name without its path, in letters, digits, ``.``, ``_`` and ``-``: safe anywhere."""
    last = re.split(r"[/\\\0]", unicodedata.normalize("NFC", name))[-1]
    stem, dot, suffix = last.rpartition(".")
    if not dot:
        stem, suffix = last, ""
    inner = Path(stem).suffix.lower() if f".{suffix.lower()}" in PACKED else ""
    stem = stem[: len(stem) - len(inner)]
    stem = re.sub(r"[^\w-]+", "_", stem).strip("_")
    stem = stem.encode()[:LONGEST_NAME].decode("utf-8", "ignore").rstrip("_") or "upload"
    suffix = re.sub(r"[^A-Za-z0-9]", "", suffix)[:10].lower()
    if stem.lower() in RESERVED:
        stem = f"_{stem}"
    inner = inner if inner in TEXTS else re.sub(r"[^\w-]+", "_", inner)
    return f"{stem}{inner}.{suffix}" if suffix else stem


def most_bytes_of(suffix: str) -> int:
    """Return the largest size of an uploaded file."""
    return MOST_BYTES.get(suffix, MOST_OTHER_BYTES)


def read_uploaded_signal(name: str, data: bytes, **options: Any) -> Signal:
    """Return the signal in an uploaded file; ``options`` as for `tactogram.signal.io.read_signal`."""
    name = check_upload(name, data, kind="signal")
    with tempfile.TemporaryDirectory(prefix="tactogram-") as folder:
        path = Path(folder) / name
        path.write_bytes(data)
        try:
            _check_samples(path)
            signal = read_signal(path, **options)
        except TactogramError as error:
            raise type(error)(
                error.message.replace(f"{path.parent}/", "").replace(f"{path.parent}\\", "")
            ) from None
        except Exception as error:  # damaged files raise all kinds; the user needs the name
            reason = " ".join(str(error).split())[:200] or type(error).__name__
            raise DataError(name, f"not a readable signal: {reason}") from None
    if signal.samples.size > MOST_SAMPLES:
        raise DataError(name, _too_many(signal.samples.size))
    return signal


def read_uploaded_image(
    name: str, data: bytes, *, mm_per_pixel: float | None = None, width_mm: float | None = None
) -> Image:
    """Return the picture in an uploaded file; scale and conversion as for `tactogram.signal.io.decode_image`."""
    name = check_upload(name, data, kind="image")
    return decode_image(data, name=name, mm_per_pixel=mm_per_pixel, width_mm=width_mm)


def read_uploaded_study(name: str, data: bytes) -> Study:
    """Return the study in an uploaded TOML file, without its stimuli, which are checked when it is begun."""
    name = check_upload(name, data, kind="study")
    values = parse_toml(decode_text(data, name), name)
    values.setdefault("name", Path(name).stem.lower().replace("-", "_"))
    return Study.of(values, where=name)


def save_upload(
    folder: Path, name: str, data: bytes, *, kind: Kind, read: bool = True, **options: Any
) -> Path:
    """Check an uploaded file, store it in a folder under a safe unused name, and return its path.

    A signal is ``read`` with ``options`` as for `read_uploaded_signal`, unless its columns are asked about
    later. The file is written under a temporary name and
    renamed; symbolic links are not followed. The folder is created if needed; the caller confines it to the workspace.
    """
    safe = check_upload(name, data, kind=kind)
    if kind == "image":
        decode_image(data, name=safe)
    elif kind == "study":
        read_uploaded_study(safe, data)
    elif kind == "signal" and read:
        read_uploaded_signal(safe, data, **options)
    with _saving:
        path, count = folder / safe, 1
        while path.exists() or path.is_symlink():
            count += 1
            path = folder / f"{Path(safe).stem}-{count}{Path(safe).suffix}"
        with atomic_write(path) as part:
            part.write_bytes(data)
    return path


def check_upload(name: str, data: bytes, *, kind: Kind) -> str:
    """Return the safe name of an upload, after checking suffix, size and first bytes against its kind."""
    safe = safe_name(name)
    suffix = Path(safe).suffix
    # Those of haptic files may come from plug-ins.
    suffixes = haptic_suffixes() if kind == "haptic" else SUFFIXES[kind]
    if not safe.endswith(suffixes):
        known = ", ".join(suffixes)
        raise ParameterError(f"{safe}: expected one of {known}, got {suffix or 'no suffix'}")
    most = most_bytes_of(suffix)
    if not data:
        raise DataError(safe, "empty file; choose another")
    if len(data) > most:
        raise DataError(safe, f"must have at most {most // MIB} MiB, got {len(data) / MIB:.1f} MiB")
    if suffix in HEADS and not data.startswith(HEADS[suffix]):
        raise DataError(
            safe, f"content does not match the suffix: must begin with {HEADS[suffix][0]!r}, got {data[:4]!r}"
        )
    if suffix == ".toml":
        decode_text(data, safe)
    elif suffix in _TEXT:
        detected_text(data, safe)
    if kind == "image":
        picture_size(data, name=safe)
    _check_unpacked(io.BytesIO(data), safe)
    if suffix == ".parquet":
        from tactogram.datasets import check_parquet

        check_parquet(io.BytesIO(data), safe)
    return safe


def check_unpacked_size(path: Path) -> None:
    """Raise an `UnpackedSizeError` if a signal file is too large once unpacked; its reader says if it is damaged."""
    try:
        with path.open("rb") as file:
            _check_unpacked(file, path.name)
        _check_samples(path)
    except UnpackedSizeError:
        raise
    except (DataError, soundfile.SoundFileError):
        return


def _check_unpacked(file: BinaryIO, name: str) -> None:
    suffix, head = Path(name).suffix.lower(), file.read(8)
    if suffix in ZIPPED:
        check_archive(file, name, most_bytes=MOST_UNPACKED, most_members=MOST_MEMBERS)
    elif suffix == ".mat" and head[:7] == b"MATLAB ":
        check_unpacked(file, name, most_bytes=MOST_UNPACKED)


def _check_samples(path: Path) -> None:
    """Refuse a sound that is too long once unpacked, by its header."""
    if path.suffix.lower() == ".wav":
        head = read_header(path)
        channels = head.channels
        samples = head.size // max(1, head.bits // 8)
    elif path.suffix.lower() in SOUND:
        facts = soundfile.info(str(path))
        channels, samples = facts.channels, facts.frames * facts.channels
    else:
        return
    if channels > MOST_CHANNELS:
        raise UnpackedSizeError(path.name, f"must have at most {MOST_CHANNELS} channels, got {channels}")
    if samples > MOST_SAMPLES:
        raise UnpackedSizeError(path.name, _too_many(samples))


def _too_many(samples: int) -> str:
    return f"must have at most {MOST_SAMPLES} samples in all axes, got {samples}; cut it"
