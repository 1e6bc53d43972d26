"""Tasks on Ray: on one that is started here, or on a cluster."""

from __future__ import annotations

import logging
import os
import socket
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from itertools import islice
from typing import Any, TypeVar

from tactogram.datasets.examples import cores
from tactogram.errors import ParameterError, one_line
from tactogram.extras import imported
from tactogram.workflows.workers.one_task import ATTEMPTS, ONE_THREAD, Attempt, attempted

T = TypeVar("T")
R = TypeVar("R")

STORE_BYTES = 200_000_000
"""Shared memory of a Ray that is started here: values are small, and containers have little of it."""
WAITING = 4
"""Tasks per core that Ray holds at a time: enough to keep all cores busy, and few values that wait to be taken."""
# Tasks see the node's GPUs, as processes of the local pool do: Ray would hide them from tasks that reserve none.
_GPUS = {"RAY_ACCEL_ENV_VAR_OVERRIDE_ON_ZERO": "0"}
_DRIVER = {"RAY_usage_stats_enabled": "0", **_GPUS}


def on_ray(
    function: Callable[[T], R], tasks: Sequence[T], address: str, processes: int
) -> Iterator[tuple[T, Attempt[R]]]:
    """Yield each task with its attempt, as they end; "" for ``address`` is a Ray of this machine."""
    with connected(address, processes) as ray:
        remote = ray.remote(num_cpus=1, max_retries=ATTEMPTS - 1, runtime_env={"env_vars": _environment()})
        attempt, shared = remote(attempted), ray.put(function)
        todo = iter(tasks)
        running: dict[Any, T] = {}
        try:
            while True:
                most = WAITING * max(1, int(ray.cluster_resources().get("CPU", 1)))  # nodes come and go
                for task in islice(todo, max(most - len(running), 0)):
                    running[attempt.remote(shared, task)] = task
                if not running:
                    break
                [reference], _ = ray.wait(list(running))
                task = running.pop(reference)
                try:
                    yield task, ray.get(reference)
                except ray.exceptions.RayTaskError:  # a bug in the function
                    raise
                except ray.exceptions.RayError:  # a worker or node died again and again
                    yield (
                        task,
                        (None, f"its worker died {ATTEMPTS} times; the system may have run out of memory"),
                    )
        finally:
            for reference in running:
                ray.cancel(reference, force=True)


@contextmanager
def connected(address: str, processes: int = 1) -> Iterator[Any]:
    """Yield the module ``ray``, connected; a connection that was there before is used, and stays.

    Raises `ParameterError` if no cluster answers at ``address``; `MissingExtraError` if Ray is not installed.
    """
    for name, value in _DRIVER.items():
        os.environ.setdefault(name, value)
    ray: Any = imported("ray", extra="ray", what="tasks on Ray")
    if ray.is_initialized():
        yield ray
        return
    options: dict[str, Any] = {
        "runtime_env": {"env_vars": _environment()},
        "logging_level": logging.ERROR,
        "log_to_driver": False,
    }
    try:
        if address:
            _reach(address)
            ray.init(address, **options)
        else:
            ray.init(
                "local",
                num_cpus=processes if processes > 1 else cores(),
                include_dashboard=False,
                object_store_memory=STORE_BYTES,
                **options,
            )
    except Exception as error:  # Ray raises bare ones
        raise ParameterError.must(
            "on",
            "be ray or the address of a Ray cluster that runs (`ray start --head` starts one); "
            f"{address or 'the local Ray'}: {one_line(error)}",
        ) from error
    try:
        yield ray
    finally:
        ray.shutdown()


def _reach(address: str) -> None:
    """Raise an `OSError` unless something listens at HOST:PORT: Ray would try for minutes."""
    host, _, port = address.rpartition("/")[2].rpartition(":")
    if host and port.isdecimal():
        socket.create_connection((host, int(port)), timeout=10).close()


def _environment() -> dict[str, str]:
    """Return the environment of the workers: one thread, and the modules and extensions of this process."""
    own = {name: text for name, text in os.environ.items() if name.startswith("TACTOGRAM_")}
    path = {"PYTHONPATH": os.environ["PYTHONPATH"]} if os.environ.get("PYTHONPATH") else {}
    return {**own, **path, **ONE_THREAD, **_GPUS}
