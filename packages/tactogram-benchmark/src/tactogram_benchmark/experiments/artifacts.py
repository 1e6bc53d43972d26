"""Artifacts of an experiment, made once in its folder and read again: data, runs and results."""

from __future__ import annotations

import csv
import json
from collections.abc import Callable, Iterable, Iterator, Mapping
from dataclasses import dataclass, field
from pathlib import Path
from statistics import mean, stdev
from typing import Any, TypeVar

from tactogram.datasets import Store, open_store
from tactogram.errors import DataError, ParameterError, TactogramError
from tactogram.signal import Image, Signal
from tactogram.signal.io import atomic_write, write_image, write_signal, write_text
from tactogram.workflows import ProgressCallback, absolute, run_tasks, silent, train
from tactogram_simulate import simulate_to_store


def find_or_simulate(
    path: Path, set_name: str, *, progress: ProgressCallback, given: str = "", seed: int = 0, **options: Any
) -> Store:
    """Return the store at ``given``, otherwise the one in ``path``, simulated with ``seed`` if there is none yet.

    ``options`` are those of `simulate_to_store`.

    Raises `DataError` if ``given`` is not a store.
    """
    if given:
        return open_store(given)
    try:
        return open_store(path)
    except DataError:
        simulate_to_store(set_name, path, seed=seed, **options, progress=progress)
        return open_store(path)


def trained_run(model: str, store: Store, run: Path, *, progress: ProgressCallback, **options: Any) -> Path:
    """Return ``run`` after training it, or continuing it if it exists; ``options`` are those of `train`."""
    train(model, store.path, out=run, resume=(run / "recipe.toml").exists(), progress=progress, **options)
    return run


@dataclass(frozen=True)
class Training:
    """A training that depends on no other of its experiment; ``options`` are those of `train`."""

    model: str
    store: Path | str
    run: Path
    options: Mapping[str, Any] = field(default_factory=dict)


Key = TypeVar("Key")


def trained_runs(
    trainings: Mapping[Key, Training],
    *,
    on: str = "",
    processes: int | None = None,
    progress: ProgressCallback,
) -> Iterator[tuple[Key, Path]]:
    """Yield the run of each training, as of `trained_run`.

    With ``on`` or ``processes`` all are carried out first, on workers, each on one thread. On a cluster all nodes share
    the folders.

    Raises `TactogramError` if trainings on workers failed, once all others are finished; it names the first.
    """
    if on or processes is not None:
        sent = [
            Training(job.model, Path(absolute(job.store)), Path(absolute(job.run)), job.options)
            for job in trainings.values()
        ]
        outcomes = run_tasks(
            _trained, sent, on=on, name=_run_name, processes=processes or 1, progress=progress
        )
        failed = [
            f"{_run_name(outcome.task)}: {outcome.error}" for outcome in outcomes if outcome.error is not None
        ]
        if failed:
            raise TactogramError(f"{len(failed)} of {len(sent)} trainings failed; {failed[0]}")
    for key, training in trainings.items():
        _trained(training, progress)
        yield key, training.run


def _run_name(training: Training) -> str:
    return training.run.name


def _trained(training: Training, progress: ProgressCallback = silent) -> None:
    store = open_store(training.store)
    trained_run(training.model, store, training.run, **training.options, progress=progress)


def cached_result(
    file: Path, facts: Mapping[str, Any], compute: Callable[[], Mapping[str, Any]]
) -> dict[str, Any]:
    """Return the result in ``file`` if it has the same ``facts``, otherwise compute and write it."""
    if file.is_file():
        result: dict[str, Any] = json.loads(file.read_text(encoding="utf-8"))
        if result["asked"] == facts:
            return result
    result = {"asked": dict(facts), **compute()}
    file.parent.mkdir(parents=True, exist_ok=True)
    write_text(file, json.dumps(result, indent=1) + "\n")
    return result


def write_items(folder: Path, items: Mapping[str, Signal | tuple[Signal, Image]]) -> Path:
    """Write what people can rate: signals, some with an image, into ``items``; return their table ``items.csv``."""
    rows = [("item", "vibration", "image")]
    for item, content in items.items():
        signal, image = content if isinstance(content, tuple) else (content, None)
        stem = f"items/{item.replace('/', '-').replace(' ', '-')}"
        write_signal(folder / f"{stem}.wav", signal)
        if image is not None:
            write_image(folder / f"{stem}.png", image)
        rows.append((item, f"{stem}.wav", "" if image is None else f"{stem}.png"))
    with atomic_write(folder / "items.csv") as part, part.open("w", newline="", encoding="utf-8") as file:
        csv.writer(file, lineterminator="\n").writerows(rows)
    return folder / "items.csv"


def listed(text: str, known: Iterable[str], what: str) -> list[str]:
    """Return names separated by commas, each one of ``known``; ``what`` they are is for the error."""
    names = [name.strip() for name in text.split(",") if name.strip()]
    if unknown := [name for name in names if name not in {*known}]:
        raise ParameterError(f"{what} must be some of {', '.join(known)}, got {unknown[0]!r}")
    return names


def spread(values: Iterable[float | None]) -> dict[str, Any]:
    """Return the values, and mean, standard deviation and number of those that are not None."""
    every = list(values)
    known = [value for value in every if value is not None]
    return {
        "mean": mean(known) if known else None,
        "sd": stdev(known) if len(known) > 1 else None,
        "known": len(known),
        "values": every,
    }


def origin_of(store: Store) -> dict[str, Any]:
    """Return name, hash and origin of a store, as a result with several names each."""
    return {"name": store.name, "sha256": store.sha256, "simulated": store.simulated}


def facts_of(store: Store) -> dict[str, Any]:
    """Return the facts of an experiment's only store in its result."""
    return {"simulated": store.simulated, "data": store.name, "data_sha256": store.sha256}


def kind_of(store: Store) -> str:
    """Return the name of the store's signals in a table."""
    return "simulated strokes" if store.simulated else f"recorded strokes ({store.name})"


IN_RECORDINGS = {
    "artificial-grass": "ArtGrass01",
    "carpet": "Carpet01",
    "tile": "GreenTile",
    "cloth": "ArtLeather",
    "cork-sheet": "CorkSheet",
    "punched-plastic-sheet": "EnbiPunch",
    "luncheon-mat-01": "Luncheon01",
    "luncheon-mat-02": "Luncheon02",
    "luncheon-mat-03": "Luncheon03",
}
"""Names in the laboratory's recordings (`tactogram_benchmark.importers.saga_strokes`) by those of the simulated set.
The recordings have no cloth; artificial leather, which the paper does not name, is assumed to be it."""


def materials_of(store: Store) -> dict[str, str]:
    """Return the store's material of each of the nine textures.

    Raises `DataError` if one is missing.
    """
    known = {info.material for info in store.index}
    materials = {
        name: next((m for m in (name, other) if m in known), "") for name, other in IN_RECORDINGS.items()
    }
    if missing := [name for name, material in materials.items() if not material]:
        raise DataError(
            store.path,
            "must have the nine textures of Saga et al., found none called "
            + ", ".join(f"{name} or {IN_RECORDINGS[name]}" for name in missing),
        )
    return materials
