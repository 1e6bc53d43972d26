"""Training log: progress read from a run folder and the log of its process."""

from __future__ import annotations

import json
import re
import struct
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

PROGRESS = re.compile(r"(?P<task>.+): (?P<done>\d+)/(?P<total>\d+)(?: .*)?")
SAID = "tactogram: "
STOPPED = ("stopped ", "interrupted")


@dataclass(frozen=True)
class TaskProgress:
    """Progress of a task.

    Parameters
    ----------
    name : str
        Of the stage: ``prepare``, ``train``, …
    done, total : int
    """

    name: str
    done: int
    total: int

    @property
    def share(self) -> float:
        """0 to 1."""
        return self.done / max(1, self.total)


def step_of(log: str, run: Path | None = None) -> TaskProgress | None:
    """Return the last progress that a log shows, made exact by the run's metrics; None where it shows none.

    The log has a line each tenth of a stage; ``metrics.jsonl`` one each few steps, with a number for the stage.
    """
    found = [match for line in log.splitlines() if (match := PROGRESS.fullmatch(line.strip()))]
    if not found:
        return None
    last = found[-1]
    step = TaskProgress(last["task"], int(last["done"]), int(last["total"]))
    if run is not None and (line := last_metrics(run)) is not None:
        at = int(line.get("step", 0))
        # Of another stage it would as a rule be outside of the tenth that the log is in.
        if step.done <= at <= min(step.total, step.done + step.total // 10 + 1):
            step = TaskProgress(step.name, at, step.total)
    return step


def complaint(log: str) -> str | None:
    """Return why a process ended, in the command line's words or those of an exception; None where it says nothing."""
    lines = [line.strip() for line in log.splitlines() if line.strip()]
    for line in reversed(lines):
        if line.startswith(SAID):
            return line.removeprefix(SAID)
        if line.startswith("tactogram ") and ": error: " in line:
            return line.partition(": error: ")[2]
    if any(line.startswith("Traceback (most recent call last)") for line in lines):
        return lines[-1]
    return None


def is_stopped(why: str) -> bool:
    """Say whether a `complaint` is that it was asked to stop."""
    return why.startswith(STOPPED)


def metrics(run: Path) -> list[dict[str, Any]]:
    """Return the logged lines of a run; one that is being written, or broken, is left out."""
    try:
        text = (run / "metrics.jsonl").read_text(encoding="utf-8")
    except OSError:
        return []
    return [line for raw in text.split("\n")[:-1] if (line := _object(raw)) is not None]


def last_metrics(run: Path, tail: int = 4096) -> dict[str, Any] | None:
    """Return the last logged line of a run, reading only the end of the file."""
    try:
        with (run / "metrics.jsonl").open("rb") as file:
            file.seek(max(0, file.seek(0, 2) - tail))
            lines = file.read().decode("utf-8", "replace").split("\n")[:-1]
    except OSError:
        return None
    return next((found for raw in reversed(lines) if (found := _object(raw)) is not None), None)


def curves(lines: Sequence[Mapping[str, Any]]) -> dict[str, list[tuple[int, float]]]:
    """Return the losses of the longest stage by name, each as (step, value).

    A stage of one step, such as fitting a scale, is no curve.
    """
    counts: dict[int, int] = {}
    for line in lines:
        counts[line["stage"]] = counts.get(line["stage"], 0) + 1
    found: dict[str, list[tuple[int, float]]] = {}
    stages = [stage for stage, count in sorted(counts.items()) if count > 1]
    for line in lines:
        if line["stage"] not in stages:
            continue
        for name, value in line.items():
            if name not in ("stage", "step") and isinstance(value, int | float):
                label = name if len(stages) == 1 else f"{name} (stage {stages.index(line['stage']) + 1})"
                found.setdefault(label, []).append((int(line["step"]), float(value)))
    return found


def thinned(points: Sequence[tuple[int, float]], most: int = 400) -> list[tuple[int, float]]:
    """Return at most ``most`` points of a curve: the mean of each stretch at its last step."""
    if len(points) <= most:
        return list(points)
    size = -(-len(points) // most)
    parts = [points[place : place + size] for place in range(0, len(points), size)]
    return [(part[-1][0], sum(value for _, value in part) / len(part)) for part in parts]


def checkpoint_step(run: Path) -> dict[str, int] | None:
    """Return ``stage`` and ``step`` that the last checkpoint of a run is of, reading its head only."""
    try:
        with (run / "checkpoint.safetensors").open("rb") as file:
            (length,) = struct.unpack("<Q", file.read(8))
            head = json.loads(file.read(min(length, 50_000_000)))
        facts: dict[str, int] = json.loads(head["__metadata__"]["tactogram"])["facts"]
        return {"stage": int(facts["stage"]), "step": int(facts["step"])}
    except (OSError, ValueError, KeyError, TypeError, struct.error):
        return None


def time_left(step: TaskProgress, seen: Sequence[tuple[float, TaskProgress]]) -> tuple[float, float] | None:
    """Return steps per second and the seconds left of the stage, from what was seen; None where that is too little.

    Parameters
    ----------
    step : Step
    seen : sequence of (float, Step)
        Earlier readings with their times, s.
    """
    same = [(at, earlier) for at, earlier in seen if (earlier.name, earlier.total) == (step.name, step.total)]
    if len(same) < 2:
        return None
    (first_at, first), (last_at, last) = same[0], same[-1]
    done, took = last.done - first.done, last_at - first_at
    if done <= 0 or took <= 0:
        return None
    return done / took, (step.total - step.done) * took / done


def duration(seconds: float) -> str:
    """Return a length of time as people say it."""
    if seconds < 90:
        return f"{max(1, round(seconds))} s"
    if seconds < 90 * 60:
        return f"{round(seconds / 60)} min"
    return f"{seconds / 3600:.1f} h"


def _object(raw: str) -> dict[str, Any] | None:
    try:
        found = json.loads(raw)
    except ValueError:
        return None
    return found if isinstance(found, dict) and {"stage", "step"} <= found.keys() else None
