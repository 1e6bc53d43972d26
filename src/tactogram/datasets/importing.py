"""The import of a data set: from its files to a store that is complete or not there. See `importer`."""

from __future__ import annotations

import inspect
import pkgutil
from collections.abc import Callable, Mapping
from contextlib import closing
from importlib import import_module
from pathlib import Path
from typing import Any, Self, cast

from tactogram.datasets import importers as package
from tactogram.datasets.importer import ImportedPhotograph, Importer, ImportItem
from tactogram.datasets.ratings.ratings import Ratings, item_of
from tactogram.datasets.reading import read_all
from tactogram.datasets.recording import Recording
from tactogram.datasets.store.pending import clear_stale_parts
from tactogram.datasets.store.photographs import Photograph, read_photograph
from tactogram.datasets.store.store import Store, open_store
from tactogram.datasets.store.writer import StoreWriter
from tactogram.datasets.store.writing import new_store
from tactogram.errors import DataError, ParameterError, TactogramError

__all__ = ["ImportItem", "ImportedPhotograph", "Importer", "import_dataset", "importers"]


def importers() -> dict[str, Importer]:
    """Return every importer by its ``NAME``: the modules of `tactogram.datasets.importers`."""
    modules = (import_module(f"{package.__name__}.{m.name}") for m in pkgutil.iter_modules(package.__path__))
    return dict(sorted((module.NAME, cast("Importer", module)) for module in modules))


