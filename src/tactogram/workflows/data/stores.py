"""Data sets: import, and inspection, check and extension of a store."""

from __future__ import annotations

from collections import Counter
from dataclasses import asdict
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

from annotated_types import Ge

from tactogram.errors import ParameterError, Remedy
from tactogram.parameters import Count, Settings, checked, with_further
from tactogram.workflows.data.convert import reading_parameters
from tactogram.workflows.progress import ProgressCallback, silent

if TYPE_CHECKING:
    from tactogram.datasets import Ratings, Store

NotNegative = Annotated[float, Ge(0)]


def list_sets() -> dict[str, Any]:
    """List what can be imported and simulated.

    Returns
    -------
    dict
        ``import``: ``title``, ``licence`` and ``description`` by name; ``simulate``: one line by name.
    """
    from tactogram.datasets.importer import importers
    from tactogram.plugins import entry_point_modules, import_plugin

    return {
        "import": {
            name: {"title": i.TITLE, "licence": i.LICENCE, "description": i.DESCRIPTION}
            for name, i in importers().items()
        },
        "simulate": {
            name: line
            for module in entry_point_modules("tactogram.simulators")
            for name, line in import_plugin(module).simulated_sets().items()
        },
    }


@checked
def import_store(
    set_name: str,
    path: Path | str,
    out: Path | str | None = None,
    *,
    preview: bool = False,
    mapping: Path | str | None = None,
    save_mapping: Path | str | None = None,
    skip_bad: bool = False,
    options: Settings | None = None,
    workers: Count | None = None,
    progress: ProgressCallback = silent,
) -> dict[str, Any]:
    """Import a data set into a store.

    Parameters
    ----------
    set_name : str
        One of `tactogram data list`; `folder` for MATERIAL/*.wav and the like.
    path : Path or str
        Where its files are.
    out : Path or str, optional
        The new store.
    preview : bool
        Show what each column is read as and which files would be skipped; no store is written.
    mapping : Path or str, optional
        File of what the columns of the tables hold (.toml), of the set `folder`.
    save_mapping : Path or str, optional
        With the preview: write the mapping that it shows, to be edited.
    skip_bad : bool
        Report broken files and continue without them.
    options : dict, optional
        Facts that the files do not state, e.g. rate=1000.
    workers : int, optional
        Processes (default: all cores).

    Returns
    -------
    dict
        The report of `tactogram.datasets.importing.import_dataset`. With ``preview`` that of
        `tactogram.datasets.preview.preview_dataset`, ``mapping`` (the file written, if any) and ``unused_layouts``
        (columns of layouts in ``mapping`` that no file has); nothing but the file ``save_mapping`` is written.

    Raises
    ------
    ParameterError
        If ``out`` is missing or no folder, an option is unknown, or ``save_mapping`` comes without ``preview``.
    DataError
        If a file cannot be read; nothing is written then.
    """
    from tactogram.datasets.importing import import_dataset
    from tactogram.datasets.mapping import read_mapping
    from tactogram.datasets.store.remote import is_remote

    if save_mapping is not None and not preview:
        raise ParameterError.must("save_mapping", "come with a preview", remedy=Remedy("add", "preview"))
    if out is None and not preview:
        raise ParameterError.must("out", "be given", remedy=Remedy("omit it only with", "preview"))
    if out is not None and is_remote(out) and not preview:
        raise ParameterError.must(
            "out", "be a folder", out, remedy="`tactogram data copy` the store there afterwards"
        )
    known = dict(options or {})
    if mapping is not None:
        known["mapping"] = read_mapping(Path(mapping))
    reading: dict[str, Any] = {"options": known, "workers": workers, "progress": partial(progress, "reading")}
    if out is None or preview:
        facts = _preview(set_name, Path(path), None if save_mapping is None else Path(save_mapping), reading)
        return facts | {"needs_skip_bad": facts["needs_skip_bad"] and not skip_bad}
    return import_dataset(set_name, Path(path), Path(out), skip_bad=skip_bad, **reading)


