"""Simulation of a store of recordings, on all cores."""

from __future__ import annotations

import multiprocessing
from collections import deque
from collections.abc import Callable, Iterable, Iterator
from concurrent.futures import ProcessPoolExecutor
from functools import partial
from itertools import chain, groupby, islice
from pathlib import Path
from typing import Any, TypeVar

from tactogram.datasets import Recording, create_store
from tactogram.datasets.examples import cores
from tactogram.datasets.simulate import RecordingTask, make, study, surface_photographs, tasks
from tactogram.workflows.data.requests import SimulationRequest
from tactogram.workflows.progress import ProgressCallback
from tactogram.workflows.request import takes

T = TypeVar("T")
R = TypeVar("R")
CHUNK = 8
"""Most recordings that a process makes at a time."""


@takes(SimulationRequest)
def simulate_to_store(request: SimulationRequest) -> dict[str, Any]:
    """Write a simulated set to a new store.

    Returns
    -------
    dict
        ``store``, ``recordings``, ``photographs``, ``materials``, ``sha256``, ``simulated`` (true), and for a set with
        ratings ``ratings`` (number of scores), ``raters`` and ``items``.

    Raises
    ------
    ParameterError
        For an unknown set or a number out of range, as `simulate` does.
    """
    set_name, seed, per_class = request.set_name, request.seed, request.per_class
    photographs, raters, signals = request.photographs, request.raters, request.signals
    random = request.random
    shown = surface_photographs(set_name, photographs, seed=seed, random=random)
    todo = tasks(
        set_name,
        seed=seed,
        per_class=per_class,
        seconds=request.seconds,
        rate=request.rate,
        speeds_mm_s=request.speeds_mm_s,
        own_images=not photographs,
        random=random,
    )
    rated = study(
        set_name,
        seed=seed,
        per_class=per_class,
        raters=raters,
        signals=signals,
        random=random,
        each=partial(_each, workers=request.workers or cores(), progress=request.progress),
    )
    given = {
        "per-class": per_class,
        "seconds": request.seconds,
        "rate": request.rate,
        "speeds": ",".join(f"{speed:g}" for speed in request.speeds_mm_s or ()) or None,
        "photographs": photographs or None,
        "raters": raters,
        "signals": signals,
        "random": random,
    }
    command = " ".join(
        [f"tactogram data simulate {set_name} --seed {seed}"]
        + [
            f"--{name} {value}" if isinstance(value, str) else f"--{name} {value:g}"
            for name, value in given.items()
            if value is not None
        ]
    )
    store = create_store(
        Path(request.out),
        chain(_made(todo, request.workers or cores(), request.progress), rated.recordings if rated else ()),
        name=f"{set_name} (simulated)",
        licence="CC0-1.0",
        source=command,
        simulated=True,
        photographs=chain(shown, rated.photographs if rated else ()),
        ratings=rated.ratings if rated else None,
    )
    report = {
        "store": str(request.out),
        "recordings": len(store),
        "photographs": len(store.photograph_keys()),
        "materials": len({info.material for info in store.index} - {None}),
        "sha256": store.sha256,
        "simulated": True,
    }
    if rated:
        table = rated.ratings
        report |= {"ratings": len(table), "raters": len(table.raters), "items": len(table.items)}
    return report


def _made(todo: list[RecordingTask], workers: int, progress: ProgressCallback) -> Iterator[Recording]:
    if workers == 1 or len(todo) < 2 * workers:
        yield from _counted(map(make, todo), len(todo), progress)
        return
    yield from _counted(_in_order(todo, workers), len(todo), progress)


def _in_order(todo: list[RecordingTask], workers: int) -> Iterator[Recording]:
    """Yield recordings in the order of ``todo``, with few waiting at a time.

    A process makes some recordings of one surface at a time, since its height field costs more than a stroke. An
    executor, not a pool: it reports a process that dies, where a pool waits for ever.
    """
    chunks = _chunks(todo)
    with ProcessPoolExecutor(workers, mp_context=multiprocessing.get_context("spawn")) as executor:
        waiting = deque(executor.submit(_make_all, chunk) for chunk in islice(chunks, 2 * workers))
        while waiting:
            yield from waiting.popleft().result()
            waiting.extend(executor.submit(_make_all, chunk) for chunk in islice(chunks, 1))


def _each(
    function: Callable[[T], R], items: list[T], *, workers: int, progress: ProgressCallback
) -> Iterator[R]:
    """Yield ``function`` of each item, in order."""
    if workers == 1 or len(items) < 2 * workers:
        yield from _counted(map(function, items), len(items), progress, "rate")
        return
    with ProcessPoolExecutor(workers, mp_context=multiprocessing.get_context("spawn")) as executor:
        yield from _counted(executor.map(function, items, chunksize=CHUNK), len(items), progress, "rate")


def _chunks(todo: Iterable[RecordingTask]) -> Iterator[list[RecordingTask]]:
    """Yield runs of up to `CHUNK` recordings that one contactor makes of one surface."""
    for _, same in groupby(todo, key=lambda task: (task.surface, task.contactor)):
        while chunk := list(islice(same, CHUNK)):
            yield chunk


def _make_all(chunk: list[RecordingTask]) -> list[Recording]:
    return [make(task) for task in chunk]


def _counted(
    results: Iterable[R], total: int, progress: ProgressCallback, stage: str = "simulate"
) -> Iterator[R]:
    for done, result in enumerate(results, start=1):
        yield result
        progress(stage, done, total)
