"""The page Train: start a training, follow all runs and tasks, and compare runs."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Annotated, Any
from urllib.parse import quote

from fastapi import Query
from nicegui import ui

from tactogram.errors import ParameterError
from tactogram_studio import kit
from tactogram_studio.context import Studio
from tactogram_studio.kit.tasks import ACTIVITIES, ProgressRow, TaskCards, badge, state_of
from tactogram_studio.pages.train import form, watch
from tactogram_studio.tasks.log import loss_curves, read_metrics, thinned
from tactogram_studio.tasks.queue import StudioTask, TaskStatus, trainings_of
from tactogram_studio.workspace.runs import RunSummary, run_summary

MOST_RUNS = 8
Curves = dict[str, list[tuple[int, float]]]


def add(studio: Studio) -> None:
    """Register ``/train`` and the pages below it."""
    trainings_of(studio.workspace).keep_advancing()
    watch.add(studio)

    @kit.route("/train")
    async def show(purpose: str = "", model: str = "", data: str = "", key: str = "") -> None:
        with kit.page("Train"), ui.element("div").classes("grid-2"):
            with kit.card("Train a model"):
                form.draw(studio, purpose=purpose, model=model, data=data, key=key)
            with kit.column():
                await _RunList(studio).draw()

    @kit.route("/train/compare")
    async def compare(run: Annotated[list[str], Query()] = []) -> None:  # noqa: B006 - read only
        with kit.page("Train"):
            ui.link("All runs", "/train").classes("small")
            curves, compared = await kit.in_background(_read, studio, run)
            kit.heading("Comparison of runs")
            with ui.row():
                for name in curves:
                    ui.link(name, f"/train/watch?run={quote(name)}")
            _draw_losses(curves)
            _draw_table("Results", "Measure", compared["results"], list(curves))
            _draw_table("Models and data", "Fact", compared["facts"], list(curves))
            _draw_table("Different settings", "Setting", compared["settings"], list(curves))
            for note in compared["notes"]:
                kit.hint(f"{note[:1].upper()}{note[1:]}.")


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
            box.props(f'dense aria-label="Compare {kit.attribute(name)}"').set_enabled(summary is not None)
            ui.link(name, f"/train/watch?run={quote(name)}").style("overflow-wrap: anywhere")
            ui.space()
            badge(entry.state)
        if summary is not None:
            text = f"{summary.model}, trained on {summary.data_name}"
        else:
            text = task.command if task else ""
        with ui.row().classes("items-center gap-2"):
            ui.label(text).classes("quiet small").style("overflow-wrap: anywhere")
            kit.mark_simulated(summary is not None and summary.simulated, "simulated data")
        if task is not None and entry.status is not None:
            if entry.status.message and entry.state == "failed":
                ui.label(entry.status.message).classes("small text-negative")
            if entry.active:
                self.rows[name] = ProgressRow(self.trainings)
                self.rows[name].update(task, entry.status)


def _read(studio: Studio, names: Sequence[str]) -> tuple[dict[str, Curves], dict[str, Any]]:
    from tactogram.workflows import compare_runs  # brings torch

    workspace = studio.workspace
    folders = [workspace.inside(name) for name in dict.fromkeys(names)][:MOST_RUNS]
    for name, folder in zip(dict.fromkeys(names), folders, strict=False):
        if not (folder / "recipe.toml").is_file():
            raise ParameterError(f"{name[:200]}: no such run in this workspace; it may have been deleted")
    if len(folders) < 2:
        raise ParameterError("select at least two runs on the page Train")
    curves = {workspace.name_of(folder): loss_curves(read_metrics(folder)) for folder in folders}
    return curves, compare_runs(folders)


def _draw_losses(curves_by_run: Mapping[str, Curves]) -> None:
    names = list(dict.fromkeys(loss for curves in curves_by_run.values() for loss in curves))
    with kit.card():
        if not names:
            ui.label(
                "None of these runs has loss curves: their models are computed from the recordings."
            ).classes("quiet")
            return
        chart = ui.echart(kit.line_chart(loss_by_run(curves_by_run, names[0]), x="step")).classes("w-full")
        chart.style("height: 22rem").props('role="img" aria-label="Losses of the runs over steps"')

        def draw() -> None:
            chart.options.clear()
            shown = loss_by_run(curves_by_run, loss.value)
            chart.options.update(kit.line_chart(shown, x="step", log_scale=log_scale.value))
            chart.update()

        with ui.row().classes("items-center"):
            loss = ui.select(names, label="Loss", value=names[0], on_change=draw).classes("w-64")
            log_scale = ui.switch("logarithmic", on_change=draw)


def loss_by_run(curves_by_run: Mapping[str, Curves], loss: str) -> Curves:
    """Return one loss of each run that has it, by run."""
    return {run: thinned(curves[loss]) for run, curves in curves_by_run.items() if loss in curves}


def _draw_table(title: str, key: str, rows: Mapping[str, Sequence[Any]], runs: Sequence[str]) -> None:
    with kit.card(title):
        if not rows:
            ui.label("None.").classes("quiet")
            return
        kit.table([key, *runs], [[name, *map(_text, values)] for name, values in rows.items()])


def _text(value: Any) -> str:
    if isinstance(value, float):
        return f"{value:.4g}"
    if isinstance(value, bool):
        return "yes" if value else "no"
    return "–" if value is None else str(value)
