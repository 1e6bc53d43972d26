"""Compaction: many small shards, as a recording session leaves them, become few large ones that open faster.

The recordings stay the same and in order, and so do ids, splits and the store's sha256. New shards are written and
checked sample by sample; then ``dataset.json`` is replaced, atomically; then the old ones are removed. A kill before
that leaves the old store, after it the new one; other leftovers are noted and removed by the next process
(`tactogram.datasets.store.pending`). Processes with the store open can go on reading (`Store`).
"""

from __future__ import annotations

import os
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, replace
from itertools import groupby
from pathlib import Path

import numpy as np
import pyarrow as pa

from tactogram.datasets.recording import content_id
from tactogram.datasets.store import shard_writing
from tactogram.datasets.store.index import ShardIndex
from tactogram.datasets.store.layout import FACTS, StoredFile, StoreInfo, file_hash, schema
from tactogram.datasets.store.parquet import close_quietly, open_parquet, plain_parquet, stored_file
from tactogram.datasets.store.pending import StagedFiles, clear_unfinished, replacing
from tactogram.datasets.store.remote import local
from tactogram.datasets.store.store import Store, ids_problem, open_store
from tactogram.errors import DataError
from tactogram.signal.io.atomic import atomic_write, to_disk

SMALL = 0.5
"""Shards below this share of the full size are merged with their neighbours."""

ProgressCallback = Callable[[int, int], None]


@dataclass(frozen=True)
class CompactionResult:
    """Result of a compaction."""

    recordings: int
    shards_before: int
    shards: int
    bytes_before: int
    bytes: int
    rewritten: int
    """Number of old shards that were replaced."""
    cleared: int
    """Leftover files of killed processes."""


def compact(path: Path | str, *, progress: ProgressCallback | None = None) -> CompactionResult:
    """Merge runs of small shards of the store at ``path`` into few large ones.

    Raises
    ------
    DataError
        If the store is damaged, or another process adds to it at the same time; it is then unchanged.
    OSError
        If the disk is full: rewritten shards exist twice for a while.
    """
    store = open_store(path)
    path = local(store.folder)
    cleared = clear_unfinished(path)
    facts = store.facts
    runs = list(_runs(facts.shards))
    old = [shard for run in runs if len(run) > 1 for shard in run]
    if not old:
        return _result(facts, facts, 0, len(cleared))
    if problem := ids_problem(store):
        raise DataError(f"{problem}; nothing was changed, see data check")
    files = StagedFiles(path, adding=True, durable=True, purpose="compacting")
    named = ""
    try:
        new = _written(store, runs, files)
        named = new.ids
        _check(store, Store(path, new), runs, progress)
        # Noted before they are obsolete: a kill may come in between.
        files.note(*(path / shard.file for shard in old), path / facts.ids)
        files.to_disk()
        with replacing(path), atomic_write(path / FACTS, durable=True) as part:
            if StoreInfo.load(path) != facts:
                raise DataError(  # noqa: TRY301
                    f"{path} was changed by another process; nothing was changed here, repeat it"
                )
            files.begin(part)
            part.write_text(new.text(), encoding="utf-8")
        to_disk(path)
    except BaseException:
        # An interrupt may come just after the replacement: the new files then stay.
        if StoreInfo.load(path).ids != named:
            files.remove()
            files.forget_notes()
        raise
    remaining = False
    obsolete = [shard.file for shard in old] + ([facts.catalogue.file] if facts.catalogue else [])
    for name in (*obsolete, facts.ids):
        try:
            (path / name).unlink(missing_ok=True)
        except OSError:
            # On systems that keep files which are open elsewhere it stays noted, and the next process removes it.
            remaining = True
    if not remaining:
        files.forget_notes()
    return _result(facts, new, len(old), len(cleared))


def _result(before: StoreInfo, after: StoreInfo, rewritten: int, cleared: int) -> CompactionResult:
    return CompactionResult(
        recordings=after.rows,
        shards_before=len(before.shards),
        shards=len(after.shards),
        bytes_before=sum(shard.bytes for shard in before.shards),
        bytes=sum(shard.bytes for shard in after.shards),
        rewritten=rewritten,
        cleared=cleared,
    )


def _runs(shards: Sequence[StoredFile]) -> Iterator[list[StoredFile]]:
    """Yield the shards in order: small neighbours together, each of the others alone."""
    for small, run in groupby(shards, _is_small):
        if small:
            yield list(run)
        else:
            yield from ([shard] for shard in run)


