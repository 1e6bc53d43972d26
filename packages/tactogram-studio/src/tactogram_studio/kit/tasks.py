"""Tasks on pages: the form that starts one, cards with state, progress and buttons, and the example surfaces."""

from __future__ import annotations

import time
from collections import deque
from collections.abc import Callable, Sequence

from nicegui import ui

from tactogram.errors import TactogramError
from tactogram.training import duration_text
from tactogram_studio.kit.cards import alert, card, code, heading, refusals
from tactogram_studio.layout import in_background
from tactogram_studio.tasks.log import time_left
from tactogram_studio.tasks.queue import Kind, StudioTask, TaskQueue, TaskStatus
from tactogram_studio.workspace.commands import command_line
from tactogram_studio.workspace.runs import RunSummary
from tactogram_studio.workspace.starter_data import StarterData

COLOURS = {
    "waiting": "grey-8",
    "running": "primary",
    "stopping": "warning",
    "stopped": "warning",
    "unfinished": "warning",
    "finished": "positive",
    "failed": "negative",
}
READINGS = 40
"""Readings of a task's progress from which its speed is computed."""
ACTIVITIES = {"evaluate": "Evaluating", "simulate": "Simulating", "import": "Importing"}


def badge(state: str) -> None:
    """Draw a state."""
    shown = ui.badge(state, color=COLOURS[state], outline=state == "finished").classes(
        "text-sm q-px-sm q-py-xs"
    )
    shown.props["data-state"] = state


def state_of(summary: RunSummary | None, status: TaskStatus | None) -> str:
    """Return the state of a run: of its active task, else according to its folder."""
    if status is not None and status.active:
        return status.state
    if summary is not None and summary.finished:
        return "finished"
    if summary is not None and summary.training:
        return "running"
    return status.state if status is not None else "unfinished"


class TaskStart:
    """Equivalent command, refusals and button of a form that starts a task with a new output folder.

    ``arguments`` and ``output`` return what the form says, or raise; ``prepare`` is called before the start.
    """

    def __init__(
        self,
        queue: TaskQueue,
        kind: Kind,
        label: str,
        *,
        arguments: Callable[[], list[str]],
        output: Callable[[], str],
        prepare: Callable[[], None] = lambda: None,
    ) -> None:
        self._queue, self._kind, self._arguments, self._output = queue, kind, arguments, output
        self._prepare = prepare
        self.task: StudioTask | None = None
        self._command = code()
        self._refusal = alert()
        self.row = ui.row().classes("items-center gap-3")
        with self.row:
            ui.button(label, on_click=self._begin)
        self.show()
        ui.timer(1.0, self.show)

    def show(self) -> None:
        """Show the command that the form stands for, if it is complete."""
        try:
            self._command.text = command_line(self._arguments())
        except (TactogramError, ValueError):
            self._command.text = ""

    async def _begin(self) -> None:
        with refusals(self._refusal):
            arguments, output = self._arguments(), self._queue.new_output(self._output())
            self._prepare()
            self.task = await in_background(self._queue.begin_new, self._kind, arguments, output)
            ui.notify("Started. It continues if you close this tab.")


class ProgressRow:
    """A task's progress bar, and a text with its speed and remaining time."""

    def __init__(self, queue: TaskQueue, *, label: str = "Progress") -> None:
        self._queue = queue
        self._bar = ui.linear_progress(value=0.0, show_value=False, size="6px")
        self._bar.props["aria-label"] = label
        self._text = ui.label().classes("small")

    def update(self, task: StudioTask, status: TaskStatus) -> None:
        """Show the present progress."""
        self._bar.value = status.progress.share if status.progress else 0.0
        self._text.text = self._describe(task, status)

    def _describe(self, task: StudioTask, status: TaskStatus) -> str:
        if status.state == "waiting":
            return f"waiting: at most {self._queue.max_running} tasks run at once"
        progress = status.progress
        if progress is None:
            return "starting"
        readings = self._queue.readings.setdefault(task.id, deque(maxlen=READINGS))
        if not readings or readings[-1][1] != progress:
            readings.append((time.monotonic(), progress))
        text = f"{progress.name}: {progress.done:,} of {progress.total:,}"
        left = time_left(progress, readings)
        if left is not None and progress.done < progress.total:
            text += f" · {left[0]:.3g} per second · {duration_text(left[1])} left"
        return text


