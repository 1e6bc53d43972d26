"""A training by one process and by two: memory, and the share of the time that each waits.

Recordings are simulated: noise of 1 s at 1 kHz on three axes, classified by ``stroke_cnn``, recipe ``quick``.
``waits_for_data`` is the share of the time until a batch is drawn; ``waits_for_other`` that between a process's
arrival at an average of gradients, batch statistics or losses and the other's; ``sends`` that of the averages. These
two depend on what else the machine does. ``unequal`` is by processor time alone: the share for which a process would
wait if each had a core of its own, as the other's work between two averages is longer. Memory is a process's own
(RssAnon): at the first step, and how much it grew until the last. Mapped files of prepared recordings are shared by the
processes, and the system may drop them.
"""

from __future__ import annotations

import json
import os
import re
import subprocess
import sys
import tempfile
import time
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from pathlib import Path
from typing import Any

import numpy as np

from tactogram.datasets import Recording, create_store
from tactogram.errors import StoppedError
from tactogram.signal import Signal

RECORDINGS = (2_000, 20_000)
STEPS, WARM_UP = 60, 5
MATERIALS = 20


def run(
    recordings: tuple[int, ...] = RECORDINGS, steps: int = STEPS, folder: Path | None = None
) -> list[dict[str, Any]]:
    """Return a row per number of recordings, number of processes, and process."""
    rows = []
    with tempfile.TemporaryDirectory(dir=folder, prefix="bench-processes-") as name:
        for count in recordings:
            store = Path(name) / f"store{count}"
            create_store(store, noise(count), name="noise", licence="CC0-1.0", simulated=True)
            for processes in (1, 2):
                out = Path(name) / f"run{count}-{processes}"
                job = {"data": str(store), "out": str(out), "steps": steps}
                started = (sys.executable, "-m", "torch.distributed.run", "--standalone")
                module = ("--nproc-per-node", str(processes), "-m", "benchmarks.bench_processes")
                subprocess.run([*started, *module, json.dumps(job)], check=True)
                found = [json.loads((out / f"measured-{k}.json").read_text()) for k in range(processes)]
                work = np.array([facts.pop("work") for facts in found])  # process, part between two averages
                longest = work.max(0)
                for number, facts in enumerate(found):
                    unequal = float((longest - work[number]).sum() / longest.sum()) if processes > 1 else 0.0
                    row = {"recordings": count, "processes": processes, "process": number + 1}
                    rows.append(row | facts | {"unequal": round(unequal, 4)})
    return rows


def noise(count: int, *, seconds: float = 1.0, rate: float = 1000.0) -> Iterator[Recording]:
    """Yield simulated recordings: noise on three axes, of a level that depends on the material."""
    for number in range(count):
        material = number % MATERIALS
        rng = np.random.default_rng(number)
        samples = (1 + material) * rng.standard_normal((3, round(seconds * rate)), np.float32)
        yield Recording(
            streams={"acceleration": Signal(samples, rate, "m/s^2")},
            material=f"material {material}",
            source=str(number),
            simulated=True,
        )


def measured(data: str, out: str, steps: int) -> None:
    """Train, and write what this process measured of itself into the run's folder."""
    import torch.distributed as dist

    from tactogram.models.stroke_cnn.learner import StrokeCNNLearner
    from tactogram.workflows.training.train import train

    spent = dict.fromkeys(("data", "other", "sends"), 0.0)
    memory: list[float] = []
    marks: list[float] = []
    work: list[float] = []
    since = time.thread_time()
    reduce, batches, step = dist.all_reduce, StrokeCNNLearner.batches, StrokeCNNLearner.step

    @contextmanager
    def timed(what: str) -> Iterator[None]:
        begun = time.perf_counter()
        yield
        spent[what] += time.perf_counter() - begun

    def timed_reduce(tensor: Any, *args: Any, **options: Any) -> None:
        nonlocal since
        work.append(time.thread_time() - since)
        with timed("other"):
            dist.barrier()
        with timed("sends"):
            reduce(tensor, *args, **options)
        since = time.thread_time()

    def timed_batches(*args: Any, **options: Any) -> Iterator[Any]:
        drawn = batches(*args, **options)
        while True:
            with timed("data"):
                batch = next(drawn, None)
            if batch is None:
                return
            yield batch

    def timed_step(self: Any, stage: Any, batch: Any) -> dict[str, float]:
        if stage.name == "classify":
            if len(memory) == WARM_UP:
                spent.update(dict.fromkeys(spent, 0.0))
                work.clear()
            marks.append(time.perf_counter())
            memory.append(own_mb())
        return step(self, stage, batch)

    dist.all_reduce, StrokeCNNLearner.batches, StrokeCNNLearner.step = timed_reduce, timed_batches, timed_step  # type: ignore
    begun = time.perf_counter()
    changes = {
        "config.steps": steps + WARM_UP + 1,
        "training.checkpoint_every": 10**6,
    }
    with suppress(StoppedError):  # without validation and index, which one process makes
        train(
            "stroke_cnn",
            data,
            recipe="quick",
            changes=changes,
            split="last=5",
            out=out,
            accelerator="cpu",
            stop=lambda: len(memory) == steps + WARM_UP,
        )
    took = marks[-1] - marks[WARM_UP]
    facts = {
        "until_first_step_s": round(marks[0] - begun, 1),
        "step_s": round(took / (steps - 1), 3),
        "waits_for_data": round(spent["data"] / took, 4),
        "waits_for_other": round(spent["other"] / took, 4),
        "sends": round(spent["sends"] / took, 4),
        "own_mb": round(memory[WARM_UP]),
        "grew_mb": round(memory[-1] - memory[WARM_UP], 1),
        "work": work,
    }
    number = os.environ.get("RANK", "0")
    (Path(out) / f"measured-{number}.json").write_text(json.dumps(facts))


def own_mb() -> float:
    """Return the resident memory of this process that no file backs."""
    found = re.search(r"RssAnon:\s+(\d+) kB", Path("/proc/self/status").read_text())
    return int(found[1]) / 1024 if found else float("nan")


if __name__ == "__main__":
    if len(sys.argv) > 1:
        measured(**json.loads(sys.argv[1]))
    for row in run() if len(sys.argv) == 1 else ():
        print(", ".join(f"{name} {value}" for name, value in row.items()))
