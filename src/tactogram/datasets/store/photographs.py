"""Photographs of a store: each is encoded once in ``images-*.parquet`` and found by its key."""

from __future__ import annotations

import hashlib
import io
from collections import OrderedDict
from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path
from threading import Lock
from typing import Any

import pyarrow as pa
import pyarrow.parquet as pq
from PIL import Image as Pillow

from tactogram.datasets.store.layout import (
    StoredFile,
    close_quietly,
    open_parquet,
    plain_parquet,
    reading,
    stored_file,
)
from tactogram.datasets.store.pending import StagedFiles
from tactogram.datasets.store.remote import RemotePath, readable
from tactogram.errors import DataError
from tactogram.signal import Image
from tactogram.signal.io.picture import decode_image, is_plain, picture_bytes, picture_size

PICTURES = (".jpg", ".jpeg", ".png", ".webp", ".bmp", ".tif", ".tiff", ".heic", ".heif")
"""Suffixes of photographs."""
DECODED_BYTES = 2**27
"""Size of the cache of unpacked photographs: training uses the same few repeatedly."""
COLUMNS = pa.schema({"key": pa.string(), "mm_per_pixel": pa.float64(), "image": pa.binary()})
"""One row, and one row group, is one photograph; ``image`` is an encoded picture."""


@dataclass(frozen=True)
class Photograph:
    """A picture encoded as PNG, JPEG or WebP; ``key`` is its `image_key`."""

    key: str
    data: bytes
    mm_per_pixel: float | None = None


def image_key(image: Image) -> str:
    """Return 16 hex digits that identify pixels and scale."""
    digest = hashlib.sha256(f"{image.pixels.shape}|{image.mm_per_pixel!r}|".encode())
    digest.update(image.pixels.tobytes())
    return digest.hexdigest()[:16]


def photograph_of(image: Image) -> Photograph:
    """Return ``image`` encoded as PNG, without loss."""
    buffer = io.BytesIO()
    Pillow.fromarray(image.pixels).save(buffer, "PNG", compress_level=4)
    return Photograph(image_key(image), buffer.getvalue(), image.mm_per_pixel)


def read_photograph(path: Path, *, width_mm: float | None = None) -> Photograph:
    """Read a picture file, as it is or, if it needs conversion, as PNG; see `tactogram.signal.io.read_image`."""
    data = picture_bytes(path)
    image = decode_image(data, name=str(path), width_mm=width_mm)
    if not is_plain(data, name=str(path)):
        return photograph_of(image)
    return Photograph(image_key(image), data, image.mm_per_pixel)


class PhotographFiles:
    """Reader of the image files ``stored`` in ``folder``, each opened on first use."""

    def __init__(self, folder: Path | RemotePath, stored: Sequence[StoredFile]) -> None:
        self.folder, self.stored = folder, stored
        self._decoded: OrderedDict[str, Image] = OrderedDict()
        self._decoding = Lock()

    @cached_property
    def keys(self) -> tuple[str, ...]:
        """All keys, in the order in which they were added."""
        return tuple(self._places)

    def image(self, key: str) -> Image:
        """Return the photograph of this key, from the cache if possible; `DataError` if missing or damaged."""
        with self._decoding:
            if key in self._decoded:
                self._decoded.move_to_end(key)
                return self._decoded[key]
        row, name = self._row(key)
        image = decode_image(row["image"], mm_per_pixel=row["mm_per_pixel"], name=name)
        with self._decoding:
            self._decoded[key] = image
            size = sum(cached.pixels.nbytes for cached in self._decoded.values())
            while size > DECODED_BYTES:
                size -= self._decoded.popitem(last=False)[1].pixels.nbytes
        return image

    def size(self, key: str) -> tuple[int, int]:
        """Return rows and columns of the photograph of this key without caching it; errors as `image`."""
        row, name = self._row(key)
        return picture_size(row["image"], name=name)

    def _row(self, key: str) -> tuple[dict[str, Any], str]:
        """Return the row of a photograph, and its name in errors."""
        if key not in self._places:
            raise DataError(self.folder, f"photograph {key} is missing; import the data again")
        path, number = self._places[key]
        with reading(path):
            [row] = pq.ParquetFile(readable(path)).read_row_group(number).to_pylist()
        return row, f"{path}, row {number}"

    @cached_property
    def _places(self) -> dict[str, tuple[Path | RemotePath, int]]:
        places: dict[str, tuple[Path | RemotePath, int]] = {}
        for stored in self.stored:
            path = self.folder / stored.file
            with reading(path):
                keys = open_parquet(path, stored).read(columns=["key"])["key"].to_pylist()
            places |= {key: (path, row) for row, key in enumerate(keys)}
        return places


class PhotographWriter:
    """Writes photographs whose keys are new; ``images`` and ``keys`` are the stored files and photographs."""

    def __init__(self, files: StagedFiles, images: Sequence[StoredFile], keys: Sequence[str]) -> None:
        self.images = list(images)
        """Complete files."""
        self.keys = set(keys)
        self._files = files
        self._path = files.folder
        self._file: pq.ParquetWriter | None = None
        self._rows = 0

    def add(self, photograph: Photograph) -> None:
        """Write ``photograph``, unless its key is stored."""
        if photograph.key in self.keys:
            return
        if self._file is None:
            self._path = self._files.parquet("images", len(self.images))
            self._file = plain_parquet(self._path, COLUMNS)
        row = {"key": photograph.key, "mm_per_pixel": photograph.mm_per_pixel, "image": photograph.data}
        self._file.write_table(pa.Table.from_pylist([row], schema=COLUMNS))
        self.keys.add(photograph.key)
        self._rows += 1

    def close(self) -> None:
        """Complete the current file, if there is one."""
        if self._file is not None:
            self._file.close()
            self.images.append(stored_file(self._path, self._rows))
        self._file, self._rows = None, 0

    def abandon(self) -> None:
        """Close the current file; the caller removes it."""
        close_quietly(self._file)
        self._file = None
