"""Processes of the command line that outlive the server that began them."""

from __future__ import annotations

import contextlib
import os
import signal
import subprocess
import sys
import threading
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

import psutil

SAME_S = 2.0
"""How far two readings of when a process began may be apart: clocks are set meanwhile."""
NICE = 5
"""So that pages stay quick while something is learned."""


@dataclass(frozen=True)
class DetachedProcess:
    """A process, told from a later one of the same number by when it began.

    Parameters
    ----------
    pid : int
    created : float
        Seconds since 1970.
    """

    pid: int
    created: float

    def alive(self) -> bool:
        """Say whether it is still there and not only waiting to be reaped."""
        return self._found() is not None

    def ask_to_end(self) -> bool:
        """Send SIGTERM; return whether it was there."""
        found = self._found()
        if found is not None:
            with contextlib.suppress(psutil.NoSuchProcess):
                found.terminate()
        return found is not None

    def end(self) -> bool:
        """Kill it with all that it started, which are of its session; return whether it was there."""
        if self._found() is None:
            return False
        with contextlib.suppress(ProcessLookupError):
            os.killpg(self.pid, signal.SIGKILL)
        return True

    def _found(self) -> psutil.Process | None:
        try:
            process = psutil.Process(self.pid)
            same = abs(process.create_time() - self.created) < SAME_S
            return process if same and process.status() != psutil.STATUS_ZOMBIE else None
        except psutil.Error:
            return None


def start(arguments: Sequence[str], *, folder: Path, log: Path) -> DetachedProcess:
    """Run ``tactogram`` with ``arguments`` in ``folder``, in a session of its own.

    Parameters
    ----------
    arguments : sequence of str
        Verb first.
    folder : Path
        What relative paths are relative to.
    log : Path
        Takes what it says, on both streams; begun anew.

    Raises
    ------
    OSError
        If it cannot be started.
    """
    log.parent.mkdir(parents=True, exist_ok=True)
    with log.open("wb") as file:
        child = subprocess.Popen(
            [sys.executable, "-m", "tactogram.cli", *arguments],
            cwd=folder,
            stdin=subprocess.DEVNULL,
            stdout=file,
            stderr=subprocess.STDOUT,
            start_new_session=True,
            env={**os.environ, "PYTHONUNBUFFERED": "1"},
        )
    threading.Thread(target=child.wait, name=f"reaper of {child.pid}", daemon=True).start()
    try:
        process = psutil.Process(child.pid)
        created = process.create_time()
        process.nice(NICE)
    except psutil.Error:  # over already
        created = 0.0
    return DetachedProcess(child.pid, created)
