"""Uploads: signals, tables, pictures, study files; measured before they are unpacked, and never run.

Each function takes the bytes and the name that the browser gave. The suffix says what it is to be, the content has to
agree, and what it would grow to is read from its own head first: samples of a WAV, members of a ZIP, pixels of a
picture. Nothing is unpickled (`numpy.load` with ``allow_pickle=False``) and nothing is executed. Every refusal is one
sentence with the name in it, and leaves nothing behind.
"""

from __future__ import annotations

import io
import re
import tempfile
import threading
import unicodedata
from pathlib import Path
from typing import Any, Literal

import soundfile

from tactogram.errors import DataError, ParameterError, TactogramError
from tactogram.signal import Image, Signal
from tactogram.signal.io import READABLE, decode_image, read_signal
from tactogram.signal.io.archives import check_archive
from tactogram.signal.io.atomic import atomic_write
from tactogram.signal.io.picture import picture_size
from tactogram.signal.io.riff import read_header
from tactogram.study.study_file import Study
from tactogram.text_files import decode_text, parse_toml

Kind = Literal["signal", "image", "table", "study"]

SUFFIXES: dict[Kind, tuple[str, ...]] = {
    "signal": READABLE,
    "image": (".png", ".jpg", ".jpeg", ".webp", ".tif", ".tiff", ".bmp", ".gif", ".ppm"),
    "table": (".csv", ".tsv", ".xlsx", ".parquet"),
    "study": (".toml",),
}
MIB = 2**20
MOST_BYTES: dict[str, int] = {".wav": 256 * MIB, ".flac": 128 * MIB, ".npz": 256 * MIB, ".toml": MIB}
"""By suffix; of all others `MOST_OTHER_BYTES`. A text table takes many times its size to read."""
MOST_OTHER_BYTES = 32 * MIB
MOST_SAMPLES = 2**25
"""Of all axes together: 11 minutes of one axis at 48 kHz, 256 MiB while it is read."""
MOST_UNPACKED = 8 * MOST_SAMPLES
"""Bytes of a ZIP's members together (NPZ, XLSX)."""
MOST_MEMBERS = 200
MOST_CHANNELS = 64
LONGEST_NAME = 160
"""Bytes of a name without its suffix; file systems take 255 of the whole."""
HEADS: dict[str, tuple[bytes, ...]] = {
    ".wav": (b"RIFF", b"RF64"),
    ".flac": (b"fLaC",),
    ".npz": (b"PK\x03\x04",),
    ".xlsx": (b"PK\x03\x04",),
    ".parquet": (b"PAR1",),
}
"""How a file of a suffix begins; those that are not here are text, or pictures, which Pillow tells apart."""
_TEXT = (".csv", ".tsv", ".txt", ".toml")
_RESERVED = {"con", "prn", "aux", "nul", *(f"{port}{n}" for port in ("com", "lpt") for n in range(1, 10))}
_saving = threading.Lock()


def safe_name(name: str) -> str:
    """Return a file's name that is safe in any folder: its last part, of letters, digits, ``.``, ``_`` and ``-``.

    Parameters
    ----------
    name : str
        As a browser sent it: maybe a path, maybe with control characters, maybe ``..``.
    """
    last = re.split(r"[/\\\0]", unicodedata.normalize("NFC", name))[-1]
    stem, dot, suffix = last.rpartition(".")
    if not dot:
        stem, suffix = last, ""
    stem = re.sub(r"[^\w-]+", "_", stem).strip("_")
    stem = stem.encode()[:LONGEST_NAME].decode("utf-8", "ignore").rstrip("_") or "upload"
    suffix = re.sub(r"[^A-Za-z0-9]", "", suffix)[:10].lower()
    if stem.lower() in _RESERVED:
        stem = f"_{stem}"
    return f"{stem}.{suffix}" if suffix else stem


def read_uploaded_signal(name: str, data: bytes, **options: Any) -> Signal:
    """Return the signal in an uploaded file.

    Parameters
    ----------
    name : str
        Its suffix is one of `tactogram.signal.io.READABLE`.
    data : bytes
    options
        As `tactogram.signal.io.read_signal` takes them: ``unit``, ``rate``, ``columns`` …

    Raises
    ------
    DataError, ParameterError
        One sentence that begins with the name.
    """
    name = checked(name, data, kind="signal")
    with tempfile.TemporaryDirectory(prefix="tactogram-") as folder:
        path = Path(folder) / name
        path.write_bytes(data)
        try:
            _check_samples(path)
            signal = read_signal(path, **options)
        except TactogramError as error:
            raise type(error)(
                str(error).replace(f"{path.parent}/", "").replace(f"{path.parent}\\", "")
            ) from None
        except Exception as error:  # whatever a reader trips over in a damaged file, the user needs its name
            raise DataError(f"{name}: not a readable signal: {_line(error)}") from None
    if signal.samples.size > MOST_SAMPLES:
        raise DataError(f"{name}: {_too_many(signal.samples.size)}")
    return signal