def import_dataset(
    set_name: str,
    path: Path,
    out: Path,
    *,
    options: Mapping[str, Any] | None = None,
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
    options : mapping, optional
        What the importer lets one choose, such as the sampling rate where the files do not say it.
    skip_bad : bool
        Report files that cannot be read and go on; otherwise the first one stops the import.
    workers : int, optional
        Processes that read; by default one per core.
    progress : callable, optional
        Called with the number of items read and the total.

    Returns
    -------
    dict
        ``set``, ``path``, ``out``, ``unchanged``, ``recordings``, ``photographs`` (of materials and of recordings),
        ``scores`` (of raters), ``sha256``, ``simulated``, ``licence``, and
        lists of dicts ``duplicates`` (``id``, ``kept``, ``dropped``) and ``skipped`` (``source``, ``reason``),
        and ``stale_parts`` (what another, killed import may have left and nobody could tell).

    Raises
    ------
    ParameterError
        If there is no such importer, or it has no such option.
    DataError
        Naming the file that cannot be read, or if ``out`` holds something else.
    """
    path, out = Path(path), Path(out)
    importer = _importer(set_name)
    if not path.is_dir():
        raise DataError(f"{path} must be a folder that holds the data set")
    options = _options(importer, options or {})
    items = importer.find(path, **options)
    pictures: list[ImportedPhotograph] = _photographs(importer, path, options)
    if not items and not pictures:
        raise DataError(f"{path}: nothing to import as {set_name!r}; {importer.TITLE} was not found there")
    rated: Ratings | None = getattr(importer, "ratings", lambda _: None)(path)
    stale = clear_stale_parts(out)
    module: str = importer.__name__  # type: ignore[attr-defined]
    total = len(items) + len(pictures)
    shown = progress or (lambda done, total: None)
    readings = read_all(module, items, workers, lambda done, _: shown(done, total))
    take: _StoreComparison | StoreWriter
    if out.exists():
        take = _StoreComparison(open_store(out), path)
    else:
        take = new_store(out, name=set_name, licence=importer.LICENCE, source=importer.TITLE, simulated=False)
    intake = _ImportSink(take, skip_bad=skip_bad)
    with closing(readings), take:
        for item, result in readings:
            intake.item(item, result)
        for done, picture in enumerate(pictures, len(items) + 1):
            intake.picture(picture)
            shown(done, total)
        if rated is not None and (there := take.items & set(rated.items)):
            take.ratings = rated.select(items=sorted(there))
        if isinstance(take, StoreWriter):
            take.skipped.extend(intake.skipped)
            take.publish(out)
        else:
            take.finish()
    store = open_store(out)
    return {
        "set": set_name,
        "path": str(path),
        "out": str(out),
        "unchanged": isinstance(take, _StoreComparison),
        "recordings": len(store),
        "photographs": len(store.photograph_keys()),
        "scores": 0 if store.facts.ratings is None else store.facts.ratings.rows,
        "sha256": store.sha256,
        "simulated": store.simulated,
        "licence": store.licence,
        "duplicates": take.duplicates,
        "skipped": intake.skipped,
        "stale_parts": [str(part) for part in stale],
    }


class _ImportSink:
    """Hands on what was read; what cannot be used stops the import or, with ``skip_bad``, is listed."""

    def __init__(self, take: _StoreComparison | StoreWriter, *, skip_bad: bool) -> None:
        self.take, self.skip_bad = take, skip_bad
        self.skipped: list[dict[str, str]] = []
        self._photographs: dict[Path, Photograph | None] = {}

    def item(self, item: ImportItem, result: list[Recording] | str) -> None:
        """Hand on the recordings of an item, or say in a line why there are none."""
        if isinstance(result, str):
            self._bad(item.name, result)
            return
        photograph = self._photograph(item)
        for recording in result:
            try:
                self.take.add(recording, photograph)
            except _StoreMismatchError:
                raise
            except TactogramError as error:
                self._bad(item.name, str(error))

    def picture(self, picture: ImportedPhotograph) -> None:
        """Hand on a photograph of a material."""
        try:
            photograph = read_photograph(picture.path, width_mm=picture.width_mm)
            self.take.add_photograph(photograph, picture.material, source=picture.name)
        except _StoreMismatchError:
            raise
        except TactogramError as error:
            self._bad(picture.name, str(error))

    def _photograph(self, item: ImportItem) -> Photograph | None:
        """Return the photograph of an item, opened once however many items share it."""
        if item.image is None:
            return None
        if item.image not in self._photographs:
            self._photographs[item.image] = None
            try:
                self._photographs[item.image] = read_photograph(item.image, width_mm=item.image_width_mm)
            except DataError as error:
                self._bad(str(item.image), str(error))
        return self._photographs[item.image]

    def _bad(self, source: str, reason: str) -> None:
        if not self.skip_bad:
            raise DataError(f"{reason}; --skip-bad leaves it out")
        self.skipped.append({"source": source, "reason": reason})


def _importer(set_name: str) -> Importer:
    known = importers()
    if set_name not in known:
        raise ParameterError(f"data set must be one of {', '.join(known)}, got {set_name!r}")
    return known[set_name]


def _photographs(importer: Importer, path: Path, options: Mapping[str, Any]) -> list[ImportedPhotograph]:
    """Return the photographs of materials, told the options of the import that say something of them."""
    function = getattr(importer, "photographs", None)
    if function is None:
        return []
    known = inspect.signature(function).parameters
    found: list[ImportedPhotograph] = function(
        path, **{name: options[name] for name in options if name in known}
    )
    return found


def _options(importer: Importer, options: Mapping[str, Any]) -> Mapping[str, Any]:
    """Return ``options`` if the importer has them: they are the keyword-only parameters of its ``find``."""
    parameters = inspect.signature(importer.find).parameters.values()
    known = [p.name for p in parameters if p.kind is p.KEYWORD_ONLY]
    for name in options:
        if name not in known:
            raise ParameterError(
                f"options of {importer.NAME} must be among {', '.join(known) or 'none'}, got {name!r}"
            )
    return options


class _StoreMismatchError(DataError):
    """The files differ from what the store holds."""


class _StoreComparison:
    """Takes recordings as a writer does, and compares them with a store that is there already."""

    def __init__(self, store: Store, path: Path) -> None:
        self.store, self.path = store, path
        self.duplicates: list[dict[str, str]] = []
        self.ratings: Ratings | None = None
        self.items: set[str] = set()
        self._seen: dict[str, str] = {}
        self._shown: set[tuple[str, str]] = set()

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
        if item := item_of(recording):
            self.items.add(item)
        return True

    def add_photograph(self, photograph: Photograph, material: str, *, source: str = "") -> bool:
        new = (material, photograph.key) not in self._shown
        self._shown.add((material, photograph.key))
        if photograph.key not in self.store.facts.photographs.get(material, {}):
            raise self._different(f"{source} is another or new")
        self.items.add(material)
        return new

    def finish(self) -> None:
        there = sum(len(held) for held in self.store.facts.photographs.values())
        if len(self._shown) != there:
            raise self._different(f"{len(self._shown)} photographs of materials here, {there} there")
        if len(self._seen) != len(self.store):
            raise self._different(f"{len(self._seen)} recordings here, {len(self.store)} there")
        # Ratings that were added to a store of a set without any are its own affair.
        if self.ratings is not None and self.ratings.sha256 != self.store.facts.ratings_sha256:
            raise self._different("its ratings differ")

    def _different(self, how: str) -> _StoreMismatchError:
        return _StoreMismatchError(
            f"{self.store.path} is there already and holds something else than {self.path} ({how}); "
            "remove it or choose another --out"
        )
