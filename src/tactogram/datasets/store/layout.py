"""On-disk layout of a store: ``dataset.json``, Parquet shards, photographs, a sorted list of ids; checked if opened.

A shard has one row per recording. Its metadata is in plain columns named as in `RecordingInfo`; each stream adds
``acceleration_rate`` (Hz, or samples per mm), ``acceleration_axes`` (``"x,y,z"``), ``acceleration_length`` (samples per
axis) and one ``list<float>`` column per axis (``acceleration_x``, …), null where a recording lacks it. Units and
domains are the same in the whole store and are in ``dataset.json``. Shards need not have the same columns: a recording
with a further axis or stream starts another one (DuckDB: ``read_parquet('STORE/shard-*.parquet', union_by_name =
true)``).

Each photograph is stored once in ``images-*.parquet`` (``key``, ``mm_per_pixel``, ``image``: an encoded picture). A row
of a shard names its recording's own in ``image``; those of a material are listed in ``dataset.json`` under
``photographs``: source by key by material. Ratings are in the ``ratings-*.parquet`` that ``dataset.json`` names
(`tactogram.datasets.ratings.ratings`).

Samples are uncompressed, PLAIN, and one page per column and row group, so that those of one recording are contiguous in
the file and a window is read as a slice of it, however large the store is. Compression would prevent that, and saves
little on sensor noise.
"""

from __future__ import annotations

import hashlib
import json
from collections.abc import Iterator, Mapping
from contextlib import contextmanager, suppress
from dataclasses import asdict, dataclass, field, fields
from functools import partial
from pathlib import Path
from typing import Annotated, Any

import numpy as np
import pyarrow as pa
import pyarrow.parquet as pq
from pydantic import Field

from tactogram.datasets.recording import RecordingInfo
from tactogram.datasets.store.remote import RemotePath, readable
from tactogram.errors import DataError, ParameterError, printable
from tactogram.signal import Signal
from tactogram.signal.io.archives import decoding
from tactogram.signal.signal import Domain
from tactogram.text_files import parse_json, read_json
from tactogram.validation import facts_of

FORMAT = "tactogram-dataset"
VERSION = 1
FACTS = "dataset.json"

INFO_COLUMNS: Mapping[str, pa.DataType] = {
    "id": pa.string(),
    "material": pa.string(),
    "speed_mm_s": pa.float64(),
    "force_n": pa.float64(),
    "direction_deg": pa.float64(),
    "contactor": pa.string(),
    "session": pa.string(),
    "subject": pa.string(),
    "ratings": pa.map_(pa.string(), pa.float64()),
    "labels": pa.map_(pa.string(), pa.string()),
    "source": pa.string(),
    "history": pa.list_(pa.string()),
    "simulated": pa.bool_(),
    "image": pa.string(),
}
"""Columns of every shard: the fields of `RecordingInfo`, and the key of the photograph."""

ID_TABLE = np.dtype([("id", "S16"), ("facts", "S16"), ("shard", "<i4"), ("row", "<i4")])
"""Sorted list of ids: hash of the metadata, shard and row of each recording."""


FileName = Annotated[str, Field(pattern=r"^[\w.-]+$")]
"""Name of a file in the store's own folder."""


@dataclass(frozen=True)
class StoreStreamInfo:
    """Unit, domain (``"time"`` or ``"displacement"``) and axes of a stream in a whole store."""

    unit: str
    domain: Domain
    axes: Annotated[tuple[str, ...], Field(min_length=1)]

    def widened(self, name: str, signal: Signal, source: str) -> StoreStreamInfo:
        """Return this with the axes of ``signal`` added; `DataError` for another unit or domain."""
        if (signal.unit, signal.domain) != (self.unit, self.domain):
            raise DataError(
                source,
                f"stream {name!r} must be in {self.unit} over {self.domain} as in the rest of the "
                f"store, got {signal.unit} over {signal.domain}; put it into a store of its own",
            )
        return StoreStreamInfo(self.unit, self.domain, tuple(dict.fromkeys((*self.axes, *signal.axes))))


@dataclass(frozen=True)
class StoredFile:
    """One Parquet file of the store."""

    file: FileName
    rows: Annotated[int, Field(ge=0)]
    bytes: Annotated[int, Field(ge=0)]
    sha256: str


@dataclass(frozen=True)
class UnfinishedJob:
    """An import or simulation that has not added all of its recordings yet."""

    job: str
    """Identity: what is read or simulated, and by which version."""
    done: int
    """Number of its tasks whose recordings are in the store."""