def read_uploaded_image(
    name: str, data: bytes, *, mm_per_pixel: float | None = None, width_mm: float | None = None
) -> Image:
    """Return the picture in an uploaded file; see `tactogram.signal.io.picture` for what is converted and refused.

    Parameters
    ----------
    name : str
    data : bytes
    mm_per_pixel, width_mm : float, optional
        Its scale; at most one.

    Raises
    ------
    DataError, ParameterError
        One sentence that begins with the name.
    """
    name = checked(name, data, kind="image")
    return decode_image(data, name=name, mm_per_pixel=mm_per_pixel, width_mm=width_mm)


def read_uploaded_study(name: str, data: bytes) -> Study:
    """Return the study in an uploaded TOML file. Its stimuli are looked for when it is begun, not here.

    Raises
    ------
    DataError, ParameterError
        One sentence that names file and key.
    """
    name = checked(name, data, kind="study")
    values = parse_toml(decode_text(data, name), name)
    values.setdefault("name", Path(name).stem.lower().replace("-", "_"))
    return Study.of(values, where=name)


def save_upload(folder: Path, name: str, data: bytes, *, kind: Kind) -> Path:
    """Keep an uploaded file in a folder, after its checks, under a safe name that nothing there has; return its path.

    It is written beside its place and renamed: there is the whole file or none. A link that lies there is not followed.

    Parameters
    ----------
    folder : Path
        Made if it is not there. The caller confines it to the workspace.
    name : str
    data : bytes
    kind : {"signal", "image", "table", "study"}

    Raises
    ------
    DataError, ParameterError
        One sentence that begins with the name. Nothing is written then.
    """
    safe = checked(name, data, kind=kind)
    if kind == "image":
        decode_image(data, name=safe)
    elif kind == "study":
        read_uploaded_study(safe, data)
    elif kind == "signal":
        read_uploaded_signal(safe, data)
    with _saving:
        path, count = folder / safe, 1
        while path.exists() or path.is_symlink():
            count += 1
            path = folder / f"{Path(safe).stem}-{count}{Path(safe).suffix}"
        with atomic_write(path) as part:
            part.write_bytes(data)
    return path


def checked(name: str, data: bytes, *, kind: Kind) -> str:
    """Return the safe name of an upload whose suffix, size and first bytes are those of its kind.

    Raises
    ------
    DataError, ParameterError
        One sentence that begins with the name.
    """
    safe = safe_name(name)
    suffix = Path(safe).suffix
    if suffix not in SUFFIXES[kind]:
        known = ", ".join(SUFFIXES[kind])
        raise ParameterError(f"{safe}: expected a {kind} in one of {known}, got {suffix or 'no suffix'}")
    most = MOST_BYTES.get(suffix, MOST_OTHER_BYTES)
    if not data:
        raise DataError(f"{safe}: empty file; choose another")
    if len(data) > most:
        raise DataError(f"{safe}: {_too_long(most)}, got {len(data) / MIB:.1f} MiB")
    if suffix in HEADS and not data.startswith(HEADS[suffix]):
        raise DataError(
            f"{safe}: not what its suffix says: expected {HEADS[suffix][0]!r} first, got {data[:4]!r}"
        )
    if suffix in _TEXT:
        decode_text(data, safe)
    if kind == "image":
        picture_size(data, name=safe)
    if suffix in (".npz", ".xlsx"):
        check_archive(io.BytesIO(data), safe, most_bytes=MOST_UNPACKED, most_members=MOST_MEMBERS)
    if suffix == ".parquet":
        from tactogram.datasets.parquet_table import check_parquet

        check_parquet(io.BytesIO(data), safe)
    return safe


def _check_samples(path: Path) -> None:
    """Refuse a sound that is too long once unpacked, from its head."""
    if path.suffix == ".wav":
        head = read_header(path)
        channels = head.channels
        samples = head.size // max(1, head.bits // 8)
    elif path.suffix == ".flac":
        facts = soundfile.info(str(path))
        channels, samples = facts.channels, facts.frames * facts.channels
    else:
        return
    if channels > MOST_CHANNELS:
        raise DataError(f"{path.name}: must have at most {MOST_CHANNELS} channels, got {channels}")
    if samples > MOST_SAMPLES:
        raise DataError(f"{path.name}: {_too_many(samples)}")


def _too_many(samples: int) -> str:
    return f"must have at most {MOST_SAMPLES} samples of all axes, got {samples}; cut it"


def _too_long(most: int) -> str:
    return f"must have at most {most // MIB} MiB"


def _line(error: Exception) -> str:
    return " ".join(str(error).split())[:200] or type(error).__name__
