"""Widgets of the training pages: states, progress, charts of losses."""

from __future__ import annotations

import time
from collections import deque
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any

from nicegui import ui

from tactogram.studio.context import Studio
from tactogram.studio.pages.train.log import TaskProgress, duration, thinned, time_left
from tactogram.studio.pages.train.run_facts import RunSummary
from tactogram.studio.pages.train.trainings import StudioTask, TaskQueue, TaskStatus

COLOURS = {
    "waiting": "grey-8",
    "running": "primary",
    "stopping": "warning",
    "stopped": "warning",
    "unfinished": "warning",
    "finished": "positive",
    "failed": "negative",
}
INKS = ("#0b5d66", "#b3541e", "#5b4a9e", "#1e6b34", "#a4262c", "#5a6470", "#8a5a00", "#1f5fa8")
"""Of curves; each at least 4.5:1 on white."""
REMEMBERED = 40
"""Readings of a training's step that its speed follows from."""


@dataclass
class TrainContext:
    """Context of the training pages.

    Parameters
    ----------
    studio : Studio
    trainings : Trainings
    """

    studio: Studio
    trainings: TaskQueue
    seen: dict[str, deque[tuple[float, TaskProgress]]] = field(default_factory=dict)
    """Readings of each training's step with their times, s: gone after a restart, and made anew."""


def badge(state: str) -> ui.badge:
    """Draw a state."""
    return (
        ui.badge(state, color=COLOURS[state])
        .classes("text-sm q-px-sm q-py-xs")
        .props(f'data-state="{state}"')
    )


def state_of(facts: RunSummary | None, status: TaskStatus | None) -> str:
    """Return the state of a run: of its training where that is known, else what its folder says."""
    if status is not None and status.active:
        return status.state
    if facts is not None and facts.finished:
        return "finished"
    if facts is not None and facts.at_work:
        return "running"
    return status.state if status is not None else "unfinished"


def seen_of(desk: TrainContext, task: StudioTask, status: TaskStatus) -> None:
    """Remember how far a training is now."""
    if status.step is not None:
        held = desk.seen.setdefault(task.id, deque(maxlen=REMEMBERED))
        if not held or held[-1][1] != status.step:
            held.append((time.monotonic(), status.step))


def progress_text(desk: TrainContext, task: StudioTask, status: TaskStatus) -> str:
    """Return how far a task is, how fast, and how long its stage still takes."""
    if status.state == "waiting":
        return f"waits: {desk.trainings.most} at a time on this machine"
    if status.step is None:
        return "beginning"
    step = status.step
    text = f"{step.name}: {step.done:,} of {step.total:,}"
    left = time_left(step, list(desk.seen.get(task.id, ())))
    if left is not None and step.done < step.total:
        text += f" · {left[0]:.3g} per second · {duration(left[1])} left"
    return text


def set_progress(
    desk: TrainContext, task: StudioTask, status: TaskStatus, bar: ui.linear_progress, label: ui.label
) -> None:
    """Show how far a task is."""
    bar.value = status.step.share if status.step else 0.0
    label.text = progress_text(desk, task, status)


def loss_options(
    curves: Mapping[str, Sequence[tuple[int, float]]], *, log_scale: bool = False, names: bool = True
) -> dict[str, Any]:
    """Return the chart of losses over steps.

    Parameters
    ----------
    curves : mapping
        Each as (step, value).
    log_scale : bool
        Only where every value is above 0.
    names : bool
        Whether there is a legend.
    """
    positive = all(value > 0 for points in curves.values() for _, value in points)
    return {
        "animation": False,
        "color": list(INKS),
        "aria": {"enabled": True},
        "grid": {"left": 60, "right": 20, "top": 40 if names else 16, "bottom": 45},
        "legend": {"show": names, "top": 0, "type": "scroll"},
        "tooltip": {"trigger": "axis"},
        "xAxis": {"type": "value", "name": "step", "nameLocation": "middle", "nameGap": 28, "min": 0},
        "yAxis": {"type": "log" if log_scale and positive else "value", "scale": True},
        "series": [
            {
                "type": "line",
                "name": name,
                "showSymbol": len(points) < 3,
                "lineStyle": {"width": 1.5},
                "data": [list(point) for point in thinned(points)],
            }
            for name, points in curves.items()
        ],
    }
