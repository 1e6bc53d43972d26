"""Workers: speed-up by 1, 2 and 4 of them over a plain loop, and the overhead per task, on processes and on Ray.

The work is simulated strokes, one a task, each some tenths of a second on one thread. The speed-up is of tasks per
second once every worker has done one, against a plain loop before it. Where others use the machine, too, more
processes get more of it: the processor time per stroke, as a multiple of the loop's, shows what the workers themselves
cost. Start-up is the time until the first result of a task that does nothing (Ray itself is already running); overhead
is the time per task of 200 that do nothing. The median of three rounds, taken in turns.
"""

import time
from contextlib import contextmanager, nullcontext
from statistics import median

from tactogram.datasets.examples import cores
from tactogram.datasets.simulate import make, tasks
from tactogram.workflows.workers import run_tasks

COUNTS, STROKES, IDLE, ROUNDS = (1, 2, 4), 60, 200, 3


QUIET = {"log_to_driver": False, "logging_level": "ERROR"}


def run():
    todo = strokes()
    stroke(todo[0])  # compiles, and makes the height field
    found = {(on, count): [] for on in ("", "ray") for count in COUNTS}
    for _ in range(ROUNDS):
        for (on, count), rounds in found.items():
            rounds.append(measured(on, count, todo))
    return [
        {"on": on or ("this process" if count == 1 else "processes"), "workers": count, "cores": cores()}
        | {name: median(one[name] for one in rounds) for name in rounds[0]}
        for (on, count), rounds in found.items()
    ]


def strokes():
    """Return tasks on one surface, whose height field each worker makes once."""
    todo = tasks("stroking9", seed=0, per_class=STROKES, seconds=10.0, rate=6000.0)
    return [task for task in todo if (task.surface, task.contactor) == (todo[0].surface, todo[0].contactor)]


def measured(on, count, todo):
    """Return the figures of one engine and number of workers."""
    begun = time.perf_counter()
    alone = sum(map(stroke, todo)) / len(todo)
    loop = len(todo) / (time.perf_counter() - begun)
    with ray_of(count) if on else nullcontext():
        idle = timed(run_tasks(nothing, range(IDLE), on=on, processes=count))
        done = timed(run_tasks(stroke, todo, on=on, processes=count))
    # Each worker compiles and makes the height field before its first stroke.
    begun = max(
        next(at for at, outcome in done if outcome.worker == name) for name in {o.worker for _, o in done}
    )
    after = [(at, outcome.value) for at, outcome in done if at > begun]
    if not after:
        raise RuntimeError("the last worker began after all else was done: more strokes are needed")
    return {
        "speed-up": len(after) / (after[-1][0] - begun) / loop,
        "processor time per stroke": sum(used for _, used in after) / len(after) / alone,
        "start-up, s": idle[0][0],
        "overhead per task, ms": 1000 * (idle[-1][0] - idle[0][0]) / (len(idle) - 1),
    }


def timed(outcomes):
    """Return each outcome with its time, s."""
    begun = time.perf_counter()
    return [(time.perf_counter() - begun, outcome) for outcome in outcomes]


@contextmanager
def ray_of(count):
    """Start Ray with so many cores, whatever the machine has."""
    import ray

    ray.init("local", num_cpus=count, include_dashboard=False, object_store_memory=10**8, **QUIET)
    try:
        yield
    finally:
        ray.shutdown()


def nothing(number):
    return number


def stroke(task):
    """Return the processor time of a stroke, s."""
    begun = time.process_time()
    make(task)
    return time.process_time() - begun
