"""The import of a data set: from its files to a store that is complete or not there. See `importer`."""

from __future__ import annotations

import pkgutil
from collections.abc import Callable
from contextlib import closing
from importlib import import_module
from pathlib import Path
from typing import Any, Self

import tactogram.datasets
from tactogram.datasets.importer import Importer, Item
from tactogram.datasets.photographs import Photograph, read_photograph
from tactogram.datasets.reading import read_all
from tactogram.datasets.recording import Recording
from tactogram.datasets.store import Store, open_store
from tactogram.datasets.writing import StoreWriter, clear_stale_parts, new_store
from tactogram.errors import DataError, ParameterError, TactogramError

__all__ = ["Importer", "Item", "import_dataset", "importers"]


def importers() -> dict[str, Importer]:
    """Return every importer by its ``NAME``: the modules of this package that offer what one has to."""
    found: dict[str, Importer] = {}
    for module in pkgutil.iter_modules(tactogram.datasets.__path__):
        if not module.ispkg:
            candidate = import_module(f"tactogram.datasets.{module.name}")
            if all(hasattr(candidate, name) for name in ("NAME", "TITLE", "LICENCE", "find", "read")):
                found[candidate.NAME] = candidate
    return dict(sorted(found.items()))


def import_dataset(
    set_name: str,
    path: Path,
    out: Path,
    *,
    skip_bad: bool = False,
    workers: int | None = None,
    progress: Callable[[int, int], None] | None = None,
) -> dict[str, Any]:
    """Read the data set in ``path`` into a store at ``out``, which appears complete or not at all.

    If ``out`` is there already, what is read is compared with it: the same content is left as it is.

    Parameters
    ----------
    set_name : str
        ``NAME`` of an importer.
    path, out : Path
        Folder to read, folder to make.
    skip_bad : bool
        Report files that cannot be read and go on; otherwise the first one stops the import.
    workers : int, optional
        Processes that read; by default one per core.
    progress : callable, optional
        Called with the number of items read and the total.

    Returns
    -------
    dict
        ``set``, ``path``, ``out``, ``unchanged``, ``recordings``, ``sha256``, ``simulated``, ``licence``, and
        lists of dicts ``duplicates`` (``id``, ``kept``, ``dropped``) and ``skipped`` (``source``, ``reason``),
        and ``stale_parts`` (what another, killed import may have left and nobody could tell).

    Raises
    ------
    ParameterError
        If there is no such importer.
    DataError
        Naming the file that cannot be read, or if ``out`` holds something else.
    """
    known = importers()
    if set_name not in known:
        raise ParameterError(f"data set must be one of {', '.join(known)}, got {set_name!r}")
    importer, path, out = known[set_name], Path(path), Path(out)
    if not path.is_dir():
        raise DataError(f"{path} must be a folder that holds the data set")
    items = importer.find(path)
    if not items:
        raise DataError(f"{path}: nothing to import as {set_name!r}; {importer.TITLE} was not found there")
    stale = clear_stale_parts(out)
    module: str = importer.__name__  # type: ignore[attr-defined]
    readings = read_all(module, items, workers, progress)
    take: _Comparison | StoreWriter
    if out.exists():
        take = _Comparison(open_store(out), path)
    else:
        take = new_store(out, name=set_name, licence=importer.LICENCE, source=importer.TITLE, simulated=False)
    skipped: list[dict[str, str]] = []

    def bad(source: str, reason: str) -> None:
        if not skip_bad:
            raise DataError(f"{reason}; --skip-bad leaves it out")
        skipped.append({"source": source, "reason": reason})

    photographs: dict[Path, Photograph | None] = {}
    with closing(readings), take:
        for item, result in readings:
            if isinstance(result, str):
                bad(item.name, result)
                continue
            if item.image is not None and item.image not in photographs:
                photographs[item.image] = None
                try:
                    photographs[item.image] = read_photograph(item.image, width_mm=item.image_width_mm)
                except DataError as error:
                    bad(str(item.image), str(error))
            for recording in result:
                try:
                    take.add(recording, photographs[item.image] if item.image is not None else None)
                except _DifferentError:
                    raise
                except TactogramError as error:
                    bad(item.name, str(error))
        if isinstance(take, StoreWriter):
            take.skipped.extend(skipped)
            take.publish(out)
        else:
            take.finish()
    store = open_store(out)
    return {
        "set": set_name,
        "path": str(path),
        "out": str(out),
        "unchanged": isinstance(take, _Comparison),
        "recordings": len(store),
        "sha256": store.sha256,
        "simulated": store.simulated,
        "licence": store.licence,
        "duplicates": take.duplicates,
        "skipped": skipped,
        "stale_parts": [str(part) for part in stale],
    }


class _DifferentError(DataError):
    """What is read is not what the store holds."""


class _Comparison:
    """Takes recordings as a writer does, and compares them with a store that is there already."""

    def __init__(self, store: Store, path: Path) -> None:
        self.store, self.path = store, path
        self.duplicates: list[dict[str, str]] = []
        self._seen: dict[str, str] = {}

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *_: object) -> None:
        pass

    def add(self, recording: Recording, photograph: Photograph | None = None) -> bool:
        where = recording.source or recording.id
        if recording.id in self._seen:
            self.duplicates.append({"id": recording.id, "kept": self._seen[recording.id], "dropped": where})
            return False
        if not self.store.holds(recording, photograph):
            raise self._different(f"{where} is another or new")
        self._seen[recording.id] = where
        return True

    def finish(self) -> None:
        if len(self._seen) != len(self.store):
            raise self._different(f"{len(self._seen)} recordings here, {len(self.store)} there")

    def _different(self, how: str) -> _DifferentError:
        return _DifferentError(
            f"{self.store.path} is there already and holds something else than {self.path} ({how}); "
            "remove it or choose another --out"
        )