@dataclass(frozen=True)
class StoreInfo:
    """Content of ``dataset.json``."""

    name: str
    licence: str
    source: str
    simulated: bool
    sha256: str
    streams: Mapping[str, StoreStreamInfo]
    shards: tuple[StoredFile, ...]
    images: tuple[StoredFile, ...]
    ids: FileName
    duplicates: tuple[Mapping[str, str], ...] = ()
    skipped: tuple[Mapping[str, str], ...] = ()
    photographs: Mapping[str, Mapping[str, str]] = field(default_factory=dict)
    """Source by key by material; recordings' own photographs are not among them."""
    ratings: StoredFile | None = None
    ratings_sha256: str = ""
    """Hash of the ratings themselves rather than the file."""
    unfinished: UnfinishedJob | None = None
    """Job that has yet to finish the store; None for a complete one."""

    @property
    def files(self) -> tuple[StoredFile, ...]:
        """All files but ``dataset.json`` and the list of ids."""
        return (*self.shards, *self.images, *([] if self.ratings is None else [self.ratings]))

    @property
    def rows(self) -> int:
        """Number of recordings."""
        return sum(shard.rows for shard in self.shards)

    def text(self) -> str:
        """Return the content of ``dataset.json``."""
        values = {"format": FORMAT, "version": VERSION, "recordings": self.rows} | asdict(self)
        if self.unfinished is None:
            del values["unfinished"]
        return json.dumps(values, indent=1, ensure_ascii=False) + "\n"

    @classmethod
    def load(cls, folder: Path | RemotePath) -> StoreInfo:
        """Read ``dataset.json``; `DataError` if it is missing, invalid, or of an unknown version."""
        path = folder / FACTS
        try:
            values = _facts_in(path)
        except FileNotFoundError:
            raise DataError(f"{folder} is not a store: {_found_instead(folder)}") from None
        if not isinstance(values, dict) or values.get("format") != FORMAT:
            raise DataError(f"{path} must say format {FORMAT!r}; this is not a store")
        if values.get("version") != VERSION:
            raise DataError(
                path,
                f"format version must be {VERSION}, got {values.get('version')!r}; "
                "import the data again, or use the tactogram that wrote it",
            )
        return facts_of(cls, values, where=path, remedy="import the data again")


def _facts_in(path: Path | RemotePath) -> Any:
    """Return the content of ``dataset.json``; FileNotFoundError if there is none."""
    if isinstance(path, RemotePath):
        content = path.read_bytes()
        read = partial(parse_json, content.decode(errors="replace"), str(path))
    elif path.is_file():
        read = partial(read_json, path)
    else:
        raise FileNotFoundError(path)
    try:
        return read()
    except DataError as error:
        raise DataError(f"{error}; import the data again") from error


def axis_column(stream: str, axis: str) -> str:
    """Return the column name of one axis."""
    return f"{stream}_{axis}"


def schema(streams: Mapping[str, StoreStreamInfo]) -> pa.Schema:
    """Return the columns of a shard that holds ``streams``; `ParameterError` if two would have the same name."""
    columns: list[tuple[str, pa.DataType]] = list(INFO_COLUMNS.items())
    for name, facts in streams.items():
        columns += [
            (f"{name}_rate", pa.float64()),
            (f"{name}_axes", pa.string()),
            (f"{name}_length", pa.int64()),
        ]
        columns += [(axis_column(name, axis), pa.list_(pa.float32())) for axis in facts.axes]
    names = [name for name, _ in columns]
    for name in names:
        if names.count(name) > 1:
            raise ParameterError(f"two columns would be called {name!r}; rename the stream or its axis")
    return pa.schema(columns)


def info_row(info: RecordingInfo, image: str | None) -> dict[str, Any]:
    """Return the scalar columns of one recording."""
    row: dict[str, Any] = {name: getattr(info, name) for name in INFO_COLUMNS if name != "image"}
    for name in ("speed_mm_s", "force_n", "direction_deg"):
        row[name] = None if row[name] is None else float(row[name])
    return row | {
        "ratings": sorted((str(k), float(v)) for k, v in info.ratings.items()),
        "labels": sorted((str(k), str(v)) for k, v in info.labels.items()),
        "history": list(info.history),
        "image": image,
    }


def row_info(row: Mapping[str, Any]) -> RecordingInfo:
    """Return the metadata in the scalar columns of one row."""
    values = {f.name: row[f.name] for f in fields(RecordingInfo)}
    values["ratings"] = dict(row["ratings"] or ())
    values["labels"] = dict(row["labels"] or ())
    values["history"] = tuple(row["history"] or ())
    return RecordingInfo(**values)