def _preview(set_name: str, path: Path, saved: Path | None, reading: dict[str, Any]) -> dict[str, Any]:
    from tactogram.datasets.mapping import write_mapping
    from tactogram.datasets.preview import preview_dataset, proposed_layouts
    from tactogram.signal.io.atomic import check_writable

    if saved is not None:
        if saved.exists():
            raise ParameterError.must(
                "save_mapping", f"be a new file, {saved} exists; remove it or choose another"
            )
        check_writable(saved)
    facts = preview_dataset(set_name, path, **reading)
    layouts = reading["options"]["mapping"].layout if "mapping" in reading["options"] else ()
    if saved is not None:
        write_mapping(saved, proposed_layouts(facts, layouts))
    met = [[column["heading"] for column in layout["columns"]] for layout in facts["layouts"]]
    unused = [list(layout.columns) for layout in layouts if list(layout.columns) not in met]
    return facts | {"mapping": None if saved is None else str(saved), "unused_layouts": unused}


@checked
def copy(source: Path | str, target: Path | str, *, progress: ProgressCallback = silent) -> dict[str, Any]:
    """Copy a store to an object store such as S3, back, or to another folder, and check it on the way.

    Parameters
    ----------
    source : Path or str
        A store.
    target : Path or str
        A folder, or a URL such as s3://bucket/path.

    Returns
    -------
    dict
        ``path`` (of the copy), ``recordings``, ``sha256``, ``bytes``.

    Raises
    ------
    DataError, ParameterError
        As `tactogram.datasets.store.writing.copy_store`.
    """
    from tactogram.datasets.store.writing import copy_store

    store = copy_store(source, target, progress=partial(progress, "copying"))
    return {
        "path": str(store.path),
        "recordings": len(store),
        "sha256": store.sha256,
        "bytes": sum(file.bytes for file in store.facts.files),
    }


@checked
def store_info(path: Path | str) -> dict[str, Any]:
    """Describe what a store holds.

    Parameters
    ----------
    path : Path or str
        A store.

    Returns
    -------
    dict
        ``name``, ``licence``, ``source``, ``simulated``, ``sha256``, ``recordings``, ``bytes``, ``streams`` (unit,
        domain, axes, rates, recordings and total seconds or mm by name), ``materials`` (recordings by name), and the
        numbers of different ``contactors``, ``sessions``, ``subjects``, ``images``; ``photographs`` (of each material
        that has any, by name), ``without_photographs`` and ``without_recordings`` (materials that have only the
        other), ``ratings`` (`workflows.data.rating_tables.ratings_info`; null where there are none), ``duplicates`` and
        ``skipped`` as lists.

    Raises
    ------
    DataError
        If it is no store.
    """
    from tactogram.datasets import materials_without_photographs, materials_without_recordings, open_store

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


@checked
def check_store(path: Path | str, *, progress: ProgressCallback = silent) -> dict[str, Any]:
    """Check every shard of a store against its hash.

    Parameters
    ----------
    path : Path or str
        A store.

    Returns
    -------
    dict
        ``path``, ``recordings``, ``sha256``, ``ok``, and ``problems``, one line each.

    Raises
    ------
    DataError
        If it is no store.
    """
    from tactogram.datasets import open_store
    from tactogram.datasets.store.store import problems

    store = open_store(path)
    faults = problems(store, progress=partial(progress, "checking"))
    return {
        "path": str(path),
        "recordings": len(store),
        "sha256": store.sha256,
        "ok": not faults,
        "problems": faults,
    }


