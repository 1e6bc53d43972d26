"""Widgets of the training pages: state badges, progress, task cards, and loss charts."""

from __future__ import annotations

import time
from collections import deque
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any

from nicegui import ui

from tactogram_studio.context import Studio
from tactogram_studio.layout import heading, report_errors
from tactogram_studio.pages.train.log import TaskProgress, duration_text, thinned, time_left
from tactogram_studio.pages.train.run_summary import RunSummary
from tactogram_studio.pages.train.trainings import StudioTask, TaskQueue, TaskStatus

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
"""Colours of curves; each has a contrast of at least 4.5:1 on white."""
READINGS = 40
"""Readings of a task's progress from which its speed is computed."""
ACTIVITIES = {"evaluate": "Evaluating", "simulate": "Simulating", "import": "Importing"}


@dataclass
class TrainContext:
    """Context of the pages that show tasks; ``readings`` are each task's progress over time, s."""

    studio: Studio
    trainings: TaskQueue
    readings: dict[str, deque[tuple[float, TaskProgress]]] = field(default_factory=dict)


class ProgressRow:
    """A task's progress bar, and a text with its speed and remaining time."""

    def __init__(self, context: TrainContext, *, label: str = "Progress") -> None:
        self._context = context
        self._bar = ui.linear_progress(value=0.0, show_value=False, size="6px").props(f'aria-label="{label}"')
        self._text = ui.label().classes("small")

    def update(self, task: StudioTask, status: TaskStatus) -> None:
        """Show the present progress."""
        self._bar.value = status.progress.share if status.progress else 0.0
        self._text.text = self._describe(task, status)

    def _describe(self, task: StudioTask, status: TaskStatus) -> str:
        if status.state == "waiting":
            return f"waiting: at most {self._context.trainings.max_running} tasks run at once"
        progress = status.progress
        if progress is None:
            return "starting"
        readings = self._context.readings.setdefault(task.id, deque(maxlen=READINGS))
        if not readings or readings[-1][1] != progress:
            readings.append((time.monotonic(), progress))
        text = f"{progress.name}: {progress.done:,} of {progress.total:,}"
        left = time_left(progress, readings)
        if left is not None and progress.done < progress.total:
            text += f" · {left[0]:.3g} per second · {duration_text(left[1])} left"
        return text


class TaskCards:
    """Cards of the unfinished tasks of some kinds; progress is updated in place, so buttons stay where they are."""

    def __init__(self, context: TrainContext, kinds: Sequence[str], *, title: str = "") -> None:
        self._context, self._kinds, self._title = context, kinds, title
        self._tasks: list[tuple[StudioTask, TaskStatus]] = []
        self._rows: dict[str, ProgressRow] = {}

    def unfinished(self, tasks: Sequence[StudioTask]) -> list[tuple[StudioTask, TaskStatus]]:
        """Return the tasks to show with their status; reads files."""
        status_of = self._context.trainings.status
        shown = [(task, status_of(task)) for task in tasks if task.kind in self._kinds]
        return [(task, status) for task, status in shown if status.state != "finished"]

    def update(self, tasks: list[tuple[StudioTask, TaskStatus]]) -> None:
        """Show other tasks, or their progress."""
        drawn, self._tasks = self._tasks, tasks
        if _states(drawn) != _states(tasks):
            self.draw.refresh()
        for task, status in tasks:
            if task.id in self._rows:
                self._rows[task.id].update(task, status)

    @ui.refreshable_method
    def draw(self) -> None:
        """Draw the cards."""
        self._rows.clear()
        if self._tasks and self._title:
            heading(self._title)
        for task, status in self._tasks:
            with ui.element("section").classes("card w-full").props('aria-live="polite"'):
                self._draw_card(task, status)

    def _draw_card(self, task: StudioTask, status: TaskStatus) -> None:
        trainings = self._context.trainings
        with ui.row().classes("items-center w-full gap-2"):
            ui.label(f"{ACTIVITIES[task.kind]} {task.about}")
            badge(status.state)
            ui.space()
            if status.active:
                stop = report_errors(lambda: trainings.stop(task.id, at_once=task.kind != "evaluate"))
                ui.button("Stop", on_click=stop).props("outline dense")
            else:
                dismiss = report_errors(lambda: trainings.forget(task.id))
                ui.button("Dismiss", on_click=dismiss).props("flat dense")
        if status.active:
            self._rows[task.id] = ProgressRow(self._context)
            self._rows[task.id].update(task, status)
        elif status.message:
            ui.label(status.message).classes("small text-negative")


def _states(tasks: Sequence[tuple[StudioTask, TaskStatus]]) -> list[tuple[str, str, str]]:
    return [(task.id, status.state, status.message) for task, status in tasks]


def badge(state: str) -> None:
    """Draw a state."""
    shown = ui.badge(state, color=COLOURS[state]).classes("text-sm q-px-sm q-py-xs")
    shown.props(f'data-state="{state}"')


def state_of(summary: RunSummary | None, status: TaskStatus | None) -> str:
    """Return the state of a run: of its active task, else according to its folder."""
    if status is not None and status.active:
        return status.state
    if summary is not None and summary.finished:
        return "finished"
    if summary is not None and summary.training:
        return "running"
    return status.state if status is not None else "unfinished"


def loss_options(
    curves: Mapping[str, Sequence[tuple[int, float]]], *, log_scale: bool = False
) -> dict[str, Any]:
    """Return the chart of losses, given as (step, value); ``log_scale`` applies only if all values are positive."""
    positive = all(value > 0 for points in curves.values() for _, value in points)
    return {
        "animation": False,
        "color": list(INKS),
        "aria": {"enabled": True},
        "grid": {"left": 60, "right": 20, "top": 40, "bottom": 45},
        "legend": {"show": True, "top": 0, "type": "scroll"},
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
