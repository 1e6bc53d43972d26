"""Import of a data set from its files into a store, which appears complete or not at all."""

from __future__ import annotations

import hashlib
import inspect
from collections.abc import Callable, Mapping, Sequence
from contextlib import closing
from dataclasses import dataclass
from importlib.metadata import version
from pathlib import Path
from typing import Any, Protocol, Self

from tactogram.datasets.importer import ImportedPhotograph, Importer, ImportItem, LeftOut, importer
from tactogram.datasets.path_reading import PathReading
from tactogram.datasets.rates import CommonRates
from tactogram.datasets.ratings.ratings import Ratings
from tactogram.datasets.reading import Reading, by_kind, read_all
from tactogram.datasets.recording import Recording, item_of
from tactogram.datasets.store.pending import clear_stale_parts
from tactogram.datasets.store.photographs import Photograph, read_photograph
from tactogram.datasets.store.store import Store, open_store
from tactogram.datasets.store.writer import StoreWriter
from tactogram.datasets.store.writing import new_store
from tactogram.errors import DataError, Message, ParameterError, Remedy, TactogramError, printable
from tactogram.signal.io.atomic import sole_writer


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
    """Read the data set in ``path`` into a store at ``out``.

    An existing store at ``out`` is compared with the files instead, and left as it is if its content is the same. An
    import that was killed goes on, on the same machine, from at most `KEPT_S` before.

    Parameters
    ----------
    set_name : str
        Name of an importer.
    path, out : Path
        Folder to read, folder to make.
    options : mapping, optional
        Options of the importer, such as the sampling rate where the files do not state it.
    skip_bad : bool
        Report unreadable files and continue; otherwise the first one stops the import.
    workers : int, optional
        Processes that read; by default one per core.
    progress : callable, optional
        Called with the number of items read and the total.

    Returns
    -------
    dict
        ``set``, ``path``, ``out``, ``unchanged``, ``recordings``, ``photographs`` (of materials and of recordings),
        ``scores`` (of raters), ``sha256``, ``simulated``, ``licence``, lists of dicts ``duplicates`` (``id``,
        ``kept``, ``dropped``) and ``skipped`` (``source``, ``reason``), ``problems`` and ``notes`` (what was skipped,
        and what was left out or assumed, each kind once: ``text``, ``count``, ``files``), ``several_rates_hz`` (by
        stream, where there are several) and ``stale_parts`` (folders that another, killed import may have left);
        ``unverified``, what the importer assumes of files that were not at hand when it was written, if any.

    Raises
    ------
    ParameterError
        If there is no such importer, or it has no such option.
    DataError
        Naming the unreadable file, if ``out`` holds something else, or asking what the paths name.
    """
    path, out, options = Path(path), Path(out), options or {}
    data_set = find_set(set_name, path, options)
    if data_set.paths.question:
        raise DataError(data_set.paths.question)
    source, items = data_set.source, data_set.items
    ratings: Ratings | None = _optional(source, "ratings", path, {})
    facts: dict[str, Any] = {"name": set_name, "licence": source.LICENCE, "source": source.TITLE}
    job = _job(set_name, path, options, items)
    target: StoreComparison | StoreWriter
    with (
        sole_writer(out),
        StoreComparison(open_store(out), path)
        if out.exists()
        else new_store(out, **facts, simulated=False, job=job) as target,
    ):
        stale = clear_stale_parts(out)
        begun = target.store_so_far if isinstance(target, StoreWriter) else None
        rates = CommonRates() if begun is None else CommonRates.of(begun)
        sink = ImportSink(target, skip_bad=skip_bad, rates=rates)
        sink.add_all(data_set, workers=workers, progress=progress)
        if ratings is not None and (rated := target.items & set(ratings.items)):
            target.ratings = ratings.select(items=sorted(rated))
        if isinstance(target, StoreWriter):
            target.publish(out)
        else:
            target.finish()
    store = open_store(out)
    return {
        "set": set_name,
        "path": str(path),
        "out": str(out),
        "unchanged": isinstance(target, StoreComparison),
        "recordings": len(store),
        "photographs": len(store.photograph_keys()),
        "scores": 0 if store.facts.ratings is None else store.facts.ratings.rows,
        "sha256": store.sha256,
        "simulated": store.simulated,
        "licence": store.licence,
        "duplicates": target.duplicates,
        "several_rates_hz": sink.rates.several,
        "skipped": target.skipped,
        "problems": by_kind((each["source"], each["reason"]) for each in target.skipped),
        "notes": data_set.notes + by_kind(sink.notes),
        "stale_parts": [str(part) for part in stale],
    } | ({"unverified": source.UNVERIFIED} if hasattr(source, "UNVERIFIED") else {})


