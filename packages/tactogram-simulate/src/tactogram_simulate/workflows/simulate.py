"""Simulation of a store of recordings, on all cores or on Ray."""

from __future__ import annotations

import json
from collections.abc import Callable, Iterable, Iterator, Sequence
from dataclasses import asdict
from functools import partial
from importlib.metadata import version
from itertools import chain, groupby, islice
from pathlib import Path
from typing import TYPE_CHECKING, Any, NamedTuple, TypeVar

from tactogram.errors import TactogramError
from tactogram.parameters import Count, Positive, checked
from tactogram.workflows import ProgressCallback, silent

if TYPE_CHECKING:
    from tactogram.workflows import Outcome
    from tactogram_simulate.raters.rules import TouchCues
    from tactogram_simulate.surfaces import Surface

T = TypeVar("T")
R = TypeVar("R")
CHUNK = 8
"""Most recordings that a process makes at a time."""


@checked
def simulate_to_store(
    set_name: str,
    out: Path | str,
    *,
    seed: int = 0,
    per_class: Count | None = None,
    rate: Positive | None = None,
    seconds: Positive | None = None,
    speeds_mm_s: tuple[float, ...] | None = None,
    photographs: int = 0,
    raters: int | None = None,
    signals: int | None = None,
    random: int | None = None,
    workers: Count | None = None,
    on: str = "",
    progress: ProgressCallback = silent,
) -> dict[str, Any]:
    """Simulate a data set of surfaces.

    The recordings are the same for any number of ``workers``, and on Ray.

    Parameters
    ----------
    set_name : str
        One of `tactogram data list`.
    out : Path or str
        The new store.
    seed : int
        Seed of all that is random.
    per_class : int, optional
        Recordings per class.
    rate : float, optional
        Sampling rate, Hz.
    seconds : float, optional
        Length of a recording.
    speeds_mm_s : tuple of float, optional
        Stroking speeds, mm/s (default: the paper's).
    photographs : int
        Photographs of each surface, up to 9 places that do not overlap, for learning from photographs; recordings have
        none of their own then (default: one picture).
    raters : int, optional
        Simulated raters, in sets with ratings (default: the paper's).
    signals : int, optional
        Display signals of ultrasonic (default: the paper's 39).
    random : int, optional
        Surfaces to draw, of the set `surfaces` (default: 100).
    workers : int, optional
        Processes (default: all cores).
    on : str
        Engine: ray starts Ray on this machine, ray:ADDRESS takes a cluster.

    Returns
    -------
    dict
        ``store``, ``recordings``, ``photographs``, ``materials``, ``sha256``, ``simulated`` (true), and for a set with
        ratings ``ratings`` (number of scores), ``raters`` and ``items``.

    Raises
    ------
    ParameterError
        If there is no such set, or a number is out of range.
    """
    from tactogram.datasets import check_new, clear_stale_parts, new_store, open_store
    from tactogram_simulate.sets import make, surface_photographs, tasks
    from tactogram_simulate.studies import study

    shown = surface_photographs(set_name, photographs, seed=seed, random=random)
    todo = tasks(
        set_name,
        seed=seed,
        per_class=per_class,
        seconds=seconds,
        rate=rate,
        speeds_mm_s=speeds_mm_s,
        own_images=not photographs,
        random=random,
    )
    options = {
        "per-class": per_class,
        "seconds": seconds,
        "rate": rate,
        "speeds": ",".join(f"{speed:g}" for speed in speeds_mm_s or ()) or None,
        "photographs": photographs or None,
        "raters": raters,
        "signals": signals,
        "random": random,
    }
    command = " ".join(
        [f"tactogram data simulate {set_name} --seed {seed}"]
        + [
            f"--{name} {value}" if isinstance(value, str) else f"--{name} {value:g}"
            for name, value in options.items()
            if value is not None
        ]
    )
    out, job = Path(out), f"{command}, {version('tactogram')}"
    check_new(out)
    work = _Work(workers, on, progress)
    rated = study(
        set_name,
        seed=seed,
        per_class=per_class,
        raters=raters,
        signals=signals,
        random=random,
        each=lambda function, surfaces: _rated(function, surfaces, out, job, work),
    )
    with new_store(
        out, name=f"{set_name} (simulated)", licence="CC0-1.0", source=command, simulated=True, job=job
    ) as writer:
        clear_stale_parts(out)
        before = writer.tasks_done
        left = todo[before:]
        # A process makes some recordings of one surface at a time, since its height field costs more than a stroke.
        runs = (run for _, same in groupby(left, key=lambda task: task.surface) for run in _pieces(same))
        for done, recording in enumerate(_made(make, left, runs, "simulate", work, before), before + 1):
            writer.add(recording)
            writer.keep(done)
        for recording in rated.recordings if rated else ():
            writer.add(recording)
        for material, image in chain(shown, rated.photographs if rated else ()):
            writer.add_photograph(image, material)
        writer.ratings = rated.ratings if rated else None
        # First: a simulation that is repeated is refused once there is a store.
        _cues_file(out).unlink(missing_ok=True)
        writer.publish(out)
    store = open_store(out)
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


