"""Simulation of a store of recordings, on all cores or on Ray."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Sequence
from functools import partial
from itertools import chain, groupby, islice
from pathlib import Path
from typing import Any, TypeVar

from tactogram.datasets import create_store
from tactogram.datasets.examples import cores
from tactogram.datasets.simulate import RecordingTask, make, study, surface_photographs, tasks
from tactogram.errors import TactogramError
from tactogram.workflows.data.requests import SimulationRequest
from tactogram.workflows.progress import ProgressCallback
from tactogram.workflows.request import takes
from tactogram.workflows.workers import Outcome, run_tasks
from tactogram.workflows.workers.ordered import in_order
from tactogram.workflows.workers.page import followed

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
        each=lambda function, surfaces: _made(function, surfaces, _pieces(surfaces), "rate", request),
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
        chain(_made(make, todo, _by_surface(todo), "simulate", request), rated.recordings if rated else ()),
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


def _made(
    function: Callable[[T], R],
    items: Sequence[T],
    chunks: Iterable[list[T]],
    title: str,
    request: SimulationRequest,
) -> Iterator[R]:
    """Yield ``function`` of each item, in order; a worker makes a chunk of them at a time."""
    workers = request.workers or cores()
    if not request.on and (workers == 1 or len(items) < 2 * workers):
        yield from _counted(map(function, items), len(items), request.progress, title)
        return
    numbered = list(enumerate(chunks))
    outcomes = run_tasks(partial(_all, function), numbered, on=request.on, processes=workers)
    if request.on:
        page, name = Path(f"{request.out}-{title}-workers.html"), _chunk_name
        outcomes = followed(outcomes, page, numbered, title=title, name=name, simulated=True)
    yield from _counted(_values(in_order(outcomes)), len(items), request.progress, title)


def _values(outcomes: Iterable[Outcome[tuple[int, list[T]], list[R]]]) -> Iterator[R]:
    for outcome in outcomes:
        if outcome.value is None:
            raise TactogramError(f"simulation, {_chunk_name(outcome.task)}: {outcome.error}")
        yield from outcome.value


def _chunk_name(chunk: tuple[int, list[Any]]) -> str:
    return f"chunk {chunk[0] + 1}, {len(chunk[1])} items"


def _all(function: Callable[[T], R], chunk: tuple[int, list[T]]) -> list[R]:
    return [function(item) for item in chunk[1]]


def _by_surface(todo: Iterable[RecordingTask]) -> Iterator[list[RecordingTask]]:
    """Yield runs of up to `CHUNK` recordings that one contactor makes of one surface.

    A process makes some recordings of one surface at a time, since its height field costs more than a stroke.
    """
    for _, same in groupby(todo, key=lambda task: (task.surface, task.contactor)):
        yield from _pieces(same)


def _pieces(items: Iterable[T]) -> Iterator[list[T]]:
    """Yield runs of up to `CHUNK` items."""
    rest = iter(items)
    while chunk := list(islice(rest, CHUNK)):
        yield chunk


def _counted(results: Iterable[R], total: int, progress: ProgressCallback, stage: str) -> Iterator[R]:
    for done, result in enumerate(results, start=1):
        yield result
        progress(stage, done, total)
