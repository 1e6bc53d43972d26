"""The page Train: begin a training, and see how all of them stand."""

from __future__ import annotations

from urllib.parse import quote

from nicegui import ui

from tactogram.studio.context import Studio
from tactogram.studio.layout import in_background, page, report_errors
from tactogram.studio.pages.train import compare, form, watch
from tactogram.studio.pages.train.run_facts import RunSummary, run_facts
from tactogram.studio.pages.train.trainings import StudioTask, TaskStatus, trainings_of
from tactogram.studio.pages.train.widgets import TrainContext, badge, seen_of, set_progress, state_of

ERRANDS = {"evaluate": "evaluating", "simulate": "simulating", "import": "importing"}


def add(studio: Studio) -> None:
    """Register ``/train`` and what belongs to it."""
    desk = TrainContext(studio, trainings_of(studio.workspace))
    desk.trainings.keep_advancing()
    watch.add(desk)
    compare.add(desk)

    @ui.page("/train")
    async def show(model: str = "", data: str = "") -> None:
        with page("Train"), ui.element("div").classes("grid-2"):
            with ui.element("section").classes("card").props('aria-label="Start a training"'):
                form.draw(desk, model=model, data=data)
            with ui.column().classes("w-full gap-4 items-stretch"):
                await _draw_runs(desk)


async def _draw_runs(desk: TrainContext) -> None:
    chosen: set[str] = set()
    moving: dict[str, tuple[ui.linear_progress, ui.label]] = {}
    held: list[tuple[str, RunSummary | None, StudioTask | None, TaskStatus | None]] = []
    errands: list[tuple[StudioTask, TaskStatus]] = []

    @ui.refreshable
    def runs() -> None:
        moving.clear()
        with ui.row().classes("items-center justify-between w-full"):
            ui.label(f"Runs ({len(held)})").classes("h2").props('role="heading" aria-level="2"')
            comparing = ui.button(
                "Compare", on_click=lambda: ui.navigate.to("/train/compare?" + _query(chosen))
            ).props("outline")
            comparing.set_enabled(len(chosen) > 1)
        if not held:
            ui.label(
                "None yet. Start one on this page; it goes on when the tab or the server is closed."
            ).classes("quiet")
        for name, facts, task, status in held:
            _row(name, facts, task, status, chosen, comparing, moving)

    @ui.refreshable
    def others() -> None:
        if errands:
            ui.label("Other errands").classes("h2").props('role="heading" aria-level="2"')
        for task, status in errands:
            _errand(desk, task, status, moving)

    async def look(*, first: bool = False) -> None:
        found, found_errands = await in_background(_gathered, desk)
        before = [(name, state_of(facts, status)) for name, facts, _, status in held]
        now = [(name, state_of(facts, status)) for name, facts, _, status in found]
        said = [(errand.id, how.state, how.line) for errand, how in errands]
        says = [(errand.id, how.state, how.line) for errand, how in found_errands]
        held[:], errands[:] = found, found_errands
        if not first and before != now:
            runs.refresh()
        if not first and said != says:
            others.refresh()
        for _, _, task, status in held:
            _move(desk, task, status, moving)
        for errand, how in errands:
            _move(desk, errand, how, moving)

    await look(first=True)
    with ui.element("section").classes("card w-full"), ui.column().classes("w-full gap-2 items-stretch"):
        runs()
    with ui.column().classes("w-full gap-2 items-stretch"):
        others()
    await look()
    ui.timer(1.5, report_errors(look))


def _gathered(
    desk: TrainContext,
) -> tuple[
    list[tuple[str, RunSummary | None, StudioTask | None, TaskStatus | None]],
    list[tuple[StudioTask, TaskStatus]],
]:
    """Return runs, newest first, with the training that made each, and the other errands."""
    tasks = desk.trainings.all()
    latest: dict[str, StudioTask] = {}
    for task in tasks:
        if task.kind == "train":
            latest.setdefault(task.about, task)
    runs = {desk.studio.workspace.name_of(run): run for run in desk.studio.workspace.runs()}
    names = [name for name in latest if name not in runs] + list(runs)
    found: list[tuple[str, RunSummary | None, StudioTask | None, TaskStatus | None]] = []
    for name in names:
        made = latest.get(name)
        facts = run_facts(runs[name]) if name in runs else None
        found.append((name, facts, made, desk.trainings.status(made) if made else None))
    found.sort(key=lambda each: not (each[3] is not None and each[3].active))
    shown = [(task, desk.trainings.status(task)) for task in tasks if task.kind != "train"]
    return found, [(task, status) for task, status in shown if status.state != "finished"]


def _row(
    name: str,
    facts: RunSummary | None,
    task: StudioTask | None,
    status: TaskStatus | None,
    chosen: set[str],
    comparing: ui.button,
    moving: dict[str, tuple[ui.linear_progress, ui.label]],
) -> None:
    def choose(on: bool) -> None:
        (chosen.add if on else chosen.discard)(name)
        comparing.set_enabled(len(chosen) > 1)

    with ui.element("div").classes("w-full").style("border-top: 1px solid var(--line); padding-top: 0.5rem"):
        with ui.row().classes("items-center gap-2 w-full no-wrap"):
            ui.checkbox(value=name in chosen, on_change=lambda e: choose(e.value)).props(
                f'dense aria-label="Compare {name}"'
            ).set_enabled(facts is not None)
            ui.link(name, f"/train/watch?run={quote(name)}").style("overflow-wrap: anywhere")
            ui.space()
            if facts is not None and facts.simulated:
                ui.label("simulated data").classes("simulated")
            badge(state_of(facts, status))
        told = (
            f"{facts.model} on {facts.data.get('name', 'unknown data')}"
            if facts
            else (task.command if task else "")
        )
        ui.label(told).classes("quiet small").style("overflow-wrap: anywhere")
        if status is not None and status.line and state_of(facts, status) == "failed":
            ui.label(status.line).classes("small text-negative")
        if task is not None and status is not None and status.active:
            moving[task.id] = (_bar(), ui.label().classes("small"))


def _errand(
    desk: TrainContext,
    task: StudioTask,
    status: TaskStatus,
    moving: dict[str, tuple[ui.linear_progress, ui.label]],
) -> None:
    with ui.element("section").classes("card w-full"):
        with ui.row().classes("items-center gap-2 w-full"):
            ui.label(f"{ERRANDS[task.kind]} {task.about}")
            ui.space()
            badge(status.state)
        if status.line and not status.active:
            ui.label(status.line).classes("small text-negative")
        if status.active:
            moving[task.id] = (_bar(), ui.label().classes("small"))
            ui.button("Stop", on_click=report_errors(lambda: desk.trainings.stop(task.id))).props(
                "outline dense"
            )
        else:
            ui.button("Dismiss", on_click=report_errors(lambda: desk.trainings.forget(task.id))).props(
                "flat dense"
            )


def _bar() -> ui.linear_progress:
    return ui.linear_progress(value=0.0, show_value=False, size="6px").props('aria-label="Progress"')


def _move(
    desk: TrainContext,
    task: StudioTask | None,
    status: TaskStatus | None,
    moving: dict[str, tuple[ui.linear_progress, ui.label]],
) -> None:
    if task is not None and status is not None and task.id in moving:
        seen_of(desk, task, status)
        set_progress(desk, task, status, *moving[task.id])


def _query(names: set[str]) -> str:
    return "&".join(f"run={quote(name)}" for name in sorted(names))