class TaskCards:
    """Cards of the unfinished tasks of some kinds; progress is updated in place, so buttons stay where they are."""

    def __init__(self, queue: TaskQueue, kinds: Sequence[str], *, title: str = "") -> None:
        self._queue, self._kinds, self._title = queue, kinds, title
        self._tasks: list[tuple[StudioTask, TaskStatus]] = []
        self._rows: dict[str, ProgressRow] = {}

    def unfinished(self, tasks: Sequence[StudioTask]) -> list[tuple[StudioTask, TaskStatus]]:
        """Return the tasks to show with their status; reads files."""
        shown = [(task, self._queue.status(task)) for task in tasks if task.kind in self._kinds]
        return [(task, status) for task, status in shown if status.state != "finished"]

    def update(self, tasks: list[tuple[StudioTask, TaskStatus]]) -> None:
        """Show other tasks, or their progress."""
        drawn, self._tasks = self._tasks, tasks
        if _states(drawn) != _states(tasks):
            self.draw.refresh()
        for task, status in tasks:
            if task.id in self._rows:
                self._rows[task.id].update(task, status)

    def follow(self, every_s: float = 1.0) -> None:
        """Draw the cards, and keep them up to date."""

        async def update() -> None:
            self.update(await in_background(lambda: self.unfinished(self._queue.all())))

        self.draw()
        ui.timer(every_s, update)

    @ui.refreshable_method
    def draw(self) -> None:
        """Draw the cards."""
        self._rows.clear()
        if self._tasks and self._title:
            heading(self._title)
        for task, status in self._tasks:
            with card(live=True):
                self._draw_card(task, status)

    def _draw_card(self, task: StudioTask, status: TaskStatus) -> None:
        def stop() -> None:
            self._queue.stop(task.id, at_once=task.kind != "evaluate")

        with ui.row().classes("items-center w-full gap-2"):
            ui.label(f"{ACTIVITIES[task.kind]} {task.about}")
            badge(status.state)
            ui.space()
            if status.active:
                ui.button("Stop", on_click=stop).props("outline dense")
            else:
                dismiss = ui.button("Dismiss", on_click=lambda: self._queue.forget(task.id))
                dismiss.props("flat dense")
        if status.active:
            self._rows[task.id] = ProgressRow(self._queue)
            self._rows[task.id].update(task, status)
        elif status.message:
            ui.label(status.message).classes("small text-negative")


def _states(tasks: Sequence[tuple[StudioTask, TaskStatus]]) -> list[tuple[str, str, str]]:
    return [(task.id, status.state, status.message) for task, status in tasks]


def draw_progress(starter: StarterData, *, ready: Callable[[], object]) -> None:
    """Draw the progress of the example surfaces until they are ready, and call ``ready`` then."""

    @ui.refreshable
    def state() -> None:
        with card(live=True):
            if starter.state == "ready":
                heading("Nine simulated surfaces are ready to explore.")
                with ui.row():
                    ui.button("Generate signals", on_click=lambda: ui.navigate.to("/make"))
                    ui.button("Touch them", on_click=lambda: ui.navigate.to("/touch")).props("outline")
            elif starter.state == "failed":
                ui.label(f"{starter.line}.").classes("text-negative")
                ui.button("Try again", on_click=starter.make)
            else:
                with ui.row().classes("items-center"):
                    ui.spinner()
                    ui.label(f"Preparing example surfaces (simulated): {starter.line}")

    state()
    drawn = [starter.state, starter.line]

    def update() -> None:
        now = [starter.state, starter.line]
        if now != drawn:
            drawn[:] = now
            state.refresh()
            if starter.state == "ready":
                ready()

    ui.timer(0.5, update)
