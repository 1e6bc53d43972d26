"""The page Train: start a training, and follow all runs and tasks."""

from __future__ import annotations

from dataclasses import dataclass
from urllib.parse import quote

from nicegui import ui

from tactogram_studio import kit
from tactogram_studio.context import Studio
from tactogram_studio.kit.tasks import ACTIVITIES, ProgressRow, TaskCards, badge
from tactogram_studio.pages.train import compare, form, watch
from tactogram_studio.pages.train.watch import state_of
from tactogram_studio.tasks.queue import StudioTask, TaskStatus, trainings_of
from tactogram_studio.workspace.runs import RunSummary, run_summary


def add(studio: Studio) -> None:
    """Register ``/train`` and the pages below it."""
    trainings_of(studio.workspace).keep_advancing()
    watch.add(studio)
    compare.add(studio)

    @kit.route("/train")
    async def show(model: str = "", data: str = "") -> None:
        with kit.page("Train"), ui.element("div").classes("grid-2"):
            with kit.card("Start a training"):
                form.draw(studio, model=model, data=data)
            with kit.column():
                await _RunList(studio).draw()


@dataclass(frozen=True)
class _RunEntry:
    """A run (``summary``), the training that produces it (``task``, ``status``), or both."""

    name: str
    summary: RunSummary | None
    task: StudioTask | None
    status: TaskStatus | None

    @property
    def state(self) -> str:
        return state_of(self.summary, self.status)

    @property
    def active(self) -> bool:
        return self.status is not None and self.status.active


class _RunList:
    """Runs and other tasks, redrawn when a state changes; progress is updated in place."""

    def __init__(self, studio: Studio) -> None:
        self.studio, self.trainings = studio, trainings_of(studio.workspace)
        self.entries: list[_RunEntry] = []
        self.selected: set[str] = set()
        self.rows: dict[str, ProgressRow] = {}
        self.cards = TaskCards(self.trainings, tuple(ACTIVITIES), title="Other tasks")

    async def draw(self) -> None:
        await self._update(first=True)
        with kit.card(), kit.column(gap=2):
            self._runs()
        with kit.column(gap=2):
            self.cards.draw()
        ui.timer(1.5, self._update)

    async def _update(self, *, first: bool = False) -> None:
        drawn = self.entries
        self.entries, others = await kit.in_background(self._gather)
        if not first and [(e.name, e.state) for e in drawn] != [(e.name, e.state) for e in self.entries]:
            self._runs.refresh()
        self.cards.update(others)
        for entry in self.entries:
            if entry.name in self.rows and entry.task and entry.status:
                self.rows[entry.name].update(entry.task, entry.status)

    def _gather(self) -> tuple[list[_RunEntry], list[tuple[StudioTask, TaskStatus]]]:
        """Return the runs, active ones first, then newest first; and the other unfinished tasks."""
        workspace, trainings = self.studio.workspace, self.trainings
        tasks = trainings.all()
        latest: dict[str, StudioTask] = {}
        for task in tasks:
            if task.kind == "train":
                latest.setdefault(task.about, task)
        runs = {workspace.name_of(run): run for run in workspace.runs()}
        entries = []
        for name in [*(name for name in latest if name not in runs), *runs]:
            summary, training = run_summary(runs[name]) if name in runs else None, latest.get(name)
            entries.append(
                _RunEntry(name, summary, training, trainings.status(training) if training else None)
            )
        entries.sort(key=lambda entry: not entry.active)
        return entries, self.cards.unfinished(tasks)

    @ui.refreshable_method
    def _runs(self) -> None:
        self.rows.clear()
        with ui.row().classes("items-center justify-between w-full"):
            kit.heading(f"Runs ({len(self.entries)})")
            self.compare_button = ui.button("Compare", on_click=self._compare).props("outline")
            self.compare_button.set_enabled(len(self.selected) > 1)
        if not self.entries:
            ui.label(
                "No runs yet. Start a training on this page; it continues when you close the tab or the server."
            ).classes("quiet")
        for entry in self.entries:
            with ui.element("div").classes("w-full") as row:
                row.style("border-top: 1px solid var(--line); padding-top: 0.5rem")
                self._draw_row(entry)

    def _compare(self) -> None:
        ui.navigate.to("/train/compare?" + "&".join(f"run={quote(name)}" for name in sorted(self.selected)))

    def _select(self, name: str, selected: bool) -> None:
        (self.selected.add if selected else self.selected.discard)(name)
        self.compare_button.set_enabled(len(self.selected) > 1)

    def _draw_row(self, entry: _RunEntry) -> None:
        name, summary, task = entry.name, entry.summary, entry.task
        with ui.row().classes("items-center gap-2 w-full no-wrap"):
            box = ui.checkbox(value=name in self.selected, on_change=lambda e: self._select(name, e.value))
            box.props(f'dense aria-label="Compare {name}"').set_enabled(summary is not None)
            ui.link(name, f"/train/watch?run={quote(name)}").style("overflow-wrap: anywhere")
            ui.space()
            kit.mark_simulated(summary is not None and summary.simulated, "simulated data")
            badge(entry.state)
        if summary is not None:
            text = f"{summary.model} on {summary.data.get('name', 'unknown data')}"
        else:
            text = task.command if task else ""
        ui.label(text).classes("quiet small").style("overflow-wrap: anywhere")
        if task is not None and entry.status is not None:
            if entry.status.message and entry.state == "failed":
                ui.label(entry.status.message).classes("small text-negative")
            if entry.active:
                self.rows[name] = ProgressRow(self.trainings)
                self.rows[name].update(task, entry.status)
