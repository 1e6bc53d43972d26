"""One recording more in a store, on the disk before anything else happens: what a recording session needs.

`add_recordings` is complete or not at all whatever happens to the *process*. Here the same holds for the machine: all
files and their folder are synchronised to the disk before ``dataset.json`` is replaced, and it after. What a kill
leaves behind on the way is removed by `recovered`.
"""

from __future__ import annotations

from pathlib import Path

from tactogram.datasets.recording import Recording
from tactogram.datasets.store.pending import clear_stale_parts, clear_unfinished
from tactogram.datasets.store.store import Store, open_store
from tactogram.datasets.store.writer import StoreWriter
from tactogram.datasets.store.writing import new_store
from tactogram.errors import DataError

CHANGED_MEANWHILE = 3
"""How often it is tried again where another process added something to the store at the same moment."""


def append_recording(path: Path, recording: Recording, *, name: str, licence: str, source: str = "") -> Store:
    """Put ``recording`` into the store at ``path``, made now if there is none, and return the store.

    When this returns the recording is on the disk; when it raises, the store is as it was.

    Parameters
    ----------
    path : Path
    recording : Recording
    name, licence, source : str
        Of a store that is made; see `create_store`.

    Raises
    ------
    DataError
        If the same samples are there already, or the recording cannot stand beside the others.
    OSError
        If the disk is full, or the folder cannot be written to.
    """
    if not path.exists():
        with new_store(
            path, name=name, licence=licence, source=source, simulated=False, durable=True
        ) as writer:
            writer.add(recording)
            writer.publish(path)
        return open_store(path)
    for attempt in range(CHANGED_MEANWHILE):
        store = open_store(path)
        with StoreWriter(store.path, store.facts, store, durable=True) as writer:
            if not writer.add(recording):
                raise DataError(
                    f"{path} holds the same samples already, as {store.info(recording.id).source or recording.id}; "
                    "is a recording being played instead of recorded?"
                )
            try:
                writer.finish()
                break
            except DataError:
                if attempt == CHANGED_MEANWHILE - 1:
                    raise
    return open_store(path)


def recovered(path: Path) -> tuple[Store | None, list[str]]:
    """Return the store at ``path``, None if there is none yet, and what of a killed process was removed there."""
    stale = [part.name for part in path.parent.glob(f"{path.name}.part-*")]
    left = {part.name for part in clear_stale_parts(path)}
    removed = [name for name in stale if name not in left]
    if not path.exists():
        return None, removed
    removed += clear_unfinished(path)
    return open_store(path), removed
