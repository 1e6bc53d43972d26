"""Launcher of a training's processes on one machine; they find each other as those of ``torchrun`` do."""

from __future__ import annotations

import multiprocessing
import os
import pickle
import signal
import socket
import time
import traceback
from collections.abc import Callable, Mapping
from contextlib import suppress
from multiprocessing import connection, parent_process
from multiprocessing.connection import Connection
from multiprocessing.process import BaseProcess
from threading import Thread
from typing import Any, TypeVar, cast

from tactogram.datasets.examples import cores
from tactogram.errors import RunError, TactogramError, one_line
from tactogram.main_script import allowed_processes
from tactogram.workflows.progress import ProgressCallback

T = TypeVar("T")

WATCH_S = 0.2
"""Longest time until a stop is passed on."""
GRACE_S = 5.0
"""Time in which processes must end by themselves after one failed; then they are killed."""
SHOWN_S = 0.05
"""Shortest time between two steps of progress that are passed on."""


def in_processes(
    job: Callable[..., T],
    arguments: Mapping[str, Any],
    *,
    count: int,
    progress: ProgressCallback,
    stop: Callable[[], bool],
) -> T:
    """Call ``job`` in ``count`` new processes, and return what the first one returned.

    ``job`` and its ``arguments`` are pickled; ``progress`` and ``stop`` stay here, and the job gets its own by these
    names. The failure of one process ends all.

    Raises
    ------
    RunError
        If a process was killed. Errors that a process raised are raised here.
    """
    allowed_processes(count, 1)
    context = multiprocessing.get_context("spawn")
    stopping, address = context.Event(), free_port()
    workers: list[tuple[BaseProcess, Connection]] = []
    try:
        for number in range(count):
            receiver, sender = context.Pipe(duplex=False)
            process = context.Process(
                target=_work,
                args=(job, dict(arguments), number, count, address, sender, stopping),
                daemon=True,
            )
            process.start()
            sender.close()
            workers.append((process, receiver))
        result: T = _watched(workers, stopping.set, progress, stop)
        return result
    finally:
        _end(workers)


def _watched(
    workers: list[tuple[BaseProcess, Connection]],
    ask_to_stop: Callable[[], None],
    progress: ProgressCallback,
    stop: Callable[[], bool],
) -> Any:
    """Pass on progress until all have ended; return the first one's result, or raise the error that ended them."""
    results: dict[int, Any] = {}
    errors: dict[int, Exception] = {}
    numbers: dict[Any, int] = {receiver: number for number, (_, receiver) in enumerate(workers)}
    while numbers and not errors:
        if stop():
            ask_to_stop()
        for receiver in connection.wait(list(numbers), timeout=WATCH_S):
            number = numbers[receiver]
            try:
                kind, content = cast(Connection, receiver).recv()
            except EOFError:
                del numbers[receiver]
                if number not in results:
                    errors[number] = _killed(workers[number][0], number, len(workers))
                continue
            if kind == "progress":
                progress(*content)
            elif kind == "result":
                results[number] = content
            else:
                errors[number] = content
    if errors:
        raise _cause(workers, errors)
    return results[0]


def _cause(workers: list[tuple[BaseProcess, Connection]], errors: dict[int, Exception]) -> Exception:
    """Return the error that came first: others are of processes that lost their connection to it."""
    for number, (process, _) in enumerate(workers):
        if process.exitcode is not None and process.exitcode < 0:
            return _killed(process, number, len(workers))
    for number, (_, receiver) in enumerate(workers):
        with suppress(EOFError, OSError):
            while number not in errors and receiver.poll():
                kind, content = receiver.recv()
                if kind == "error":
                    errors[number] = content
    return min(errors.values(), key=lambda error: not isinstance(error, TactogramError))


def _killed(process: BaseProcess, number: int, count: int) -> RunError:
    process.join(GRACE_S)
    code = process.exitcode or 0
    how = f"was killed by {signal.Signals(-code).name}" if code < 0 else f"ended with status {code}"
    return RunError(
        f"process {number + 1} of {count} {how}, perhaps out of memory; the training has ended, and resuming it "
        "continues from its last checkpoint"
    )


def _end(workers: list[tuple[BaseProcess, Connection]]) -> None:
    """Let processes end, e.g. save a checkpoint, and kill those that do not."""
    until = time.monotonic() + GRACE_S
    for process, _ in workers:
        process.join(max(0.0, until - time.monotonic()))
    for process, receiver in workers:
        process.kill()
        process.join()
        receiver.close()


def _work(
    job: Callable[..., Any],
    arguments: dict[str, Any],
    number: int,
    count: int,
    address: int,
    sender: Connection,
    stopping: Any,
) -> None:
    """Call ``job`` as process ``number`` of ``count``, and send what becomes of it."""
    _follow_parent()
    os.environ |= {
        "MASTER_ADDR": "127.0.0.1",
        "MASTER_PORT": str(address),
        "TORCHELASTIC_RUN_ID": "tactogram",
        "RANK": str(number),
        "LOCAL_RANK": str(number),
        "GROUP_RANK": "0",
        "WORLD_SIZE": str(count),
        "LOCAL_WORLD_SIZE": str(count),
    }
    import torch

    torch.set_num_threads(max(1, min(torch.get_num_threads(), cores() // count)))
    try:
        progress = _Sender(sender) if number == 0 else _silent
        sender.send(("result", job(**arguments, progress=progress, stop=stopping.is_set)))
    except Exception as error:  # of any kind: the parent raises it
        sender.send(("error", _sendable(error)))


class _Sender:
    """Sends progress to the parent, not more often than it can be seen."""

    def __init__(self, sender: Connection) -> None:
        self._sender, self._sent = sender, 0.0

    def __call__(self, task: str, done: int, total: int, note: str = "") -> None:
        if done >= total or time.monotonic() - self._sent >= SHOWN_S:
            self._sender.send(("progress", (task, done, total, note)))
            self._sent = time.monotonic()


def _silent(task: str, done: int, total: int, note: str = "") -> None:
    """Show nothing."""


def _sendable(error: Exception) -> Exception:
    """Return an error with its traceback as a note, if that can be pickled."""
    if not isinstance(error, TactogramError):
        error.add_note("".join(traceback.format_exception(error)))
    try:
        pickle.loads(pickle.dumps(error))  # noqa: S301 (made here)
    except Exception:  # an error of a library that cannot be pickled
        return RunError(f"{type(error).__name__}: {one_line(error)}")
    return error


def _follow_parent() -> None:
    """Leave interrupts to the parent, and end with it."""
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    parent = parent_process()

    def end_with_parent() -> None:
        if parent is not None:
            connection.wait([parent.sentinel])
            os._exit(1)

    Thread(target=end_with_parent, daemon=True).start()


def free_port() -> int:
    """Return a port that no process listens on."""
    with socket.socket() as held:
        held.bind(("127.0.0.1", 0))
        return int(held.getsockname()[1])
