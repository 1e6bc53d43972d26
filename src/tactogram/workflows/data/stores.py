"""Data sets: import, and inspection, check and extension of a store."""

from __future__ import annotations

from collections import Counter
from dataclasses import asdict
from functools import partial
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
from tactogram.datasets.mapping import read_mapping, write_mapping
from tactogram.datasets.preview import preview_dataset, proposed_layouts
from tactogram.datasets.rates import CommonRates
from tactogram.datasets.recording import FileReading
from tactogram.datasets.store.remote import is_remote
from tactogram.datasets.store.store import problems
from tactogram.datasets.store.writing import copy_store
from tactogram.errors import ParameterError
from tactogram.signal.io import read_file, read_image
from tactogram.signal.io.atomic import check_writable
from tactogram.workflows.data.requests import AdditionRequest, ImportRequest
from tactogram.workflows.progress import ProgressCallback, silent
from tactogram.workflows.request import takes


def list_sets() -> dict[str, Any]:
    """Return the data sets that can be imported and simulated.

    Keys of the result: ``import``: ``title``, ``licence`` and ``description`` by name; ``simulate``: one line by name.
    """
    from tactogram.datasets.simulate import simulated_sets

    return {
        "import": {
            name: {"title": i.TITLE, "licence": i.LICENCE, "description": i.DESCRIPTION}
            for name, i in importers().items()
        },
        "simulate": simulated_sets(),
    }


@takes(ImportRequest)
def import_store(request: ImportRequest) -> dict[str, Any]:
    """Import a data set; see `tactogram.datasets.importing.import_dataset`, whose report is returned.

    With ``preview`` nothing but the file ``save_mapping`` is written, and the result is that of
    `tactogram.datasets.preview.preview_dataset` with ``mapping`` (the file written, if any) and ``unused_layouts``
    (columns of layouts in ``mapping`` that no file has).
    """
    if request.preview:
        return _preview(request)
    if request.save_mapping is not None:
        raise ParameterError("save_mapping must come with `preview`")
    if request.out is None:
        raise ParameterError("out must be given, except with `preview`")
    if is_remote(request.out):
        raise ParameterError(
            f"out must be a folder, got {request.out}; `tactogram data copy` the store there afterwards"
        )
    return import_dataset(
        request.set_name,
        Path(request.path),
        Path(request.out),
        options=_options(request),
        skip_bad=request.skip_bad,
        workers=request.workers,
        progress=partial(request.progress, "reading"),
    )


def _options(request: ImportRequest) -> dict[str, Any]:
    options = dict(request.options or {})
    if request.mapping is not None:
        options["mapping"] = read_mapping(Path(request.mapping))
    return options


def _preview(request: ImportRequest) -> dict[str, Any]:
    saved = None if request.save_mapping is None else Path(request.save_mapping)
    if saved is not None:
        if saved.exists():
            raise ParameterError(
                f"save_mapping must be a new file, {saved} exists; remove it or choose another"
            )
        check_writable(saved)
    options = _options(request)
    facts = preview_dataset(
        request.set_name,
        Path(request.path),
        options=options,
        workers=request.workers,
        progress=partial(request.progress, "reading"),
    )
    layouts = options["mapping"].layout if request.mapping is not None else ()
    if saved is not None:
        write_mapping(saved, proposed_layouts(facts, layouts))
    met = [[column["heading"] for column in layout["columns"]] for layout in facts["layouts"]]
    unused = [list(layout.columns) for layout in layouts if list(layout.columns) not in met]
    return facts | {"mapping": None if saved is None else str(saved), "unused_layouts": unused}


def copy(source: Path | str, target: Path | str, *, progress: ProgressCallback = silent) -> dict[str, Any]:
    """Copy a store to a folder or a URL; see `tactogram.datasets.store.writing.copy_store`.

    Keys of the result: ``path`` (of the copy), ``recordings``, ``sha256``, ``bytes``.
    """
    store = copy_store(source, target, progress=partial(progress, "copying"))
    return {
        "path": str(store.path),
        "recordings": len(store),
        "sha256": store.sha256,
        "bytes": sum(file.bytes for file in store.facts.files),
    }