class _Work(NamedTuple):
    """Processes or engine of a simulation, and its progress."""

    workers: int | None
    on: str
    progress: ProgressCallback


def _rated(
    function: Callable[[Surface], TouchCues], surfaces: list[Surface], out: Path, job: str, work: _Work
) -> Iterator[TouchCues]:
    """Yield the cues of each surface; each is kept in a line of a file, so that a killed simulation goes on."""
    file = _cues_file(out)
    file.parent.mkdir(parents=True, exist_ok=True)
    with file.open("a+", encoding="utf-8", buffering=1) as lines:
        kept = _kept_cues(file, job)
        lines.truncate(0)
        lines.writelines(f"{json.dumps(line)}\n" for line in [{"job": job}, *map(asdict, kept)])
        yield from kept
        left = surfaces[len(kept) :]
        for cues in _made(function, left, _pieces(left), "rate", work, len(kept)):
            lines.write(f"{json.dumps(asdict(cues))}\n")
            yield cues


def _kept_cues(file: Path, job: str) -> list[TouchCues]:
    """Return the cues in the complete lines of a file, if a simulation of the same ``job`` left it."""
    from tactogram_simulate.raters.rules import TouchCues

    lines = file.read_text(encoding="utf-8").split("\n")[:-1]
    if not lines or json.loads(lines[0]) != {"job": job}:
        return []
    return [TouchCues(**json.loads(line)) for line in lines[1:]]


def _cues_file(out: Path) -> Path:
    return out.with_name(f"{out.name}.cues.jsonl")


def _made(
    function: Callable[[T], R],
    items: Sequence[T],
    chunks: Iterable[list[T]],
    title: str,
    work: _Work,
    before: int = 0,
) -> Iterator[R]:
    """Yield ``function`` of each item, in order; a worker makes a chunk of them at a time.

    ``before`` is the number of items that were made before, for the progress.
    """
    from tactogram.datasets import cores
    from tactogram.main_script import allowed_processes
    from tactogram.workflows import in_order, run_tasks

    workers = work.workers or cores()
    total = before + len(items)
    if not work.on and len(items) >= 2 * workers:
        workers = allowed_processes(work.workers, workers)
    if not work.on and (workers == 1 or len(items) < 2 * workers):
        yield from _counted(map(function, items), before, total, work.progress, title)
        return
    numbered = list(enumerate(chunks))
    outcomes = run_tasks(partial(_all, function), numbered, on=work.on, processes=workers)
    yield from _counted(_values(in_order(outcomes)), before, total, work.progress, title)


def _values(outcomes: Iterable[Outcome[tuple[int, list[T]], list[R]]]) -> Iterator[R]:
    for outcome in outcomes:
        if outcome.value is None:
            raise TactogramError(f"simulation, {_chunk_name(outcome.task)}: {outcome.error}")
        yield from outcome.value


def _chunk_name(chunk: tuple[int, list[Any]]) -> str:
    return f"chunk {chunk[0] + 1}, {len(chunk[1])} items"


def _all(function: Callable[[T], R], chunk: tuple[int, list[T]]) -> list[R]:
    return [function(item) for item in chunk[1]]


def _pieces(items: Iterable[T]) -> Iterator[list[T]]:
    """Yield runs of up to `CHUNK` items."""
    rest = iter(items)
    while chunk := list(islice(rest, CHUNK)):
        yield chunk


def _counted(
    results: Iterable[R], before: int, total: int, progress: ProgressCallback, stage: str
) -> Iterator[R]:
    for done, result in enumerate(results, start=before + 1):
        yield result
        progress(stage, done, total)
