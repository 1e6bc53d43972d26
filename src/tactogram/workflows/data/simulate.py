"""Simulation of a store of recordings, on all cores."""

from __future__ import annotations

import multiprocessing
from collections import deque
from collections.abc import Iterable, Iterator, Sequence
from concurrent.futures import ProcessPoolExecutor
from itertools import chain, islice
from pathlib import Path
from typing import Any

from tactogram.datasets import Recording, create_store
from tactogram.datasets.examples import cores
from tactogram.datasets.simulate import RecordingTask, make, study, surface_photographs, tasks
from tactogram.errors import ParameterError
from tactogram.workflows.progress import ProgressCallback, silent


def simulate_to_store(
    set_name: str,
    out: Path | str,
    *,
    seed: int = 0,
    per_class: int | None = None,
    seconds: float | None = None,
    rate: float | None = None,
    speeds_mm_s: Sequence[float] | None = None,
    photographs: int = 0,
    raters: int | None = None,
    workers: int | None = None,
    progress: ProgressCallback = silent,
) -> dict[str, Any]:
    """Write the simulated set ``set_name`` to the store ``out``.

    Parameters
    ----------
    set_name, seed, per_class, seconds, rate, speeds_mm_s : see `tactogram.datasets.simulate.simulate`
    out : path
        Must not exist.
    photographs : int, 0 to 9
        Of each surface, at places that do not overlap, for learning from photographs; the recordings then have none
        of their own. With 0 every recording has the one of its surface.
    raters : int, optional
        Simulated people who score, in the sets that have ratings; by default as many as in the paper.
    workers : int, optional
        Processes; by default one per core. The recordings are the same for any number.

    Returns
    -------
    dict
        ``store``, ``recordings``, ``photographs``, ``materials``, ``sha256``, ``simulated`` (true), and for a set with
        ratings ``ratings`` (how many scores), ``raters`` and ``items``.

    Raises
    ------
    ParameterError
        For an unknown set or a number that makes no sense, as `simulate` does.
    """
    if workers is not None and workers < 1:
        raise ParameterError(f"workers must be at least 1, got {workers}")
    shown = surface_photographs(set_name, photographs)
    todo = tasks(
        set_name,
        seed=seed,
        per_class=per_class,
        seconds=seconds,
        rate=rate,
        speeds_mm_s=speeds_mm_s,
        own_images=not photographs,
    )
    rated = study(set_name, seed=seed, per_class=per_class, raters=raters)
    given = {
        "per-class": per_class,
        "seconds": seconds,
        "rate": rate,
        "speeds": None if speeds_mm_s is None else ",".join(f"{speed:g}" for speed in speeds_mm_s),
        "photographs": photographs or None,
        "raters": raters,
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
        Path(out),
        chain(_made(todo, workers or cores(), progress), rated.recordings if rated else ()),
        name=f"{set_name} (simulated)",
        licence="CC0-1.0",
        source=command,
        simulated=True,
        photographs=chain(shown, rated.photographs if rated else ()),
        ratings=rated.ratings if rated else None,
    )
    report = {
        "store": str(out),
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
    """Yield what the processes make in the order of ``todo``, with no more than a few waiting at a time.

    An executor, not a pool: it says so when a process dies, where a pool waits for ever.
    """
    with ProcessPoolExecutor(workers, mp_context=multiprocessing.get_context("spawn")) as executor:
        tasks = iter(todo)
        waiting = deque(executor.submit(make, task) for task in islice(tasks, 3 * workers))
        while waiting:
            recording = waiting.popleft().result()
            waiting.extend(executor.submit(make, task) for task in islice(tasks, 1))
            yield recording


def _counted(recordings: Iterable[Recording], total: int, progress: ProgressCallback) -> Iterator[Recording]:
    for done, recording in enumerate(recordings, start=1):
        yield recording
        progress("simulate", done, total)