@dataclass(frozen=True)
class FoundSet:
    """Items and pictures of a data set in a folder."""

    set_name: str
    source: Importer
    items: list[ImportItem]
    pictures: list[ImportedPhotograph]
    left_out: list[tuple[str, str]]
    """Files that are not read, with reasons."""
    paths: PathReading
    """What the paths suggest, and what to ask about them."""

    @property
    def notes(self) -> list[dict[str, Any]]:
        """What is said of the folder as a whole, as `by_kind` does."""
        return by_kind(("", note) for note in self.paths.notes)

    @property
    def lacks_much(self) -> bool:
        """Whether a third of the files or more are left out."""
        others = len(self.items) + len(self.pictures)
        return bool(self.left_out) and 2 * len(self.left_out) >= others


def find_set(set_name: str, path: Path, options: Mapping[str, Any]) -> FoundSet:
    """Return what an import would read; `ParameterError` and `DataError` as `import_dataset`."""
    source = importer(set_name)
    if not path.is_dir():
        raise DataError(f"{path} must be a folder that holds the data set")
    _check_options(set_name, source, options)
    items = source.find(path, **options)
    pictures: list[ImportedPhotograph] = _optional(source, "photographs", path, options) or []
    if not items and not pictures:
        raise DataError(path, f"nothing to import as {set_name!r}; {source.TITLE} was not found there")
    left_out: list[tuple[str, str]] = _optional(source, "left_out", path, options) or []
    paths: PathReading | None = _optional(source, "paths", path, options)
    return FoundSet(set_name, source, items, pictures, left_out, paths or PathReading())


def _job(set_name: str, path: Path, options: Mapping[str, Any], items: Sequence[ImportItem]) -> str:
    """Return the identity of an import: version, folder, options, and sizes and times of the files."""
    digest = hashlib.sha256()
    digest.update(
        repr((version("tactogram"), set_name, str(path.resolve()), sorted(options.items()))).encode()
    )
    for item in items:
        stats = [file.stat() for file in item.paths if file.is_file()]
        digest.update(repr((item.name, [(f.st_size, f.st_mtime_ns) for f in stats])).encode(errors="replace"))
    return digest.hexdigest()


def _check_options(set_name: str, source: Importer, options: Mapping[str, Any]) -> None:
    parameters = inspect.signature(source.find).parameters.values()
    known = [p.name for p in parameters if p.kind is p.KEYWORD_ONLY]
    for name in options:
        if name not in known:
            raise ParameterError.one_of(f"options of {set_name}", known or ["none"], name)


def _optional(source: Importer, function_name: str, path: Path, options: Mapping[str, Any]) -> Any:
    """Call a function that an importer may define, with those options that it accepts; None if it is not defined."""
    function = getattr(source, function_name, None)
    if function is None:
        return None
    accepted = inspect.signature(function).parameters
    return function(path, **{name: value for name, value in options.items() if name in accepted})


class ImportTarget(Protocol):
    """Receiver of recordings and photographs."""

    skipped: list[Any]
    tasks_done: int

    def add(self, recording: Recording, photograph: Photograph | None = None) -> object:
        """Take a recording."""

    def add_photograph(self, photograph: Photograph, material: str, *, source: str = "") -> object:
        """Take a photograph of a material."""

    def keep(self, done: int) -> None:
        """Make a checkpoint after ``done`` items and pictures."""


