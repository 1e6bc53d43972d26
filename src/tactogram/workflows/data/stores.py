"""Data sets: what can be imported, importing, looking at, checking and adding to a store."""

from __future__ import annotations

import math
from collections import Counter
from collections.abc import Mapping
from dataclasses import asdict
from pathlib import Path
from typing import Any

from tactogram.datasets import (
    Ratings,
    Recording,
    Store,
    add_recordings,
    materials_without_photographs,
    materials_without_recordings,
    open_store,
)
from tactogram.datasets.importer import importers
from tactogram.datasets.importing import import_dataset
from tactogram.datasets.store.compacting import compact
from tactogram.datasets.store.store import problems
from tactogram.errors import ParameterError
from tactogram.signal.io import read_file, read_image
from tactogram.workflows.progress import ProgressCallback, silent


def list_sets() -> dict[str, Any]:
    """Return what can be imported and what can be simulated.

    Returns
    -------
    dict
        ``import``: ``title``, ``licence`` and ``description`` by name; ``simulate``: one line by name.
    """
    from tactogram.datasets.simulate import simulated_sets

    return {
        "import": {
            name: {"title": i.TITLE, "licence": i.LICENCE, "description": i.DESCRIPTION}
            for name, i in importers().items()
        },
        "simulate": simulated_sets(),
    }


def import_store(
    set_name: str,
    path: Path | str,
    out: Path | str,
    *,
    options: Mapping[str, Any] | None = None,
    skip_bad: bool = False,
    workers: int | None = None,
    progress: ProgressCallback = silent,
) -> dict[str, Any]:
    """Import a data set; see `tactogram.datasets.importing.import_dataset`, whose report is returned."""

    def show(done: int, total: int) -> None:
        progress("reading", done, total)

    return import_dataset(
        set_name, Path(path), Path(out), options=options, skip_bad=skip_bad, workers=workers, progress=show
    )


def store_info(path: Path | str) -> dict[str, Any]:
    """Return what a store holds.

    Returns
    -------
    dict
        ``name``, ``licence``, ``source``, ``simulated``, ``sha256``, ``recordings``, ``bytes``, ``streams``
        (unit, domain, axes, rates, recordings and total seconds or mm by name), ``materials`` (recordings by
        name), and the numbers of different ``contactors``, ``sessions``, ``subjects``, ``images``; ``photographs``
        (of each material that has any, by name), ``without_photographs`` and ``without_recordings`` (materials that
        have only the other), ``ratings`` (`workflows.data.rating_summary.ratings_info`; null where there are none),
        ``duplicates`` and ``skipped`` as lists.
    """
    store = open_store(path)
    facts = store.facts
    materials = Counter(info.material or "(none)" for info in store.index)
    return {
        "name": store.name,
        "licence": store.licence,
        "source": facts.source,
        "simulated": store.simulated,
        "sha256": store.sha256,
        "recordings": len(store),
        "bytes": sum(file.bytes for file in (*facts.shards, *facts.images)),
        "streams": {name: _stream_facts(store, name) for name in store.streams},
        "materials": dict(sorted(materials.items())),
        "contactors": len({info.contactor for info in store.index} - {None}),
        "sessions": len({info.session for info in store.index} - {None}),
        "subjects": len({info.subject for info in store.index} - {None}),
        "images": len(store.photograph_keys()),
        "photographs": {name: len(keys) for name, keys in store.photographs_by_material.items()},
        "without_photographs": list(materials_without_photographs(store)),
        "without_recordings": list(materials_without_recordings(store)),
        "ratings": None if store.ratings is None else _ratings_info(store.ratings),
        "duplicates": [dict(entry) for entry in facts.duplicates],
        "skipped": [dict(entry) for entry in facts.skipped],
    }


def check_store(path: Path | str, *, progress: ProgressCallback = silent) -> dict[str, Any]:
    """Read all of a store and compare it with its hashes.

    Returns
    -------
    dict
        ``path``, ``recordings``, ``sha256``, ``ok``, and ``problems``, one line each.
    """
    store = open_store(path)
    found = problems(store, progress=lambda done, total: progress("checking", done, total))
    return {
        "path": str(path),
        "recordings": len(store),
        "sha256": store.sha256,
        "ok": not found,
        "problems": found,
    }


