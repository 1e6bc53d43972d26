"""Command line processes that outlive the server."""

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

from tactogram.workflows import VARIABLE

SAME_S = 2.0
"""Tolerance between two readings of a process's start time: the clock may be adjusted in between."""
NICE = 5
"""Keeps the pages responsive during a training."""


@dataclass(frozen=True)
class DetachedProcess:
    """A process, identified by its number and start time (s since 1970): numbers are reused."""

    pid: int
    created: float

    def alive(self) -> bool:
        """Return whether it is running; a zombie is not."""
        return self._process() is not None

    def terminate(self) -> bool:
        """Send SIGTERM; return whether it was running."""
        process = self._process()
        if process is not None:
            with contextlib.suppress(psutil.NoSuchProcess):
                process.terminate()
        return process is not None

    def kill(self) -> bool:
        """Kill it and its children, which share its session; return whether it was running."""
        if self._process() is None:
            return False
        with contextlib.suppress(ProcessLookupError):
            os.killpg(self.pid, signal.SIGKILL)
        return True

    def _process(self) -> psutil.Process | None:
        try:
            process = psutil.Process(self.pid)
            same = abs(process.create_time() - self.created) < SAME_S
            return process if same and process.status() != psutil.STATUS_ZOMBIE else None
        except psutil.Error:
            return None


def start(arguments: Sequence[str], *, folder: Path, log: Path) -> DetachedProcess:
    """Run ``tactogram`` in ``folder`` in a session of its own; ``log`` is overwritten with its stdout and stderr."""
    log.parent.mkdir(parents=True, exist_ok=True)
    with log.open("wb") as file:
        child = subprocess.Popen(
            [sys.executable, "-m", "tactogram", *arguments],
            cwd=folder,
            stdin=subprocess.DEVNULL,
            stdout=file,
            stderr=subprocess.STDOUT,
            start_new_session=True,
            env={**os.environ, "PYTHONUNBUFFERED": "1", VARIABLE: "0"},
        )
    threading.Thread(target=child.wait, name=f"reaper of {child.pid}", daemon=True).start()
    try:
        process = psutil.Process(child.pid)
        created = process.create_time()
        process.nice(NICE)
    except psutil.Error:  # it has ended
        created = 0.0
    return DetachedProcess(child.pid, created)
