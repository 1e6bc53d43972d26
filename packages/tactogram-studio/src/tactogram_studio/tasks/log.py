"""A task's process, which outlives the server, and what its log and folder say."""

from __future__ import annotations

import contextlib
import json
import os
import re
import signal
import subprocess
import sys
import threading
from collections import Counter
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import psutil
from safetensors import SafetensorError, safe_open

from tactogram.workflows import VARIABLE

PROGRESS = re.compile(r"(?P<task>.+): (?P<done>\d+)/(?P<total>\d+)(?: .*)?")
MESSAGE = "tactogram: "
STOPPED = ("stopped ", "interrupted")
SAME_S = 2.0
"""Tolerance between two readings of a process's start time: the clock may be adjusted in between."""
NICE = 5
"""Keeps the pages responsive during a training."""


@dataclass(frozen=True)
class TaskProgress:
    """Progress of a stage, such as ``prepare`` or ``train``."""

    name: str
    done: int
    total: int

    @property
    def share(self) -> float:
        """The completed share, 0 to 1."""
        return self.done / max(1, self.total)


def progress_of(log: str, run: Path | None = None) -> TaskProgress | None:
    """Return the last progress in a log, refined by the run's metrics; None if the log has none.

    The log has a line per tenth of a stage; ``metrics.jsonl`` has one every few steps, with the stage's number.
    """
    matches = [match for line in log.splitlines() if (match := PROGRESS.fullmatch(line.strip()))]
    if not matches:
        return None
    last = matches[-1]
    progress = TaskProgress(last["task"], int(last["done"]), int(last["total"]))
    if run is not None and (line := last_metrics(run)) is not None:
        step = int(line.get("step", 0))
        # A step outside the log's current tenth most likely belongs to another stage.
        if progress.done <= step <= min(progress.total, progress.done + progress.total // 10 + 1):
            progress = TaskProgress(progress.name, step, progress.total)
    return progress


def last_message(log: str) -> str | None:
    """Return why a process ended: the command line's message, or the last line of a traceback; None if neither."""
    lines = [line.strip() for line in log.splitlines() if line.strip()]
    for line in reversed(lines):
        if line.startswith(MESSAGE):
            return line.removeprefix(MESSAGE)
    if any(line.startswith("Traceback (most recent call last)") for line in lines):
        return lines[-1]
    return None


def reports_stop(message: str) -> bool:
    """Return whether a `last_message` says that the process was stopped."""
    return message.startswith(STOPPED)


def read_metrics(run: Path) -> list[dict[str, Any]]:
    """Return the metrics of a run, without unfinished or broken lines."""
    try:
        text = (run / "metrics.jsonl").read_text(encoding="utf-8")
    except OSError:
        return []
    return [line for raw in text.split("\n")[:-1] if (line := _parse_line(raw)) is not None]


def last_metrics(run: Path, tail: int = 4096) -> dict[str, Any] | None:
    """Return the last metrics of a run, reading only the end of the file."""
    try:
        with (run / "metrics.jsonl").open("rb") as file:
            file.seek(max(0, file.seek(0, 2) - tail))
            lines = file.read().decode("utf-8", "replace").split("\n")[:-1]
    except OSError:
        return None
    return next((line for raw in reversed(lines) if (line := _parse_line(raw)) is not None), None)


def loss_curves(lines: Sequence[Mapping[str, Any]]) -> dict[str, list[tuple[int, float]]]:
    """Return the losses in a run's metrics by name, each as (step, value).

    Stages of a single step, such as fitting a scale, are omitted.
    """
    counts = Counter(line["stage"] for line in lines)
    stages = [stage for stage, count in sorted(counts.items()) if count > 1]
    curves: dict[str, list[tuple[int, float]]] = {}
    for line in lines:
        if line["stage"] not in stages:
            continue
        for name, value in line.items():
            if name not in ("stage", "step") and isinstance(value, int | float):
                label = name if len(stages) == 1 else f"{name} (stage {stages.index(line['stage']) + 1})"
                curves.setdefault(label, []).append((int(line["step"]), float(value)))
    return curves


def thinned(points: Sequence[tuple[int, float]], most: int = 400) -> list[tuple[int, float]]:
    """Return at most ``most`` points of a curve: means of consecutive points, each at the last step of its group."""
    if len(points) <= most:
        return list(points)
    size = -(-len(points) // most)
    parts = [points[begin : begin + size] for begin in range(0, len(points), size)]
    return [(part[-1][0], sum(value for _, value in part) / len(part)) for part in parts]


def checkpoint_position(run: Path) -> dict[str, int] | None:
    """Return ``stage`` and ``step`` of a run's checkpoint, reading only its header."""
    try:
        with safe_open(run / "checkpoint.safetensors", "numpy") as file:
            facts: dict[str, int] = json.loads(file.metadata()["tactogram"])["facts"]
        return {"stage": int(facts["stage"]), "step": int(facts["step"])}
    except (OSError, ValueError, KeyError, TypeError, SafetensorError):
        return None


def time_left(
    progress: TaskProgress, readings: Sequence[tuple[float, TaskProgress]]
) -> tuple[float, float] | None:
    """Return steps per second and the seconds left in the stage, from earlier readings with their times, s.

    It is None with fewer than two readings of the stage.
    """
    stage = (progress.name, progress.total)
    same = [(time_s, earlier) for time_s, earlier in readings if (earlier.name, earlier.total) == stage]
    if len(same) < 2:
        return None
    (first_at, first), (last_at, last) = same[0], same[-1]
    done, seconds = last.done - first.done, last_at - first_at
    if done <= 0 or seconds <= 0:
        return None
    return done / seconds, (progress.total - progress.done) * seconds / done


def _parse_line(raw: str) -> dict[str, Any] | None:
    try:
        values = json.loads(raw)
    except ValueError:
        return None
    return values if isinstance(values, dict) and {"stage", "step"} <= values.keys() else None


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