class ImportSink:
    """Passes readings on to a target; an unusable one stops the import or, with ``skip_bad``, is listed."""

    def __init__(self, target: ImportTarget, *, skip_bad: bool, rates: CommonRates | None = None) -> None:
        self.target, self.skip_bad = target, skip_bad
        self.rates = CommonRates() if rates is None else rates
        self.needed_skip = False
        self.notes: dict[tuple[str, str], None] = {}
        """Items and notes of the recordings passed on."""
        self._photographs: dict[Path, Photograph | None] = {}

    def add_all(
        self,
        found: FoundSet,
        *,
        workers: int | None,
        progress: Callable[[int, int], None] | None,
    ) -> None:
        """Read every item and picture after those that the target has already."""
        if found.lacks_much and not self.skip_bad:
            files = len(found.left_out) + len(found.items) + len(found.pictures)
            many = f"in all {len(found.left_out)} of {files} files cannot be read: leave them out by"
            raise DataError(found.left_out[0][1], remedy=Remedy(many, "skip_bad"))
        for name, reason in found.left_out:
            self._report(name, reason)
        report = progress or (lambda done, total: None)
        before, count = self.target.tasks_done, len(found.items)
        total = count + len(found.pictures)
        readings = read_all(
            found.set_name, found.items[before:], workers, lambda done, _: report(before + done, total)
        )
        with closing(readings):
            for done, (item, result) in enumerate(readings, before + 1):
                self.add_item(item, result)
                self.target.keep(done)
            for done, picture in enumerate(found.pictures, count + 1):
                self.add_picture(picture)
                report(done, total)

    def add_item(self, item: ImportItem, result: Reading) -> None:
        """Pass on the recordings of an item, or skip it."""
        if isinstance(result, str):
            self._skip(item.name, result)
            return
        photograph = self._photograph(item)
        for recording in result:
            if isinstance(recording, LeftOut):
                take = self._skip if recording.broken else self._report
                take(f"{item.name}#{recording.part}", recording.reason)
                continue
            if recording.reading is not None:
                self.notes |= dict.fromkeys((item.name, note) for note in recording.reading.notes)
            shown = item.info.get("material", recording.material) == recording.material
            try:
                self.target.add(self.rates.united(recording), photograph if shown else None)
            except StoreMismatchError:
                raise
            except TactogramError as error:
                self._skip(item.name, error.message)

    def add_picture(self, picture: ImportedPhotograph) -> None:
        """Pass on a photograph of a material, or skip it."""
        try:
            photograph = read_photograph(picture.path, width_mm=picture.width_mm)
            self.target.add_photograph(photograph, picture.material, source=picture.name)
        except StoreMismatchError:
            raise
        except TactogramError as error:
            self._skip(picture.name, error.message)

    def _photograph(self, item: ImportItem) -> Photograph | None:
        """Return the photograph of an item, opened once however many items share it."""
        if item.image is None:
            return None
        if item.image not in self._photographs:
            self._photographs[item.image] = None
            try:
                self._photographs[item.image] = read_photograph(item.image, width_mm=item.image_width_mm)
            except DataError as error:
                self._skip(str(item.image), error.message)
        return self._photographs[item.image]

    def _skip(self, source: str, reason: str) -> None:
        if not self.skip_bad:
            raise DataError(reason, remedy=Remedy("leave it out by", "skip_bad"))
        self.needed_skip = True
        self._report(source, reason)

    def _report(self, source: str, reason: str) -> None:
        skipped = {"source": printable(source), "reason": Message(reason)}
        if skipped not in self.target.skipped:
            self.target.skipped.append(skipped)


class StoreMismatchError(DataError):
    """The files differ from what the store holds."""


class StoreComparison:
    """Compares recordings with an existing store; used like a `StoreWriter`."""

    def __init__(self, store: Store, path: Path) -> None:
        self.store, self.path = store, path
        self.duplicates: list[dict[str, str]] = []
        self.skipped: list[dict[str, str]] = []
        self.ratings: Ratings | None = None
        self.items: set[str] = set()
        self.tasks_done = 0
        self._recordings: dict[str, str] = {}
        self._photographs: set[tuple[str, str]] = set()

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *_: object) -> None:
        pass

    def add(self, recording: Recording, photograph: Photograph | None = None) -> None:
        """Compare a recording; an error if the store does not hold it."""
        where = recording.source or recording.id
        if earlier := self._recordings.get(recording.id):
            self.duplicates.append({"id": recording.id, "kept": earlier, "dropped": where})
            return
        if not self.store.holds(recording, photograph):
            raise self._mismatch(f"{where} is another or new")
        self._recordings[recording.id] = where
        if item := item_of(recording):
            self.items.add(item)

    def add_photograph(self, photograph: Photograph, material: str, *, source: str = "") -> None:
        """Compare a photograph of a material."""
        self._photographs.add((material, photograph.key))
        if photograph.key not in self.store.facts.photographs.get(material, {}):
            raise self._mismatch(f"{source} is another or new")
        self.items.add(material)

    def keep(self, done: int) -> None:
        """Do nothing: there is nothing to write."""

    def finish(self) -> None:
        """Raise an error if the store holds more."""
        stored = sum(len(sources) for sources in self.store.facts.photographs.values())
        if len(self._photographs) != stored:
            raise self._mismatch(f"{len(self._photographs)} photographs of materials here, {stored} there")
        if len(self._recordings) != len(self.store):
            raise self._mismatch(f"{len(self._recordings)} recordings here, {len(self.store)} there")
        # Ratings that were added to the store of a set without any are no mismatch.
        if self.ratings is not None and self.ratings.sha256 != self.store.facts.ratings_sha256:
            raise self._mismatch("its ratings differ")

    def _mismatch(self, how: str) -> StoreMismatchError:
        return StoreMismatchError(
            f"{self.store.path} exists and holds something else than {self.path} ({how}); "
            "remove it or choose another out"
        )