def facts_hash(recording: RecordingInfo, image: str | None) -> bytes:
    """Return 16 hex digits that identify the metadata of a recording; `DataError` for text that is not UTF-8."""
    text = json.dumps(info_row(recording, image), sort_keys=True, ensure_ascii=False)
    check_utf8(text, recording.source)
    return hashlib.sha256(text.encode()).hexdigest()[:16].encode()


def check_utf8(text: str, where: str) -> None:
    """Refuse text with bytes of a file name that is not UTF-8: no Parquet or JSON file can hold them."""
    if text != printable(text):
        raise DataError(where, "file names must be UTF-8; rename the file or folder")


def store_hash(
    ids: np.ndarray, photographs: Mapping[str, Mapping[str, str]], ratings_sha256: str = ""
) -> str:
    """Return the sha256 of a store's content, whatever the order or number of shards.

    ``ids`` is an array of `ID_TABLE`, sorted by id; empty photographs or ratings leave the hash of the rest unchanged.
    """
    digest = hashlib.sha256()
    digest.update(np.ascontiguousarray(ids["id"]).tobytes())
    digest.update(np.ascontiguousarray(ids["facts"]).tobytes())
    for material, held in sorted(photographs.items()):
        digest.update(f"\n{material}|{','.join(sorted(held))}".encode())
    if ratings_sha256:
        digest.update(f"\nratings|{ratings_sha256}".encode())
    return digest.hexdigest()


def file_size(path: Path | RemotePath) -> int:
    """Return the bytes of a file; FileNotFoundError if there is none."""
    return path.size() if isinstance(path, RemotePath) else path.stat().st_size


def file_hash(path: Path | RemotePath) -> str:
    """Return the sha256 of a file."""
    with path.open() if isinstance(path, RemotePath) else path.open("rb") as file:
        digest = hashlib.sha256()
        while part := file.read(2**22):
            digest.update(part)
        return digest.hexdigest()


def _found_instead(folder: Path | RemotePath) -> str:
    """Return what a place without ``dataset.json`` is, and what to do."""
    makes = "tactogram data import folder {} --out STORE"
    if isinstance(folder, RemotePath):
        return f"it has no {FACTS}; make one: {makes.format('RECORDINGS')}"
    if (folder / "recipe.toml").is_file():
        return "it is a run; give the data that it was trained on, or other recordings"
    if folder.is_dir():
        return f"it has no {FACTS}; make one of the recordings in it: {makes.format(folder)}"
    return (
        f"{'it is a file' if folder.exists() else 'no such folder'}; make one: {makes.format('RECORDINGS')}"
    )


class MissingFileError(DataError):
    """A file in ``dataset.json`` is missing: removed by hand, or replaced."""


def plain_parquet(path: Path, columns: pa.Schema) -> pq.ParquetWriter:
    """Return a writer whose column chunks are one plain page each."""
    return pq.ParquetWriter(
        path,
        columns,
        compression="none",
        use_dictionary=False,
        write_statistics=False,
        data_page_size=2**31 - 1,
    )


def close_quietly(file: pq.ParquetWriter | None) -> None:
    """Close a file that will be removed."""
    if file is not None:
        with suppress(OSError):  # a full disk fails again
            file.close()


def stored_file(path: Path, rows: int) -> StoredFile:
    """Return the entry in ``dataset.json`` of a written file of ``rows`` rows."""
    return StoredFile(path.name, rows, path.stat().st_size, file_hash(path))


@contextmanager
def reading(path: Path | RemotePath) -> Iterator[None]:
    """Raise a `DataError` for whatever reading a damaged file of a store raises, `MissingFileError` if it is gone."""
    remedy = "import the data again"
    try:
        with decoding(path if isinstance(path, Path) else str(path), "damaged", remedy=remedy):
            yield
    except DataError as error:
        if isinstance(error.__cause__, FileNotFoundError):
            raise MissingFileError(path, "missing", remedy=remedy) from error
        raise


def open_parquet(path: Path | RemotePath, stored: StoredFile) -> pq.ParquetFile:
    """Open ``path``, within `reading`; `DataError` if its size or rows differ from ``stored``."""
    size = file_size(path)
    if size != stored.bytes:
        raise DataError(f"must be {stored.bytes} bytes, got {size}")
    file = pq.ParquetFile(readable(path), pre_buffer=isinstance(path, RemotePath))
    if file.metadata.num_rows != stored.rows:
        raise DataError(f"must have {stored.rows} rows, got {file.metadata.num_rows}")
    return file
