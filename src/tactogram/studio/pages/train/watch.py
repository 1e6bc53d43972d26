"""One run: its losses while it trains, what it makes so far, and what can be done with it."""

from __future__ import annotations

from functools import partial
from pathlib import Path
from typing import Any
from urllib.parse import quote

from nicegui import ui
from PIL import Image as Pillow

from tactogram.errors import ParameterError
from tactogram.models import available
from tactogram.signal.io import read_image, read_image_metadata, read_metadata
from tactogram.studio.layout import busy, in_background, page, report_errors
from tactogram.studio.pages.train.log import checkpoint_step, curves, metrics, thinned
from tactogram.studio.pages.train.run_facts import run_facts
from tactogram.studio.pages.train.trainings import StudioTask, TaskStatus
from tactogram.studio.pages.train.widgets import (
    TrainContext,
    badge,
    loss_options,
    seen_of,
    set_progress,
    state_of,
)
from tactogram.studio.signals.view import add_routes, signal_card

SHOWN_SAMPLES = 6


def add(desk: TrainContext) -> None:
    """Register ``/train/watch``."""
    add_routes()

    @ui.page("/train/watch")
    async def show(run: str = "") -> None:
        with page("Train"):
            ui.link("All runs", "/train").classes("small")
            try:
                view = _RunView(desk, run)
            except ParameterError as error:
                ui.label(str(error)).props('role="alert"')
                return
            await view.draw()


