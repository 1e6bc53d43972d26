"""Page of one run: progress, losses, samples, results, and its buttons."""

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
from tactogram_studio import kit
from tactogram_studio.context import Studio
from tactogram_studio.kit.tasks import ProgressRow, TaskCards, badge, state_of
from tactogram_studio.signals.view import SignalEntry, add_routes, signal_cards
from tactogram_studio.tasks.log import checkpoint_position, loss_curves, read_metrics, thinned
from tactogram_studio.tasks.queue import StudioTask, TaskStatus, trainings_of
from tactogram_studio.workspace.runs import run_summary

SHOWN_SAMPLES = 6


def add(studio: Studio) -> None:
    """Register ``/train/watch``."""
    add_routes()

    @kit.route("/train/watch")
    async def show(run: str = "") -> None:
        with kit.page("Train"):
            ui.link("All runs", "/train").classes("small")
            await _RunView(studio, run).draw()


class _RunView:
    """A run; sections are redrawn when its state changes, and updated in place otherwise."""

    def __init__(self, studio: Studio, name: str) -> None:
        self.folder = folder = studio.workspace.inside(name)
        self.name, self.trainings = studio.workspace.name_of(folder), trainings_of(studio.workspace)
        tasks = self.trainings.of(self.name)
        if not (folder / "recipe.toml").is_file() and not tasks:
            raise ParameterError(f"{name[:200]}: no such run in this workspace; it may have been deleted")
        self.task: StudioTask | None = None
        self.status: TaskStatus | None = None
        self.evaluations: list[tuple[StudioTask, TaskStatus]] = []
        self.cards = TaskCards(self.trainings, ("evaluate",))
        self.summary = run_summary(folder)
        self.position: dict[str, int] | None = None
        self.deleted = False
        self.drawn: Any = None
        self.curves: dict[str, list[tuple[int, float]]] = {}
        self.metrics_bytes = -1
        self.chart_current = False
        self.checkpoint: ui.label | None = None
        self.sample_choices: list[str] = []
        self.sample_of: str | None = None
        self.progress: ProgressRow | None = None

    async def draw(self) -> None:
        await kit.in_background(self._read)
        self.head()
        with kit.card("Losses"):
            self.no_curve = ui.label("No losses yet.").classes("quiet")
            self.chart = ui.echart(kit.line_chart({}, x="step")).classes("w-full").style("height: 20rem")
            self.chart.props('role="img" aria-label="Losses over steps"')
            self.log_scale = ui.switch("logarithmic", on_change=lambda: self._draw_curves(redraw=True))
            self.log_scale.props("dense")
        self.samples()
        self.cards.update(self.evaluations)
        self.cards.draw()
        self.results()
        self._draw_curves(redraw=True)
        self.drawn = self._signature()
        ui.timer(1.0, self._update)

    def _read(self) -> None:
        """Read the run folder and its tasks; slow for the many metrics of a long training."""
        self.summary, self.position = run_summary(self.folder), checkpoint_position(self.folder)
        tasks = self.trainings.of(self.name)
        self.task = next((task for task in tasks if task.kind == "train"), None)
        self.status = self.trainings.status(self.task) if self.task else None
        self.deleted = not tasks and not (self.folder / "recipe.toml").is_file()
        evaluating = [task for task in tasks if task.kind == "evaluate"]
        self.evaluations = self.cards.unfinished(evaluating[:1])
        file = self.folder / "metrics.jsonl"
        size = file.stat().st_size if file.is_file() else 0
        if size != self.metrics_bytes:
            self.metrics_bytes, self.chart_current = size, False
            curves = loss_curves(read_metrics(self.folder))
            self.curves = {name: thinned(points) for name, points in curves.items()}

    def _signature(self) -> Any:
        """Return everything whose change requires a redraw."""
        return (
            self.deleted,
            self.state,
            self.summary.finished,
            bool(self.summary.data),
            self.position is not None,
            self.summary.has_report,
            dict(self.summary.evaluation),
            any(status.active for _, status in self.evaluations),
            self.position if self.state != "running" else None,
        )

    @property
    def state(self) -> str:
        return state_of(self.summary, self.status)

    @property
    def active(self) -> bool:
        """Whether a task of this studio trains it or will."""
        return self.status is not None and self.status.active

    @property
    def trained_elsewhere(self) -> bool:
        return self.state == "running" and not self.active

    @property
    def generates(self) -> bool:
        model = available().get(self.summary.model)
        return model is not None and model.task == "generation"

    async def _update(self) -> None:
        await kit.in_background(self._read)
        if self._signature() != self.drawn:
            self.drawn = self._signature()
            self.head.refresh()
            self.samples.refresh()
            self.results.refresh()
        if self.task and self.status and self.active and self.progress:
            self.progress.update(self.task, self.status)
        if self.checkpoint is not None:
            self.checkpoint.text = self._checkpoint_text()
        self.cards.update(self.evaluations)
        self._draw_curves()

    @ui.refreshable_method
    def head(self) -> None:
        self.progress = None
        if self.deleted:
            kit.alert(f"{self.name} has been deleted.")
            return
        with kit.card(live=True):
            with kit.title_row(self.name, self.summary.simulated, "simulated data"):
                badge(self.state)
            if data := self.summary.data:
                split, names = data.get("split", {}), {"train": "training", "test": "testing"}
                listed = [part for part in ("train", "validation", "test") if part in split]
                parts = ", ".join(f"{split[part]} for {names.get(part, part)}" for part in listed)
                by = f"{self.summary.data_name}, split by {split.get('by', '?')}"
                ui.label(f"{self.summary.model}, trained on {by}: {parts}").classes("quiet")
            if self.task is not None and self.status is not None and self.active:
                self.progress = ProgressRow(self.trainings)
                self.progress.update(self.task, self.status)
            elif self.status is not None and self.status.message and self.state in ("failed", "stopped"):
                ui.label(self.status.message).classes("text-negative" if self.state == "failed" else "")
            elif self.trained_elsewhere:
                ui.label("A process started outside the studio is training this run: stop it there.")
            elif self.state == "unfinished":
                ui.label("Started outside the studio, and not finished.")
            with ui.row().classes("gap-2 q-mt-sm"):
                self._draw_buttons()
            if self.task is not None:
                ui.separator().classes("q-my-sm")
                kit.hint("Equivalent command")
                kit.code(self.task.command)

    def _draw_buttons(self) -> None:
        if self.active:
            stop = ui.button("Stop", on_click=partial(self._stop, at_once=False)).props("outline")
            stop.set_enabled(self.state != "stopping")
            if self.state == "stopping":
                now = ui.button("Stop now", on_click=partial(self._stop, at_once=True))
                now.props("outline color=negative")
            return
        if self.trained_elsewhere:
            return
        if self.state in ("stopped", "failed", "unfinished"):
            ui.button("Resume", on_click=self._resume)
        if self.summary.finished:
            for text, address in self._next_steps():
                ui.button(text, on_click=partial(ui.navigate.to, address))
            evaluate = ui.button("Evaluate", on_click=self._evaluate).props("outline")
            evaluate.set_enabled(not any(status.active for _, status in self.evaluations))
        ui.button("Delete", on_click=self._ask_delete).props("flat color=negative")

    def _next_steps(self) -> list[tuple[str, str]]:
        """Return what to do with a trained model: texts of buttons, and the addresses of their pages."""
        model, name = available().get(self.summary.model), quote(self.name)
        if model is not None and model.task == "classification":
            return [
                ("Classify a file", f"/materials/drop?by={name}"),
                ("Recognise live", f"/live?run={name}"),
            ]
        return [("Generate", f"/make?run={name}")] if self.generates else []

    @ui.refreshable_method
    def samples(self) -> None:
        self.checkpoint = None
        if not self.generates or not (self.summary.finished or self.position):
            return
        with kit.card("Samples"):
            self.checkpoint = kit.hint(self._checkpoint_text())
            with ui.row().classes("items-center"):
                button = ui.button("Generate sample").props("outline")
                choice = ui.select(self.sample_choices, label="Sample of", value=self.sample_of)
                choice.classes("w-64").bind_value(self, "sample_of")
                button.on_click(lambda: self._generate_sample(button))
            self._draw_samples()
        if not self.sample_choices:
            ui.timer(0.05, partial(self._load_sample_choices, choice), once=True)

    async def _load_sample_choices(self, choice: ui.select) -> None:
        self.sample_choices = await kit.in_background(_sample_choices, self.folder)
        if not choice.is_deleted:
            choice.set_options(self.sample_choices, value=next(iter(self.sample_choices), None))

    def _checkpoint_text(self) -> str:
        if self.summary.finished or self.position is None:
            return "Samples of the trained model, saved with the run."
        return f"Samples of the latest checkpoint (step {self.position['step']:,}), saved with the run."

    def _draw_samples(self) -> None:
        folder = self.folder / "samples"
        files = [file for file in folder.glob("[!.]*") if file.suffix in (".wav", ".png")]
        files.sort(key=lambda file: file.stat().st_mtime, reverse=True)
        signals = []
        for file in files[:SHOWN_SAMPLES]:
            if file.suffix == ".png":
                facts = read_image_metadata(file)
                picture = ui.image(Pillow.fromarray(read_image(file).pixels)).style("max-width: 16rem")
                picture.props["alt"] = str(facts.get("of", file.stem))
                continue
            facts = read_metadata(file)
            when = "after training" if facts.get("step") is None else f"at step {facts['step']}"
            title = f"{facts.get('of', file.stem)} {when}"
            signals.append(SignalEntry(file, title, bool(facts.get("simulated"))))
        if signals:
            signal_cards(signals, small=True)

    @ui.refreshable_method
    def results(self) -> None:
        summary = self.summary
        parts = {"validation part": summary.validation, "evaluation": summary.evaluation}
        rows = [
            [name.replace("_", " "), part, f"{value:.4g}"]
            for part, values in parts.items()
            for name, value in values.items()
        ]
        if rows:
            with kit.card("Results"):
                kit.table(["Measure", "Measured on", "Value"], rows)
                if summary.has_report:
                    ui.link("Read the report", f"/reports?of={quote(self.name)}/report.html")
        if self.task is not None and self.status is not None:
            with ui.expansion("Process log").classes("w-full card"):
                log = ui.element("pre").classes("small")
                log.style("white-space: pre-wrap; overflow-wrap: anywhere")
                log._text = self.trainings.log(self.task)[-4000:] or "empty"

    def _draw_curves(self, *, redraw: bool = False) -> None:
        if self.chart_current and not redraw:
            return
        self.chart_current, curves = True, self.curves
        self.no_curve.visible = not curves
        self.chart.visible = self.log_scale.visible = bool(curves)
        if not curves and self.summary.finished:
            self.no_curve.text = (
                "This model is computed from the recordings, without losses that fall step by step."
            )
        self.chart.options.clear()
        options = kit.line_chart(curves, x="step", log_scale=bool(self.log_scale.value))
        self.chart.options.update(options)
        self.chart.update()

    def _stop(self, *, at_once: bool) -> None:
        if self.task is not None:
            self.trainings.stop(self.task.id, at_once=at_once)
            if not at_once:
                ui.notify("Training stops after the current step; nothing is lost.")

    async def _resume(self) -> None:
        await kit.in_background(self.trainings.resume_run, self.folder)

    async def _evaluate(self) -> None:
        await kit.in_background(self.trainings.begin, "evaluate", ["evaluate", self.name], self.name)

    async def _generate_sample(self, button: ui.button) -> None:
        with kit.busy("Generating a sample", button=button):
            await kit.in_background(_sample, self.folder, self.sample_of)
        self.samples.refresh()

    async def _ask_delete(self) -> None:
        text = f"Delete {self.name} with its weights, samples and report? This cannot be undone."
        client = ui.context.client
        if await kit.confirm(text, "Delete run"):
            await kit.in_background(self._delete)
            with client:  # an update may have removed the button meanwhile, and its slot with it
                ui.navigate.to("/train")

    def _delete(self) -> None:
        if self.folder.is_dir():
            self.trainings.delete_run(self.folder)
            return
        for task in self.trainings.of(self.name):  # a training that never started has no folder
            self.trainings.forget(task.id)


def _sample_choices(folder: Path) -> list[str]:
    from tactogram_studio.tasks.run_samples import sample_choices  # brings torch

    return sample_choices(folder)


def _sample(folder: Path, of: str | None) -> None:
    from tactogram_studio.tasks.run_samples import sample  # brings torch

    sample(folder, of=of)
