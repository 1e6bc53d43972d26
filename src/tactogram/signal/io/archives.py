"""Archives: ZIP without times, and (NPZ, XLSX, compressed tables) a check of the size before they are unpacked."""

from __future__ import annotations

import bz2
import gzip
import io
import lzma
import math
import re
import zipfile
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import IO, Any

import numpy as np

from tactogram.errors import DataError, TactogramError, one_line
from tactogram.text_files import check_regular

MIB = 2**20
SMALL = 256 * MIB
"""Unpacked size that any archive may have."""
MOST_GROWTH = 100
"""Unpacked over packed size of larger ones: measured signals compress to a third at best."""


_BESIDE = re.compile(r"__MACOSX|(^|/)meta/|(^|/)(Study)?(Metadata|Annotation)\.csv$")


class UndatedZip(zipfile.ZipFile):
    """Compressed archive to be written, whose bytes follow from the members' names and content alone."""

    def __init__(self, file: Path | IO[bytes]) -> None:
        super().__init__(file, "w", zipfile.ZIP_DEFLATED)

    def open(self, name: str | zipfile.ZipInfo, mode: Any = "r", *args: Any, **options: Any) -> IO[bytes]:
        """Open a member without its time, permissions and system."""
        if isinstance(name, zipfile.ZipInfo) and mode == "w":
            name.date_time, name.external_attr, name.create_system = (1980, 1, 1, 0, 0, 0), 0o644 << 16, 3
        return super().open(name, mode, *args, **options)


class UnpackedSizeError(DataError):
    """A file is too large once it is unpacked."""


def check_archive(
    file: IO[bytes], where: Path | str, *, most_bytes: int | None = None, most_members: int = 10_000
) -> None:
    """Raise a `DataError` if a file is not an archive, is too large unpacked, or has misleading or object arrays.

    Too large is an `UnpackedSizeError`.

    ``most_bytes`` is the unpacked size of all members, by default `SMALL`, or `MOST_GROWTH` times the packed size; the
    archive's directory guarantees it.
    """
    size = file.seek(0, 2)
    most = max(SMALL, MOST_GROWTH * size) if most_bytes is None else most_bytes
    with decoding(where, "truncated or damaged"), zipfile.ZipFile(file) as archive:
        problem = _problem(archive, most, most_members)
    if problem:
        raise DataError(where, problem)


@contextmanager
def decoding(source: Path | str, problem: str, *, remedy: str = "") -> Iterator[None]:
    """Raise a `DataError` for an empty file and for whatever a library raises for a damaged one; name the source."""
    if isinstance(source, Path) and source.exists():
        check_regular(source)
        if source.stat().st_size == 0:
            raise DataError(source, "empty file")
    try:
        yield
    except TactogramError as error:
        raise type(error)(source, error) from error
    except Exception as error:
        raise DataError(source, f"{problem}{reason(error)}", remedy=remedy) from error


def reason(error: Exception) -> str:
    """Return a library's words on what is wrong; none where it tripped, so that they are on its own code."""
    tripped = isinstance(error, TypeError | AttributeError | LookupError | AssertionError | NameError)
    return "" if tripped else f": {one_line(error)}"


def check_size(count: int, path: Path) -> None:
    """Raise an `UnpackedSizeError` if a file unpacks to more bytes than `SMALL`, or `MOST_GROWTH` times its size."""
    most = max(SMALL, MOST_GROWTH * path.stat().st_size)
    if count > most:
        raise UnpackedSizeError(
            path, f"must unpack to at most {most // MIB} MiB, got {count / MIB:.0f} MiB; cut it"
        )


def unpacked(path: Path) -> dict[str, bytes]:
    """Return the content of a .gz, .bz2 or .xz file, or of the texts in a .zip, by the path for errors.

    What phyphox and Sensor Logger write of the telephone beside the recordings is left out.
    """
    with decoding(path, "truncated or damaged"):
        raw, suffix = path.read_bytes(), path.suffix.lower()
        most = max(SMALL, MOST_GROWTH * len(raw))
        if suffix == ".zip":
            check_archive(io.BytesIO(raw), path)
            with zipfile.ZipFile(io.BytesIO(raw)) as archive:
                texts = [
                    name for name in archive.namelist() if name.lower().endswith((".csv", ".tsv", ".txt"))
                ]
                texts = [name for name in texts if not _BESIDE.search(name)]
                if not texts:
                    raise DataError(
                        path, "holds no .csv, .tsv or .txt; unpack it, and read its files one by one"
                    )
                return {f"{path}/{name}": archive.read(name) for name in texts}
        if suffix == ".xz":
            text = lzma.LZMADecompressor(memlimit=SMALL).decompress(raw, most + 1)
        else:
            with (gzip if suffix == ".gz" else bz2).open(io.BytesIO(raw)) as file:
                text = file.read(most + 1)
    check_size(len(text), path)
    return {str(path): text}


def _problem(archive: zipfile.ZipFile, most_bytes: int, most_members: int) -> str | None:
    """Return why an archive is refused, if it is; raise `UnpackedSizeError` if that is its size."""
    members = archive.infolist()
    unpacked = sum(member.file_size for member in members)
    if len(members) > most_members or unpacked > most_bytes:
        raise UnpackedSizeError(
            f"must unpack to at most {most_bytes // MIB} MiB in {most_members} parts, "
            f"got {unpacked / MIB:.0f} MiB in {len(members)}; cut it"
        )
    for member in members:
        if not member.filename.endswith(".npy"):
            continue
        with archive.open(member) as file:
            version = np.lib.format.read_magic(file)
            shape, _, dtype = (
                np.lib.format.read_array_header_1_0(file)
                if version == (1, 0)
                else np.lib.format.read_array_header_2_0(file)
            )
        if dtype.hasobject:
            return f"{member.filename[:60]} holds pickled objects, which are never loaded; save numbers"
        claimed = math.prod(shape) * dtype.itemsize
        if not 0 <= claimed <= member.file_size:
            return f"{member.filename[:60]} claims {claimed} bytes and holds {member.file_size}"
    return None
