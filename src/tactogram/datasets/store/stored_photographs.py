"""The photographs of a store: each stands once in ``images-*.parquet``, found by its key."""

from __future__ import annotations

from collections import OrderedDict
from collections.abc import Sequence
from functools import cached_property
from pathlib import Path
from threading import Lock
from typing import Any

import pyarrow as pa
import pyarrow.parquet as pq

from tactogram.datasets.store.layout import StoredFile
from tactogram.datasets.store.parquet import close_quietly, opened, plain_parquet, stored_file
from tactogram.datasets.store.pending import StagedFiles
from tactogram.datasets.store.photographs import Photograph
from tactogram.errors import DataError
from tactogram.signal import Image
from tactogram.signal.io.picture import decode_image, picture_size

DECODED_BYTES = 2**27
"""Unpacked photographs that are kept at hand: the same few are asked for again and again in training."""

COLUMNS = pa.schema({"key": pa.string(), "mm_per_pixel": pa.float64(), "image": pa.binary()})
"""One row, and one row group, is one photograph; ``image`` is an encoded picture."""


class PhotographFiles:
    """Those of the files ``stored`` in ``folder``; a file is read when something of it is asked for."""

    def __init__(self, folder: Path, stored: Sequence[StoredFile]) -> None:
        self.folder, self.stored = folder, stored
        self._decoded: OrderedDict[str, Image] = OrderedDict()
        self._decoding = Lock()

    @cached_property
    def keys(self) -> tuple[str, ...]:
        """The keys of all, in the order in which they were put in."""
        return tuple(self._places)

    def image(self, key: str) -> Image:
        """Return the photograph of this key; the last few asked for are kept unpacked.

        Raises
        ------
        DataError
            If there is none, or its file is damaged.
        """
        with self._decoding:
            if key in self._decoded:
                self._decoded.move_to_end(key)
                return self._decoded[key]
        found, name = self._encoded(key)
        image = decode_image(found["image"], mm_per_pixel=found["mm_per_pixel"], name=name)
        with self._decoding:
            self._decoded[key] = image
            held = sum(kept.pixels.nbytes for kept in self._decoded.values())
            while held > DECODED_BYTES:
                held -= self._decoded.popitem(last=False)[1].pixels.nbytes
        return image

    def size(self, key: str) -> tuple[int, int]:
        """Return rows and columns of the photograph of this key, without keeping it; raises as `image` does."""
        found, name = self._encoded(key)
        return picture_size(found["image"], name=name)

    def _encoded(self, key: str) -> tuple[dict[str, Any], str]:
        """Return the row of a photograph, and what to call it in errors."""
        if key not in self._places:
            raise DataError(f"{self.folder}: photograph {key} is missing; import the data again")
        path, row = self._places[key]
        [found] = pq.ParquetFile(path).read_row_group(row).to_pylist()
        return found, f"{path}, row {row}"

    @cached_property
    def _places(self) -> dict[str, tuple[Path, int]]:
        places: dict[str, tuple[Path, int]] = {}
        for stored in self.stored:
            path = self.folder / stored.file
            keys = opened(path, stored).read(columns=["key"])["key"].to_pylist()
            places |= {key: (path, row) for row, key in enumerate(keys)}
        return places


class PhotographWriter:
    """Writes photographs that are not there yet.

    Parameters
    ----------
    files : NewFiles
    images : sequence of StoredFile
        The files that are there already.
    keys : sequence of str
        The photographs that are there already.
    """

    def __init__(self, files: StagedFiles, images: Sequence[StoredFile], keys: Sequence[str]) -> None:
        self.images = list(images)
        """Those that are complete."""
        self.keys = set(keys)
        self._files = files
        self._path = files.folder
        self._file: pq.ParquetWriter | None = None
        self._rows = 0

    def add(self, photograph: Photograph) -> None:
        """Write ``photograph``, unless its key is there."""
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
        """Complete the file that is being written, if there is one."""
        if self._file is not None:
            self._file.close()
            self.images.append(stored_file(self._path, self._rows))
        self._file, self._rows = None, 0

    def abandon(self) -> None:
        """Close the file that is being written; the caller removes it."""
        close_quietly(self._file)
        self._file = None