def _is_small(shard: StoredFile) -> bool:
    return shard.bytes < SMALL * shard_writing.SHARD_BYTES and shard.rows < SMALL * shard_writing.SHARD_ROWS


def _written(store: Store, runs: Sequence[Sequence[StoredFile]], files: StagedFiles) -> StoreInfo:
    """Write the new shards and the new list of ids, and return the new content of ``dataset.json``."""
    facts, columns = store.facts, schema(store.streams)
    shards: list[StoredFile] = []
    for run in runs:
        if len(run) == 1:
            shards += run
            continue
        tables = (
            _whole(table, columns)
            for shard in run
            for table in _groups(local(store.folder) / shard.file, shard)
        )
        shards += _merged(tables, columns, files, first=len(shards))
    old, new = ShardIndex(facts.shards, store._ids), ShardIndex(tuple(shards), store._ids)
    ids = np.array(store._ids)
    place = np.array(old.begins)[ids["shard"]] + ids["row"]
    ids["shard"] = np.searchsorted(new.ends, place, side="right")
    ids["row"] = place - np.array(new.begins)[ids["shard"]]
    # Not under the name of the current list, which stays in use if the process is killed now.
    name = f"ids-{facts.sha256[:16]}-{os.urandom(4).hex()}.npy"
    path = local(store.folder) / name
    files.begin(path)
    with path.open("wb") as file:
        np.save(file, ids, allow_pickle=False)
    return replace(facts, shards=new.shards, ids=name, catalogue=None)


def _check(
    store: Store, written: Store, runs: Sequence[Sequence[StoredFile]], progress: ProgressCallback | None
) -> None:
    """Compare every rewritten recording with the original."""
    total = sum(shard.rows for run in runs if len(run) > 1 for shard in run)
    done = end = 0
    for run in runs:
        begin, end = end, end + sum(shard.rows for shard in run)
        for place in range(begin, end) if len(run) > 1 else ():
            was, now = store.index[place], written.index[place]
            streams = {name: written.signal(was.id, name) for name in written.streams_of(was.id)}
            same_picture = store.image_id(was.id) == written.image_id(was.id)
            if was != now or not same_picture or content_id(streams) != was.id:
                raise DataError(
                    f"{store.path}: {was.source or was.id} would change; nothing was changed, see data check"
                )
            done += 1
            if progress is not None:
                progress(done, total)


def _groups(path: Path, stored: StoredFile) -> Iterator[pa.Table]:
    """Yield the row groups of a shard, one at a time in memory.

    A damaged shard is a `DataError`: its new hash would hide the damage.
    """
    file = open_parquet(path, stored)
    if file_hash(path) != stored.sha256:
        raise DataError(
            f"{path}: changed since it was written (sha256 differs); nothing was changed, see data check"
        )
    for number in range(file.num_row_groups):
        yield file.read_row_group(number)


def _whole(table: pa.Table, columns: pa.Schema) -> pa.Table:
    """Return ``table`` with all columns of a store, null for streams or axes that its shard lacks."""
    return pa.concat_tables([columns.empty_table(), table], promote_options="default")


def _merged(
    tables: Iterator[pa.Table], columns: pa.Schema, files: StagedFiles, *, first: int
) -> Iterator[StoredFile]:
    """Write row groups into shards of full size, numbered from ``first``, and yield each complete one."""
    path, file, rows, size = files.folder, None, 0, 0
    try:
        for group in _gathered(tables):
            if file is None:
                path = files.parquet("shard", first)
                file = plain_parquet(path, columns)
            file.write_table(group, row_group_size=len(group))
            rows, size = rows + len(group), size + group.nbytes
            if size >= shard_writing.SHARD_BYTES or rows >= shard_writing.SHARD_ROWS:
                file.close()
                yield stored_file(path, rows)
                file, rows, size, first = None, 0, 0, first + 1
        if file is not None:
            file.close()
            yield stored_file(path, rows)
    finally:
        close_quietly(file)


def _gathered(tables: Iterator[pa.Table]) -> Iterator[pa.Table]:
    """Yield tables of about the size of a row group, each of one chunk: one page per column."""
    held: list[pa.Table] = []
    for table in tables:
        size, rows = (sum(sizes) for sizes in zip(*((t.nbytes, len(t)) for t in [*held, table]), strict=True))
        if held and (size > shard_writing.GROUP_BYTES or rows > shard_writing.GROUP_ROWS):
            yield pa.concat_tables(held).combine_chunks()
            held = []
        held.append(table)
    if held:
        yield pa.concat_tables(held).combine_chunks()
