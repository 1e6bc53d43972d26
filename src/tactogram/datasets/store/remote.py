"""Files on an object store, such as S3, by URL; read through Arrow's file systems.

Credentials, region and endpoint are those of the environment or of AWS's configuration files (``AWS_ACCESS_KEY_ID``,
``AWS_PROFILE``, ``AWS_ENDPOINT_URL`` …). ``s3://``, ``gs://`` and whatever else `pyarrow.fs.FileSystem.from_uri` knows
are URLs.
"""

from __future__ import annotations

import re
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass, field
from functools import lru_cache
from pathlib import Path
from typing import Any

import pyarrow as pa
import pyarrow.fs as fs

from tactogram.errors import DataError, ParameterError, one_line
from tactogram.text_files import path_of

_URL = re.compile(r"(?P<scheme>[a-z][a-z0-9+.-]+)://(?P<rest>.*)", re.IGNORECASE)
_CREDENTIALS = re.compile(r"://[^/]*@")

BLOCK_BYTES, MOST_BLOCKS = 2**20, 64
"""Size of the blocks that are fetched, and how many are kept."""


def is_remote(path: object) -> bool:
    """Return whether ``path`` is a URL, or a `RemotePath`."""
    return isinstance(path, RemotePath) or (isinstance(path, str) and _URL.match(path) is not None)


def location(path: Path | RemotePath | str) -> Path | RemotePath:
    """Return a folder or file by its path or URL; `ParameterError` for a URL that no file system has."""
    if isinstance(path, RemotePath) or not (isinstance(path, str) and is_remote(path)):
        return path if isinstance(path, RemotePath) else path_of(path, "path")
    if _CREDENTIALS.search(path):
        raise ParameterError(
            "a URL must hold no credentials, which would be written into runs; give them in the environment "
            "(AWS_ACCESS_KEY_ID, AWS_SECRET_ACCESS_KEY)"
        )
    address, _, options = path.partition("?")
    try:
        system, inner = fs.FileSystem.from_uri(path)
    except (pa.ArrowException, OSError, ValueError) as error:
        raise ParameterError(f"{path}: not a URL of a store: {one_line(error)}") from error
    return RemotePath(system, inner.rstrip("/"), address.rstrip("/"), f"?{options}" if options else "")


def local(path: Path | RemotePath) -> Path:
    """Return a folder in which a store is changed; `ParameterError` for a remote one."""
    if isinstance(path, RemotePath):
        raise ParameterError(
            f"{path} is on an object store, where stores are not changed: `tactogram data copy` it to a folder, change "
            "that, and copy it to a new URL"
        )
    return path


@dataclass(frozen=True)
class RemotePath:
    """A file or folder of ``system``; ``address`` is its URL without ``options``."""

    system: fs.FileSystem = field(compare=False)
    path: str
    address: str
    options: str = ""

    def __str__(self) -> str:
        """Return the URL, with which it is found again."""
        return self.address + self.options

    def __truediv__(self, name: str) -> RemotePath:
        return RemotePath(self.system, f"{self.path}/{name}", f"{self.address}/{name}", self.options)

    def is_file(self) -> bool:
        """Return whether there is such a file; `DataError` if that is not known."""
        with errors(self):
            return bool(self.system.get_file_info(self.path).type == fs.FileType.File)

    def size(self) -> int:
        """Return the bytes of a file."""
        with errors(self):
            info = self.system.get_file_info(self.path)
            if info.type != fs.FileType.File:
                raise FileNotFoundError(self.path)
            return int(info.size)

    def _check_regular(self) -> None:
        """Refuse a pipe or a device at a ``file://`` URL, which would be read for ever."""
        if isinstance(self.system, fs.LocalFileSystem):
            self.size()

    def open(self) -> Any:
        """Return a ``pyarrow.NativeFile``, read at random."""
        self._check_regular()
        with errors(self):
            return self.system.open_input_file(self.path)

    def read_bytes(self) -> bytes:
        """Return the content of a file."""
        self._check_regular()
        with errors(self), self.system.open_input_stream(self.path) as file:
            return bytes(file.read())


@contextmanager
def errors(path: RemotePath) -> Iterator[None]:
    """Turn the errors of a file system into a `DataError` that names ``path``; a FileNotFoundError stays one."""
    try:
        yield
    except FileNotFoundError:
        raise
    except (OSError, pa.ArrowException) as error:
        raise DataError(
            path,
            f"{one_line(error)}; check the address, the network and the credentials (AWS_ACCESS_KEY_ID and "
            "AWS_SECRET_ACCESS_KEY, or AWS_PROFILE; AWS_ENDPOINT_URL)",
        ) from error


class BlockReader:
    """Reads remote files by blocks, of which it keeps the last ones. Safe for threads."""

    def __init__(self) -> None:
        self._opened = lru_cache(None)(RemotePath.open)
        self._block = lru_cache(MOST_BLOCKS)(self._fetched)

    def read(self, path: RemotePath, start: int, length: int) -> bytes:
        """Return ``length`` bytes from ``start`` on, fewer at the end of the file."""
        first, last = start // BLOCK_BYTES, (start + length - 1) // BLOCK_BYTES
        joined = b"".join(self._block(path, number) for number in range(first, last + 1))
        begin = start - first * BLOCK_BYTES
        return joined[begin : begin + length]

    def _fetched(self, path: RemotePath, number: int) -> bytes:
        file = self._opened(path)
        with errors(path):
            return bytes(file.read_at(BLOCK_BYTES, number * BLOCK_BYTES))


def readable(path: Path | RemotePath) -> Any:
    """Return what `pyarrow` reads: the path of a local file, or a remote one opened."""
    return path.open() if isinstance(path, RemotePath) else path


def arrow_place(path: Path | RemotePath) -> tuple[fs.FileSystem, str]:
    """Return Arrow's file system of a file or folder, and its path there."""
    return (path.system, path.path) if isinstance(path, RemotePath) else (fs.LocalFileSystem(), str(path))
