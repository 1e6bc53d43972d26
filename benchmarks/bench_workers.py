"""Workers: speed-up by 1, 2 and 4 of them over a plain loop, and the overhead per task, on processes and on Ray.

The work is simulated strokes, one a task, each some tenths of a second on one thread. The speed-up is of tasks per
second from the first result on; start-up is the time until the first result of a task that does nothing (Ray itself is
already running); overhead is the time per task of 300 that do nothing. The best of three rounds, taken in turns. With
more workers than cores no speed-up beyond the cores is possible.
"""

import time
from contextlib import contextmanager, nullcontext

from tactogram.datasets.examples import cores
from tactogram.datasets.simulate import make, tasks
from tactogram.workflows.workers import run_tasks

COUNTS, STROKES, IDLE, ROUNDS = (1, 2, 4), 40, 300, 3


def run():
    todo = tasks("stroking9", seed=0, per_class=8, seconds=20.0, rate=6000.0)[:STROKES]
    stroke(todo[0])  # compiles
    plain = []
    found = {(on, count): [] for on in ("", "ray") for count in COUNTS}
    for _ in range(ROUNDS):
        begun = time.perf_counter()
        for task in todo:
            stroke(task)
        plain.append(STROKES / (time.perf_counter() - begun))
        for (on, count), rounds in found.items():
            rounds.append(measured(on, count, todo))
    return [
        {
            "on": on or ("this process" if count == 1 else "processes"),
            "workers": count,
            "cores": cores(),
            "speed-up": max(rate for rate, _, _ in rounds) / max(plain),
            "start-up, s": min(start for _, start, _ in rounds),
            "overhead per task, ms": 1000 * min(idle for _, _, idle in rounds),
        }
        for (on, count), rounds in found.items()
    ]


def measured(on, count, todo):
    """Return strokes per second, the start-up, and the time per idle task, s."""
    with ray_of(count) if on else nullcontext():
        first, last = times(run_tasks(nothing, range(IDLE), on=on, processes=count))
        begun, end = times(run_tasks(stroke, todo, on=on, processes=count))
    return (len(todo) - count) / (end - begun), first, (last - first) / (IDLE - 1)


def times(outcomes):
    """Return the time of the first and of the last outcome, s."""
    begun = time.perf_counter()
    ended = [time.perf_counter() - begun for _ in outcomes]
    return ended[0], ended[-1]


@contextmanager
def ray_of(count):
    """Start Ray with so many cores, whatever the machine has."""
    import ray

    ray.init("local", num_cpus=count, include_dashboard=False, object_store_memory=10**8, log_to_driver=False)
    try:
        yield
    finally:
        ray.shutdown()


def nothing(number):
    return number


def stroke(task):
    return float(make(task).streams["acceleration"].samples.std())
