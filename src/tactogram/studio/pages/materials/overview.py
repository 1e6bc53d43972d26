"""The data sets of the workspace as tiles, and what is being simulated or imported, looked at again now and then."""

from __future__ import annotations

from urllib.parse import quote

from nicegui import ui

from tactogram.datasets import Store
from tactogram.errors import TactogramError
from tactogram.studio.layout import in_background, report_errors
from tactogram.studio.pages.materials.media import MaterialsContext, address
from tactogram.studio.pages.train.trainings import StudioTask, TaskStatus
from tactogram.studio.pages.train.widgets import TrainContext, badge, set_progress

WORDS = {"simulate": "Simulating", "import": "Importing"}
AGAIN_S = 1.5


class DataSetsPage:
    """Both lists on one page.

    Parameters
    ----------
    desk : MaterialsDesk
    """

    def __init__(self, desk: MaterialsContext) -> None:
        self.desk = desk
        self._pace = TrainContext(desk.studio, desk.trainings)
        self._held: list[tuple[str, Store | str]] = []
        self._tasks: list[tuple[StudioTask, TaskStatus]] = []
        self._progress: dict[str, tuple[ui.linear_progress, ui.label]] = {}

    async def show(self) -> None:
        """Draw both, and go on looking."""
        self._held, self._tasks = await in_background(self._gathered)
        self._errands()
        self._set_progress()
        self._tiles()
        ui.timer(AGAIN_S, report_errors(self._look))

    async def _look(self) -> None:
        """Draw anew what has changed; progress moves on in place, so that a button is never taken from a finger."""
        sets, tasks = await in_background(self._gathered)
        others = [name for name, _ in sets] != [name for name, _ in self._held]
        said = [(task.id, status.state) for task, status in self._tasks]
        self._held, self._tasks = sets, tasks
        if others:
            self._tiles.refresh()
        if said != [(task.id, status.state) for task, status in tasks]:
            self._errands.refresh()
        self._set_progress()

    def _gathered(self) -> tuple[list[tuple[str, Store | str]], list[tuple[StudioTask, TaskStatus]]]:
        """Return the data sets, or why one cannot be opened, and the errands that are not done. Reads files."""
        desk = self.desk
        names = [desk.studio.workspace.name_of(path) for path in desk.studio.workspace.stores()]
        tasks = [(task, desk.trainings.status(task)) for task in desk.trainings.all() if task.kind in WORDS]
        return [(name, _opened(desk, name)) for name in names], [
            one for one in tasks if one[1].state != "finished"
        ]

    def _set_progress(self) -> None:
        for task, status in self._tasks:
            if task.id in self._progress:
                set_progress(self._pace, task, status, *self._progress[task.id])

    @ui.refreshable_method
    def _tiles(self) -> None:
        ui.label("Data sets").classes("h2").props('role="heading" aria-level="2"')
        if not self._held:
            ui.label("None yet: simulate or import one below.").classes("quiet")
        with ui.element("div").classes("tiles w-full"):
            for name, store in self._held:
                _tile(name, store)

    @ui.refreshable_method
    def _errands(self) -> None:
        self._progress.clear()
        for task, status in self._tasks:
            with ui.element("section").classes("card w-full").props('aria-live="polite"'):
                self._errand(task, status)

    def _errand(self, task: StudioTask, status: TaskStatus) -> None:
        trainings = self.desk.trainings
        with ui.row().classes("items-center w-full gap-2"):
            ui.label(f"{WORDS[task.kind]} {task.about}")
            badge(status.state)
            ui.space()
            if status.active:
                stop = report_errors(lambda: trainings.stop(task.id, at_once=True))
                ui.button("Stop", on_click=stop).props("outline dense")
            else:
                ui.button("Dismiss", on_click=report_errors(lambda: trainings.forget(task.id))).props(
                    "flat dense"
                )
        if not status.active:
            ui.label(status.line).classes("small text-negative")
            return
        bar = ui.linear_progress(value=0.0, show_value=False, size="6px").props('aria-label="Progress"')
        self._progress[task.id] = (bar, ui.label().classes("small"))


def _opened(desk: MaterialsContext, name: str) -> Store | str:
    try:
        return desk.stores.get(name)
    except (TactogramError, OSError) as error:
        return str(error)


def _tile(name: str, store: Store | str) -> None:
    with ui.element("section").classes("card"):
        ui.link(name, address("set", set=name)).classes("h2").style("overflow-wrap: anywhere")
        if isinstance(store, str):
            ui.label(store).classes("small text-negative")
            return
        if store.simulated:
            ui.label("simulated").classes("simulated")
        ui.label(f"{store.name} · {len(store):,} recordings")
        streams = ", ".join(f"{key} ({facts.unit})" for key, facts in store.streams.items())
        ui.label(streams).classes("small quiet")
        ui.label(f"Licence: {store.licence}").classes("small quiet")
        ui.link("Train on it", f"/train?data={quote(name)}").classes("small")
