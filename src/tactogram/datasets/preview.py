"""Preview of an import: layouts of the files, and what would be skipped. Nothing is written."""

from __future__ import annotations

import re
from collections import Counter
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import asdict, dataclass, field, replace
from itertools import islice
from pathlib import Path
from typing import Any

from tactogram.datasets.importer import LeftOut
from tactogram.datasets.importing import ImportSink, find_set
from tactogram.datasets.mapping import layouts_by_columns
from tactogram.datasets.rates import CommonRates
from tactogram.datasets.reading import by_kind, read_item
from tactogram.datasets.recording import Recording, item_of
from tactogram.datasets.store.layout import StoreStreamInfo
from tactogram.datasets.store.photographs import Photograph
from tactogram.errors import DataError, TactogramError, UnitError
from tactogram.signal.io import read_columns
from tactogram.signal.io.content import IGNORED, LABELS, RATE, TIME, UNCLEAR, ColumnUse, TableLayout
from tactogram.signal.units import parse_seconds, parse_unit

_PART = re.compile(r"#\d+$")
"""End of the source of a recording that is a part of a file."""


def preview_dataset(
    set_name: str,
    path: Path,
    *,
    options: Mapping[str, Any] | None = None,
    workers: int | None = None,
    progress: Callable[[int, int], None] | None = None,
) -> dict[str, Any]:
    """Read the data set in ``path`` as `import_dataset` does, and write nothing.

    Keys of the result: ``set``, ``path``, ``files`` (number), ``photographs`` (number), ``duplicates`` (number),
    ``several_rates_hz`` (by stream, where there are several), ``skipped`` (``source``, ``reason``; a part of a file has
    ``#`` in ``source``), ``problems`` and ``notes`` (as `import_dataset`), ``skipped_files`` (number of those that are
    skipped whole), ``needs_skip_bad`` (whether the import would stop without ``skip_bad``), ``question`` (what it would
    ask about the paths; empty if nothing), ``proposed_path`` (a pattern of them that says more than the material; empty
    if there is none) and ``layouts``, most files first. Each layout has ``files`` (number), ``example``, ``columns``
    (``heading``; ``role``: an axis, ``time``, ``rate``, ``material``, ``session``, ``subject``, ``trial``, ``ignored``
    or ``unclear``; ``unit`` as the heading spells it), ``tables`` (number of columns of each file, of takes of
    several), ``mapped`` (whether a mapping decided), ``skipped`` (number), ``materials`` (number of recordings by
    name), ``streams`` (by name: ``unit``, ``axes``), ``rates_hz`` (of the store), ``estimated_rates_hz`` (their range,
    or null), ``jitter_s`` (largest, rms), ``interpolated`` (samples), ``largest_gap_s`` and ``seconds`` (shortest,
    longest).

    Raises `ParameterError` or `DataError` as `import_dataset`, except for unreadable files.
    """
    data_set = find_set(set_name, Path(path), options or {})
    target = _PreviewTarget()
    sink = ImportSink(target, skip_bad=True)
    sink.add_all(data_set, workers=workers, progress=progress)
    items = {item.name: item for item in data_set.items}
    for skipped in target.skipped:
        if item := items.get(skipped["source"]):
            target.add_unreadable(item.name, item.paths[0], item.info.get("layouts", ()))
    whole = {each["source"] for each in target.skipped if each["source"].rpartition("#")[0] not in items}
    groups = sorted(target.groups.values(), key=lambda group: -len(group.files))
    return {
        "set": set_name,
        "path": str(path),
        "files": sum(len(item.paths) for item in data_set.items) + len(data_set.left_out),
        "photographs": len(target.photographs),
        "duplicates": target.duplicates,
        "several_rates_hz": sink.rates.several,
        "layouts": [group.facts() for group in groups],
        "skipped": target.skipped,
        "problems": by_kind((each["source"], each["reason"]) for each in target.skipped),
        "notes": data_set.notes + by_kind(sink.notes),
        "question": data_set.paths.question,
        "proposed_path": data_set.paths.proposed,
        "skipped_files": len(whole),
        "needs_skip_bad": data_set.lacks_much or sink.needed_skip,
    }


def preview_file(
    set_name: str, path: Path, name: str, *, options: Mapping[str, Any] | None = None
) -> Recording:
    """Return the first recording of an item of the data set, as it would be imported alone.

    Raises `ParameterError` or `DataError` as `import_dataset`; if the item is gone, or cannot be read.
    """
    data_set = find_set(set_name, Path(path), options or {})
    items = [item for item in data_set.items if name.startswith(item.name)]
    if not items:
        raise DataError(name, "no longer there")
    item = max(items, key=lambda item: len(item.name))
    result = read_item(set_name, item)
    if isinstance(result, str):
        raise DataError(result)
    recordings = [each for each in result if isinstance(each, Recording)]
    if not recordings:
        raise DataError(next(each.reason for each in result if isinstance(each, LeftOut)))
    return CommonRates().united(recordings[0])


def proposed_layouts(preview: Mapping[str, Any], layouts: Sequence[TableLayout] = ()) -> list[TableLayout]:
    """Return the layouts of a preview as a mapping would state them, those of files without columns left out.

    Of tables to which some of ``layouts`` apply, it is these.
    """
    known = layouts_by_columns(layouts)
    proposed: dict[tuple[str, ...], list[TableLayout]] = {}
    for uses, stream in _tables(preview):
        axes = {
            use.role: use.heading for use in uses if use.role not in (TIME, RATE, IGNORED, UNCLEAR, *LABELS)
        }
        time = next((use for use in uses if use.role == TIME), None)
        units = {use.unit for use in uses if use.heading in axes.values()}
        headings = tuple(use.heading for use in uses)
        if not uses or headings in proposed:
            continue
        if headings in known:
            proposed[headings] = known[headings]
            continue
        values = {
            "columns": headings,
            "axes": axes,
            "unit": _known(units.pop()) if len(units) == 1 else None,
            "stream": stream,
            "time": time and time.heading,
            **{use.role: use.heading for use in uses if use.role in LABELS},
            "time_unit": time.unit if time and parse_seconds(time.unit or "") else None,
        }
        proposed[headings] = [TableLayout.model_validate(values)]
    return [layout for alike in proposed.values() for layout in alike]