@checked
@with_further(reading_parameters)
def add_signal(
    path: Path | str,
    file: Path | str,
    *,
    material: str,
    stream: str | None = None,
    speed_mm_s: NotNegative | None = None,
    force_n: NotNegative | None = None,
    contactor: str | None = None,
    session: str | None = None,
    subject: str | None = None,
    photograph: Path | str | None = None,
    simulated: bool = False,
    **reading: Any,
) -> dict[str, Any]:
    """Add a recording to a store; it is on the disk when this returns.

    The unit is by default that of the store's stream, and so is a rate estimated from time stamps if it is close. A
    file that says it is simulated is taken as simulated. ``reading`` are the options of `tactogram.convert` on how a
    file is read.

    Parameters
    ----------
    path : Path or str
        A store.
    file : Path or str
        A signal.
    material : str
        What was touched.
    stream : str, optional
        Name of the stream (default: the store's only one).
    speed_mm_s : float, optional
        Stroking speed, mm/s.
    force_n : float, optional
        Normal force, N.
    contactor : str, optional
        What touched the surface.
    session : str, optional
        Name of the session.
    subject : str, optional
        Who stroked, as a code.
    photograph : Path or str, optional
        Photograph of the surface.
    simulated : bool
        The signal was computed, not measured.

    Returns
    -------
    dict
        ``path``, ``id``, ``material``, ``added`` (False for a duplicate), ``recordings``, ``sha256``, ``sha256_before``
        (runs trained on the store keep the recordings they name), ``simulated`` (of this recording), and ``mixed``:
        whether the store now has both simulated and measured recordings.

    Raises
    ------
    DataError
        If the file cannot be read.
    ParameterError
        If the store has several streams and ``stream`` is None.
    """
    from tactogram.datasets import Recording, open_store
    from tactogram.datasets.rates import CommonRates
    from tactogram.datasets.recording import FileReading
    from tactogram.datasets.store.writing import insert_recording
    from tactogram.signal.io import read_file, read_image

    store, file = open_store(path), Path(file)
    if stream is None:
        if len(store.streams) != 1:
            raise ParameterError.must("stream", f"be one of {', '.join(store.streams)}, got none")
        [stream] = store.streams
    if reading.get("unit") is None and stream in store.streams:
        reading["unit"] = store.streams[stream].unit
    read = read_file(file, **reading)
    estimated = read.timing is not None and reading.get("rate") is None
    recording = Recording(
        streams={stream: read.signal},
        material=material,
        source=file.name,
        history=("added by hand",),
        # The output of a simulator, or of a model trained on simulated data, stays simulated.
        simulated=simulated or str(read.metadata.get("simulated", "")).lower() == "true",
        image=None if photograph is None else read_image(photograph),
        speed_mm_s=speed_mm_s,
        force_n=force_n,
        contactor=contactor,
        session=session,
        subject=subject,
        reading=FileReading(read.columns, False, read.timing, estimated),
    )
    recording = CommonRates.of(store).united(recording)
    bigger, added = insert_recording(path, recording)
    return {
        "path": str(path),
        "id": recording.id,
        "material": material,
        "added": added,
        "recordings": len(bigger),
        "sha256": bigger.sha256,
        "sha256_before": store.sha256,
        "simulated": recording.simulated,
        "mixed": len({info.simulated for info in bigger.index}) > 1,
    }


@checked
def export_store(path: Path | str, *, out: Path | str, push: str | None = None) -> dict[str, Any]:
    """Write a store as a data set of the Hugging Face Hub.

    Parameters
    ----------
    path : Path or str
        A store.
    out : Path or str
        New folder.
    push : str, optional
        Also upload it, e.g. as lab/cork.

    Returns
    -------
    dict
        ``path``, ``recordings``, ``photographs`` (their numbers), and ``pushed`` (where to).

    Raises
    ------
    ParameterError
        If the store has no recordings.
    RunError
        If ``out`` exists, or the upload fails.
    MissingExtraError
        If huggingface_hub is not installed.
    """
    from tactogram.datasets import open_store
    from tactogram.workflows import hub
    from tactogram.workflows.data.export import write_hub_dataset

    hub.hub_library()
    store = open_store(path)
    if not len(store):
        raise ParameterError(f"{path} has no recordings")
    write_hub_dataset(store, Path(out))
    photographs = len(store.photograph_keys()) if store.facts.images else 0
    facts = {"path": str(out), "recordings": len(store), "photographs": photographs}
    return facts | ({"pushed": hub.push(Path(out), push, kind="dataset")} if push else {})


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