class _RunView:
    """A run on a page, drawn anew where its state changes and moved on where it does not."""

    def __init__(self, desk: TrainContext, name: str) -> None:
        folder = desk.studio.workspace.inside(name)
        self.desk, self.folder = desk, folder
        self.name = desk.studio.workspace.name_of(folder)
        tasks = desk.trainings.of(self.name)
        if not (folder / "recipe.toml").is_file() and not tasks:
            raise ParameterError(f"{name[:200]}: no run of this workspace; it was deleted, or never there")
        self.task: StudioTask | None = None
        self.status: TaskStatus | None = None
        self.evaluating: tuple[StudioTask, TaskStatus] | None = None
        self.facts = run_facts(folder)
        self.position: dict[str, int] | None = None
        self.gone = False
        self.drawn: Any = None
        self.found: dict[str, list[tuple[int, float]]] = {}
        self.read_bytes = -1
        self.charted = False
        self.checkpoint: ui.label | None = None
        self.offered: list[str] = []
        self.of: str | None = None
        self.moving: tuple[ui.linear_progress, ui.label] | None = None
        self.judging: tuple[ui.linear_progress, ui.label] | None = None

    async def draw(self) -> None:
        await self._look()
        self.head()
        with ui.element("section").classes("card w-full").props('aria-label="Losses"'):
            ui.label("Losses").classes("h2").props('role="heading" aria-level="2"')
            self.no_curve = ui.label("No losses yet.").classes("quiet")
            self.chart = ui.echart(loss_options({})).classes("w-full").style("height: 20rem")
            self.chart.props('role="img" aria-label="Losses over steps"')
            self.log_scale = ui.switch("logarithmic", on_change=lambda: self._curves(anew=True)).props(
                "dense"
            )
        self.made()
        self.more()
        self._curves(anew=True)
        self.drawn = self._signature()
        ui.timer(1.0, report_errors(self._tick))

    # -- what it looks at ----------------------------------------------------------------------------------

    async def _look(self) -> None:
        await in_background(self._gather)
        if self.task and self.status:
            seen_of(self.desk, self.task, self.status)

    def _gather(self) -> None:
        """Read what is on the disk: a long training's losses are many lines."""
        trainings = self.desk.trainings
        self.facts, self.position = run_facts(self.folder), checkpoint_step(self.folder)
        tasks = trainings.of(self.name)
        self.task = next((task for task in tasks if task.kind == "train"), None)
        self.status = trainings.status(self.task) if self.task else None
        self.gone = not tasks and not (self.folder / "recipe.toml").is_file()
        evaluating = next((task for task in tasks if task.kind == "evaluate"), None)
        self.evaluating = (evaluating, trainings.status(evaluating)) if evaluating else None
        file = self.folder / "metrics.jsonl"
        size = file.stat().st_size if file.is_file() else 0
        if size != self.read_bytes:
            self.read_bytes, self.charted = size, False
            self.found = {name: thinned(points) for name, points in curves(metrics(self.folder)).items()}

    def _signature(self) -> Any:
        return (
            self.gone,
            self.state,
            self.facts.finished,
            bool(self.facts.data),
            self.position is not None,
            self.facts.has_report,
            dict(self.facts.evaluation),
            self.evaluating and (self.evaluating[1].state, self.evaluating[1].line),
            self.position if self.state != "running" else None,
        )

    @property
    def state(self) -> str:
        return state_of(self.facts, self.status)

    @property
    def elsewhere(self) -> bool:
        """Whether a process that no studio began trains it."""
        return self.state == "running" and not (self.status is not None and self.status.active)

    async def _tick(self) -> None:
        await self._look()
        if self._signature() != self.drawn:
            self.drawn = self._signature()
            self.head.refresh()
            self.made.refresh()
            self.more.refresh()
        if self.task and self.status and self.status.active and self.moving:
            set_progress(self.desk, self.task, self.status, *self.moving)
        if self.checkpoint is not None:
            self.checkpoint.text = self._checkpoint_text()
        if self.evaluating and self.evaluating[1].active and self.judging:
            set_progress(self.desk, *self.evaluating, *self.judging)
        self._curves()

    # -- what it shows -------------------------------------------------------------------------------------

    @ui.refreshable_method
    def head(self) -> None:
        self.moving = None
        if self.gone:
            ui.label(f"{self.name} was deleted meanwhile.").props('role="alert"')
            return
        data = self.facts.data
        with ui.element("section").classes("card w-full").props('aria-live="polite"'):
            with ui.row().classes("items-center gap-3 w-full"):
                ui.label(self.name).classes("h2").props('role="heading" aria-level="2"').style(
                    "overflow-wrap: anywhere"
                )
                badge(self.state)
                if self.facts.simulated:
                    ui.label("simulated data").classes("simulated")
            if data:
                split = data.get("split", {})
                parts = ", ".join(
                    f"{split[part]} to {part}" for part in ("train", "validation", "test") if part in split
                )
                ui.label(
                    f"{self.facts.model} on {data.get('name')} · by {split.get('by', '?')}: {parts}"
                ).classes("quiet")
            if self.task is not None and self.status is not None and self.status.active:
                bar = ui.linear_progress(value=0.0, show_value=False, size="8px").props(
                    'aria-label="Progress"'
                )
                self.moving = (bar, ui.label())
                set_progress(self.desk, self.task, self.status, *self.moving)
            elif self.status is not None and self.status.line and self.state in ("failed", "stopped"):
                ui.label(self.status.line).classes("text-negative" if self.state == "failed" else "")
            elif self.elsewhere:
                ui.label(
                    "A process that was begun elsewhere, as at the command line, trains it: stop it there."
                )
            elif self.state == "unfinished":
                ui.label("Begun elsewhere, as at the command line, and not finished.")
            with ui.element("div").classes("q-mt-sm"):
                self._buttons()
            if self.task is not None:
                ui.separator().classes("q-my-sm")
                ui.label("Equal command").classes("small quiet")
                ui.element("code").classes("small").style(
                    "overflow-wrap: anywhere; display: block"
                )._text = self.task.command

    def _buttons(self) -> None:
        with ui.row().classes("gap-2"):
            if self.status is not None and self.status.active:
                ui.button("Stop", on_click=report_errors(self._stop)).props("outline").set_enabled(
                    self.state != "stopping"
                )
                if self.state == "stopping":
                    ui.button("Stop at once", on_click=report_errors(self._kill)).props(
                        "outline color=negative"
                    )
                return
            if self.elsewhere:
                return
            if self.state in ("stopped", "failed", "unfinished"):
                ui.button("Go on", on_click=report_errors(self._resume))
            if self.facts.finished:
                facts = available().get(self.facts.model)
                if facts is not None and facts.task == "generation":
                    ui.button(
                        "Open in Make", on_click=lambda: ui.navigate.to(f"/make?run={quote(self.name)}")
                    )
                judging = self.evaluating is not None and self.evaluating[1].active
                ui.button("Evaluate", on_click=report_errors(self._evaluate)).props("outline").set_enabled(
                    not judging
                )
            ui.button("Delete", on_click=report_errors(self._ask_delete)).props("flat color=negative")

    @ui.refreshable_method
    def made(self) -> None:
        self.checkpoint = None
        facts = available().get(self.facts.model)
        if facts is None or facts.task != "generation" or not (self.facts.finished or self.position):
            return
        with ui.element("section").classes("card w-full").props('aria-label="Samples"'):
            ui.label("Samples").classes("h2").props('role="heading" aria-level="2"')
            self.checkpoint = ui.label(self._checkpoint_text()).classes("quiet small")
            with ui.row().classes("items-center"):
                button = ui.button("Make a sample").props("outline")
                of = ui.select(self.offered, label="of", value=self.of).props("dense options-dense")
                of.classes("w-64").bind_value(self, "of")
                button.on_click(report_errors(lambda: self._sample(button)))
            self._samples()
        if not self.offered:
            ui.timer(0.05, report_errors(partial(self._offer, of)), once=True)

    async def _offer(self, of: ui.select) -> None:
        """Offer what a sample can be of, by name."""
        self.offered = await in_background(_offered, self.folder)
        if not of.is_deleted:
            of.set_options(self.offered, value=self.offered[0] if self.offered else None)

    def _checkpoint_text(self) -> str:
        at = self.position
        if self.facts.finished or at is None:
            return "What it makes; kept with the run."
        return f"What it makes so far; kept with the run. Its last checkpoint is of step {at['step']:,}."

    def _samples(self) -> None:
        folder = self.folder / "samples"
        files = (
            sorted(folder.glob("[!.]*"), key=lambda file: file.stat().st_mtime, reverse=True)
            if folder.is_dir()
            else []
        )
        for file in [file for file in files if file.suffix in (".wav", ".png")][:SHOWN_SAMPLES]:
            if file.suffix == ".png":
                known = read_image_metadata(file)
                picture = ui.image(Pillow.fromarray(read_image(file).pixels)).style("max-width: 16rem")
                picture.props(f'alt="{known.get("of", file.stem)}"')
                continue
            known = read_metadata(file)
            when = "at the end" if known.get("step") is None else f"at step {known['step']}"
            title = f"{known.get('of', file.stem)} {when}"
            signal_card(file, title=title, simulated=bool(known.get("simulated")), small=True)

    @ui.refreshable_method
    def more(self) -> None:
        self.judging = None
        if self.evaluating is not None and self.evaluating[1].state in (
            "waiting",
            "running",
            "stopping",
            "failed",
        ):
            task, status = self.evaluating
            with ui.element("section").classes("card w-full").props('aria-live="polite"'):
                ui.label("Evaluation").classes("h2")
                badge(status.state)
                if status.active:
                    bar = ui.linear_progress(value=0.0, show_value=False, size="8px").props(
                        'aria-label="Progress of the evaluation"'
                    )
                    self.judging = (bar, ui.label())
                    set_progress(self.desk, task, status, *self.judging)
                    ui.button(
                        "Stop", on_click=report_errors(lambda: self.desk.trainings.stop(task.id))
                    ).props("outline dense")
                else:
                    ui.label(status.line).classes("text-negative")
        if self.facts.validation or self.facts.evaluation:
            with ui.element("section").classes("card w-full").props('aria-label="Figures"'):
                ui.label("Figures").classes("h2").props('role="heading" aria-level="2"')
                rows = [
                    ("on the validation part", name, value) for name, value in self.facts.validation.items()
                ]
                rows += [("evaluation", name, value) for name, value in self.facts.evaluation.items()]
                figures_table(rows)
                if self.facts.has_report:
                    ui.link("Read the report", f"/reports?of={quote(self.name)}/report.html")
        if self.task is not None and self.status is not None:
            with ui.expansion("What the process said").classes("w-full card"):
                text = self.desk.trainings.log(self.task)[-4000:] or "nothing yet"
                ui.element("pre").classes("small").style(
                    "white-space: pre-wrap; overflow-wrap: anywhere"
                )._text = text

    def _curves(self, *, anew: bool = False) -> None:
        if self.charted and not anew:
            return
        self.charted, found = True, self.found
        self.no_curve.visible = not found
        self.chart.visible = self.log_scale.visible = bool(found)
        if not found and self.facts.finished:
            self.no_curve.text = "It is fitted in one step: there are no curves."
        self.chart.options.clear()
        self.chart.options.update(loss_options(found, log_scale=bool(self.log_scale.value)))
        self.chart.update()

    # -- what it does --------------------------------------------------------------------------------------

    def _stop(self) -> None:
        if self.task is not None:
            self.desk.trainings.stop(self.task.id)
            ui.notify("It ends after the step it is at, and keeps all of it.")

    def _kill(self) -> None:
        if self.task is not None:
            self.desk.trainings.stop(self.task.id, at_once=True)

    async def _resume(self) -> None:
        task = await in_background(self.desk.trainings.resume_run, self.folder)
        self.desk.seen.pop(task.id, None)

    async def _evaluate(self) -> None:
        await in_background(self.desk.trainings.begin, "evaluate", ["evaluate", self.name], self.name)

    async def _sample(self, button: ui.button) -> None:
        with busy("making a sample", button=button):
            await in_background(_sample, self.folder, self.of)
        self.made.refresh()

    async def _ask_delete(self) -> None:
        with ui.dialog().props('aria-label="Delete this run?"') as dialog, ui.card():
            ui.label(f"Delete {self.name} with its weights, samples and report? This cannot be undone.")
            with ui.row():
                ui.button("Delete it", color="negative", on_click=lambda: dialog.submit(True))
                ui.button("Keep it", on_click=lambda: dialog.submit(False)).props("outline autofocus")
        if await dialog:
            await in_background(self._delete)
            ui.navigate.to("/train")

    def _delete(self) -> None:
        if self.folder.is_dir():
            self.desk.trainings.delete_run(self.folder)
            return
        for task in self.desk.trainings.of(self.name):  # a training that never began has no folder
            self.desk.trainings.forget(task.id)


def _offered(run: Path) -> list[str]:
    from tactogram.workflows.generation.preview import sample_choices  # brings torch

    return sample_choices(run)


def _sample(run: Path, of: str | None) -> None:
    from tactogram.workflows.generation.preview import sample  # brings torch

    sample(run, of=of)


def figures_table(rows: list[tuple[str, str, float]]) -> None:
    """Draw figures as a table: of what, name, value."""
    columns = [
        {"name": name, "label": label, "field": name, "align": "right" if name == "value" else "left"}
        for name, label in (("of", "of"), ("figure", "figure"), ("value", "value"))
    ]
    table = [{"of": of, "figure": name, "value": f"{value:.4g}"} for of, name, value in rows]
    ui.table(columns=columns, rows=table, row_key="figure").props("flat dense").classes("w-full")
