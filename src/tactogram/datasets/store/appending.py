"""Durable appending of one recording to a store, for recording sessions.

`add_recordings` is atomic if the *process* is killed; here the same holds for a power cut: all files and their folder
are synchronised to the disk before ``dataset.json`` is replaced, and it after. `recover_store` removes what a killed
process left.
"""

from __future__ import annotations

from pathlib import Path

from tactogram.datasets.recording import Recording
from tactogram.datasets.store.pending import clear_stale_parts, clear_unfinished
from tactogram.datasets.store.store import Store, open_store
from tactogram.datasets.store.writer import StoreWriter
from tactogram.datasets.store.writing import new_store
from tactogram.errors import DataError

ATTEMPTS = 3
"""Attempts where another process adds to the store at the same moment."""


def append_recording(path: Path, recording: Recording, *, name: str, licence: str, source: str = "") -> Store:
    """Append ``recording`` to the store at ``path``, which is created if missing, and return the store.

    When this returns, the recording is on the disk; when it raises, the store is as it was. ``name``, ``licence`` and
    ``source`` are those of a new store; see `create_store`.

    Raises `DataError` if the store holds the same samples, or the recording does not fit the others; `OSError` if the
    disk is full, or the folder not writable.
    """
    if not path.exists():
        with new_store(
            path, name=name, licence=licence, source=source, simulated=False, durable=True
        ) as writer:
            writer.add(recording)
            writer.publish(path)
        return open_store(path)
    for attempt in range(ATTEMPTS):
        store = open_store(path)
        with StoreWriter(store.folder, store.facts, store, durable=True) as writer:
            if not writer.add(recording):
                raise DataError(
                    f"{path} holds the same samples already, as {store.info(recording.id).source or recording.id}; "
                    "is a recording being played instead of recorded?"
                )
            try:
                writer.finish()
                break
            except DataError:
                if attempt == ATTEMPTS - 1:
                    raise
    return open_store(path)


def recover_store(path: Path) -> tuple[Store | None, list[str]]:
    """Return the store at ``path``, None if missing, and the names of removed leftovers of killed processes."""
    stale = [part.name for part in path.parent.glob(f"{path.name}.part-*")]
    left = {part.name for part in clear_stale_parts(path)}
    removed = [name for name in stale if name not in left]
    if not path.exists():
        return None, removed
    removed += clear_unfinished(path)
    return open_store(path), removed