def compact_store(path: Path | str, *, progress: ProgressCallback = silent) -> dict[str, Any]:
    """Write the small shards of a store anew, as few large ones; see `tactogram.datasets.store.compacting`.

    Returns
    -------
    dict
        ``path``, ``recordings``, ``sha256`` (it stays as it was), ``shards_before``, ``shards``, ``bytes_before``,
        ``bytes`` (of the shards), ``rewritten`` (old shards that went into new ones) and ``cleared`` (files that a
        killed process had left).
    """
    found = compact(path, progress=lambda done, total: progress("checking", done, total))
    return {"path": str(path), "sha256": open_store(path).sha256, **asdict(found)}


def add_signal(
    path: Path | str,
    file: Path | str,
    *,
    material: str,
    stream: str | None = None,
    unit: str | None = None,
    rate: float | None = None,
    axes: tuple[str, ...] | None = None,
    photograph: Path | str | None = None,
    simulated: bool = False,
    **known: Any,
) -> dict[str, Any]:
    """Put the signal in ``file`` into a store as a recording of ``material``; it is on the disk when this returns.

    Parameters
    ----------
    path, file : Path
    material : str
    stream : str, optional
        What it is; by default the store's only stream.
    unit, rate, axes : optional
        As in `tactogram.signal.io.read_signal`, where the file does not say; the unit is by default that of
        the store's stream.
    photograph : path, optional
        A picture of what was touched.
    simulated : bool
        That a formula or a model made it. A file that says so of itself is taken at its word.
    **known
        Further fields of `RecordingInfo`: ``speed_mm_s``, ``force_n``, ``contactor``, …

    Returns
    -------
    dict
        ``path``, ``id``, ``material``, ``added`` (False if it was there), ``recordings``, ``sha256``, ``sha256_before``
        (runs that were trained on the store keep to the recordings they name), ``simulated`` (of this recording), and
        ``mixed``: whether simulated and measured recordings stand beside each other in the store now.

    Raises
    ------
    ParameterError
        If the store has several streams and none was named, or a number cannot be what it says.
    """
    store, file = open_store(path), Path(file)
    if stream is None:
        if len(store.streams) != 1:
            raise ParameterError(f"--stream must be one of {', '.join(store.streams)}, got none")
        [stream] = store.streams
    if unit is None and stream in store.streams:
        unit = store.streams[stream].unit
    for name, value in known.items():
        if isinstance(value, float) and not math.isfinite(value):
            raise ParameterError(f"{name} must be finite, got {value}")
        if name in ("speed_mm_s", "force_n") and value is not None and value < 0:
            raise ParameterError(f"{name} must be at least 0, got {value:g}")
    read = read_file(file, unit=unit, rate=rate, axes=axes)
    recording = Recording(
        streams={stream: read.signal},
        material=material,
        source=file.name,
        history=("added by hand",),
        # What a model trained on simulated data made, or the simulator, stays simulated.
        simulated=simulated or str(read.metadata.get("simulated", "")).lower() == "true",
        image=None if photograph is None else read_image(photograph),
        **known,
    )
    bigger = add_recordings(store, [recording], durable=True)
    return {
        "path": str(path),
        "id": recording.id,
        "material": material,
        "added": len(bigger) > len(store),
        "recordings": len(bigger),
        "sha256": bigger.sha256,
        "sha256_before": store.sha256,
        "simulated": recording.simulated,
        "mixed": len({info.simulated for info in bigger.index}) > 1,
    }


def _ratings_info(ratings: Ratings) -> dict[str, Any]:
    # Brings the statistics, which take longer to import than most stores to look at.
    from tactogram.workflows.data.rating_summary import ratings_info

    return ratings_info(ratings)


def _stream_facts(store: Store, name: str) -> dict[str, Any]:
    ids = [info.id for info in store.index if name in store.streams_of(info.id)]
    rates = sorted({store.rate(id, name) for id in ids})
    total = sum(store.length(id, name) / store.rate(id, name) for id in ids)
    facts = asdict(store.streams[name])
    length = "seconds" if facts["domain"] == "time" else "length_mm"
    return facts | {"rates": rates, "recordings": len(ids), length: round(total, 3)}