def _tables(preview: Mapping[str, Any]) -> Iterator[tuple[list[ColumnUse], str | None]]:
    """Yield what the columns of each table of each layout are read as, and their stream if the roles name one."""
    for facts in preview["layouts"]:
        uses = iter([ColumnUse(**column) for column in facts["columns"]])
        for count in facts["tables"] or [len(facts["columns"])]:
            table = list(islice(uses, count))
            streams = {use.role.rpartition(": ")[0] for use in table} - {""}
            named = streams.pop() if len(streams) == 1 else None
            yield [replace(use, role=use.role.removeprefix(f"{named}: ")) for use in table], named


def _known(unit: str | None) -> str | None:
    try:
        parse_unit(unit or "")
    except UnitError:
        return None
    return unit


@dataclass
class _Group:
    """Files with the same headings, or the same axes and rate where there are none."""

    example: str
    columns: tuple[ColumnUse, ...]
    tables: tuple[int, ...] = ()
    mapped: bool = False
    files: set[str] = field(default_factory=set)
    skipped: int = 0
    materials: Counter[str] = field(default_factory=Counter)
    streams: dict[str, dict[str, Any]] = field(default_factory=dict)
    rates: set[float] = field(default_factory=set)
    estimated: list[float] = field(default_factory=list)
    jitter_s: float = 0.0
    interpolated: int = 0
    largest_gap_s: float = 0.0
    seconds: list[float] = field(default_factory=list)

    def add(self, recording: Recording) -> None:
        self.files.add(_PART.sub("", recording.source))
        self.materials[item_of(recording) or "(none)"] += 1
        for name, signal in recording.streams.items():
            self.streams[name] = {"unit": signal.unit, "axes": list(signal.axes)}
            self.rates.add(signal.rate)
            self.seconds.append(len(signal) / signal.rate)
        timing = recording.reading.timing if recording.reading else None
        if timing is not None:
            self.estimated.append(timing.rate)
            self.jitter_s = max(self.jitter_s, timing.jitter_rms)
            self.interpolated += timing.dropped
            self.largest_gap_s = max(self.largest_gap_s, timing.largest_gap)

    def facts(self) -> dict[str, Any]:
        return {
            "files": len(self.files),
            "example": self.example,
            "tables": list(self.tables),
            "columns": [asdict(column) for column in self.columns],
            "mapped": self.mapped,
            "skipped": self.skipped,
            "materials": dict(self.materials),
            "streams": self.streams,
            "rates_hz": sorted(self.rates),
            "estimated_rates_hz": [min(self.estimated), max(self.estimated)] if self.estimated else None,
            "jitter_s": self.jitter_s,
            "interpolated": self.interpolated,
            "largest_gap_s": self.largest_gap_s,
            "seconds": [min(self.seconds), max(self.seconds)] if self.seconds else None,
        }


class _PreviewTarget:
    """Collects facts about recordings; used like a `StoreWriter`."""

    def __init__(self) -> None:
        self.skipped: list[dict[str, str]] = []
        self.duplicates = 0
        self.tasks_done = 0
        self.photographs: set[str] = set()
        self.groups: dict[Any, _Group] = {}
        self._streams: dict[str, StoreStreamInfo] = {}
        self._seen: dict[str, tuple[str | None, str]] = {}

    def add(self, recording: Recording, photograph: Photograph | None = None) -> None:
        item, where = item_of(recording), recording.source or recording.id
        earlier = self._seen.setdefault(recording.id, (item, where))
        if earlier[0] != item:
            raise DataError(
                where, f"the same samples as {earlier[1]}, but called {item!r} here and {earlier[0]!r} there"
            )
        self.duplicates += earlier[1] != where
        for name, signal in recording.streams.items():
            known = self._streams.get(name) or StoreStreamInfo(signal.unit, signal.domain, ())
            self._streams[name] = known.widened(name, signal, where)
        if photograph is not None:
            self.photographs.add(photograph.key)
        columns = recording.reading.columns if recording.reading else ()
        key: tuple[object, ...] = columns or tuple(
            (name, signal.unit, signal.axes, signal.rate) for name, signal in recording.streams.items()
        )
        tables = recording.reading.tables if recording.reading else ()
        group = self.groups.setdefault(key, _Group(recording.source, columns, tables))
        group.mapped |= recording.reading is not None and recording.reading.mapped
        group.add(recording)

    def add_photograph(self, photograph: Photograph, material: str, *, source: str = "") -> None:
        self.photographs.add(photograph.key)

    def keep(self, done: int) -> None:
        pass

    def add_unreadable(self, name: str, path: Path, layouts: Sequence[TableLayout]) -> None:
        """Count a skipped table among the files with its headings."""
        try:
            columns = read_columns(path, layouts=layouts)
        except TactogramError:
            return
        if not columns:
            return
        headings = [use.heading for use in columns]
        alike = (g for g in self.groups.values() if [use.heading for use in g.columns] == headings)
        group = next(alike, None) or self.groups.setdefault(columns, _Group(name, columns))
        group.files.add(name)
        group.skipped += 1