def store_info(path: Path | str) -> dict[str, Any]:
    """Return a description of a store.

    Keys of the result: ``name``, ``licence``, ``source``, ``simulated``, ``sha256``, ``recordings``, ``bytes``,
    ``streams`` (unit, domain, axes, rates, recordings and total seconds or mm by name), ``materials`` (recordings by
    name), and the numbers of different ``contactors``, ``sessions``, ``subjects``, ``images``; ``photographs`` (of each
    material that has any, by name), ``without_photographs`` and ``without_recordings`` (materials that have only the
    other), ``ratings`` (`workflows.data.rating_summary.ratings_info`; null where there are none), ``duplicates`` and
    ``skipped`` as lists.
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

    Keys of the result: ``path``, ``recordings``, ``sha256``, ``ok``, and ``problems``, one line each.
    """
    store = open_store(path)
    found = problems(store, progress=partial(progress, "checking"))
    return {
        "path": str(path),
        "recordings": len(store),
        "sha256": store.sha256,
        "ok": not found,
        "problems": found,
    }


@takes(AdditionRequest)
def add_signal(request: AdditionRequest) -> dict[str, Any]:
    """Add a signal file to a store as a recording; it is on the disk when this returns.

    The unit is by default that of the store's stream, and so is a rate estimated from time stamps if it is close. A
    file that says it is simulated is taken as simulated.

    Keys of the result: ``path``, ``id``, ``material``, ``added`` (False for a duplicate), ``recordings``, ``sha256``,
    ``sha256_before`` (runs trained on the store keep the recordings they name), ``simulated`` (of this recording), and
    ``mixed``: whether the store now has both simulated and measured recordings.

    Raises `ParameterError` if the store has several streams and ``stream`` is None.
    """
    store, file, stream = open_store(request.path), Path(request.file), request.stream
    if stream is None:
        if len(store.streams) != 1:
            raise ParameterError(f"stream must be one of {', '.join(store.streams)}, got none")
        [stream] = store.streams
    unit = request.unit
    if unit is None and stream in store.streams:
        unit = store.streams[stream].unit
    read = read_file(file, **request.reading | {"unit": unit})
    recording = Recording(
        streams={stream: read.signal},
        material=request.material,
        source=file.name,
        history=("added by hand",),
        # The output of a simulator, or of a model trained on simulated data, stays simulated.
        simulated=request.simulated or str(read.metadata.get("simulated", "")).lower() == "true",
        image=None if request.photograph is None else read_image(request.photograph),
        speed_mm_s=request.speed_mm_s,
        force_n=request.force_n,
        contactor=request.contactor,
        session=request.session,
        subject=request.subject,
        reading=FileReading(
            read.columns, False, read.timing, read.timing is not None and request.rate is None
        ),
    )
    recording = CommonRates.of(store).united(recording)
    bigger = add_recordings(store, [recording], durable=True)
    return {
        "path": str(request.path),
        "id": recording.id,
        "material": request.material,
        "added": len(bigger) > len(store),
        "recordings": len(bigger),
        "sha256": bigger.sha256,
        "sha256_before": store.sha256,
        "simulated": recording.simulated,
        "mixed": len({info.simulated for info in bigger.index}) > 1,
    }


def _ratings_info(ratings: Ratings) -> dict[str, Any]:
    # Imports statistics, which takes longer than reading most stores.
    from tactogram.workflows.data.rating_tables import ratings_info

    return ratings_info(ratings)


def _stream_facts(store: Store, name: str) -> dict[str, Any]:
    ids = [info.id for info in store.index if name in store.streams_of(info.id)]
    rates = sorted({store.rate(id, name) for id in ids})
    total = sum(store.length(id, name) / store.rate(id, name) for id in ids)
    facts = asdict(store.streams[name])
    length = "seconds" if facts["domain"] == "time" else "length_mm"
    return facts | {"rates": rates, "recordings": len(ids), length: round(total, 3)}
