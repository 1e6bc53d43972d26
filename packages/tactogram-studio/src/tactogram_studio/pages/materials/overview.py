"""Stores of the workspace as tiles, and the progress of simulations and imports."""

from __future__ import annotations

from urllib.parse import quote

from nicegui import ui

from tactogram.datasets import Store
from tactogram.errors import TactogramError
from tactogram_studio.layout import heading, hint, in_background, report_errors
from tactogram_studio.pages.materials.media import MaterialsContext, address
from tactogram_studio.pages.train.trainings import StudioTask, TaskStatus
from tactogram_studio.pages.train.widgets import TaskCards, TrainContext

UPDATE_S = 1.5


class StoreOverview:
    """Stores and unfinished tasks, updated regularly."""

    def __init__(self, context: MaterialsContext) -> None:
        self.context = context
        self._cards = TaskCards(TrainContext(context.studio, context.trainings), ("simulate", "import"))
        self._stores: list[tuple[str, Store | str]] = []

    async def draw(self) -> None:
        """Draw tasks and stores, and keep them up to date."""
        self._stores, tasks = await in_background(self._gather)
        self._cards.update(tasks)
        self._cards.draw()
        self._tiles()
        ui.timer(UPDATE_S, report_errors(self._update))

    async def _update(self) -> None:
        drawn = self._stores
        self._stores, tasks = await in_background(self._gather)
        if [name for name, _ in self._stores] != [name for name, _ in drawn]:
            self._tiles.refresh()
        self._cards.update(tasks)

    def _gather(self) -> tuple[list[tuple[str, Store | str]], list[tuple[StudioTask, TaskStatus]]]:
        """Return the stores, each opened or with the reason why it cannot be, and the unfinished tasks."""
        workspace, trainings = self.context.studio.workspace, self.context.trainings
        names = [workspace.name_of(path) for path in workspace.stores()]
        return [(name, self._open(name)) for name in names], self._cards.unfinished(trainings.all())

    def _open(self, name: str) -> Store | str:
        try:
            return self.context.store(name)
        except (TactogramError, OSError) as error:
            return str(error)

    @ui.refreshable_method
    def _tiles(self) -> None:
        heading("Stores")
        if not self._stores:
            ui.label("None yet: simulate or import one below.").classes("quiet")
        with ui.element("div").classes("tiles w-full"):
            for name, store in self._stores:
                with ui.element("section").classes("card whole"):
                    _draw_tile(name, store)


def _draw_tile(name: str, store: Store | str) -> None:
    ui.link(name, address("set", set=name)).classes("h2 whole-link").style("overflow-wrap: anywhere")
    if isinstance(store, str):
        ui.label(store).classes("small text-negative")
        return
    if store.simulated:
        ui.label("simulated").classes("simulated")
    ui.label(f"{store.name} · {len(store):,} recordings")
    hint(", ".join(f"{key} ({facts.unit})" for key, facts in store.streams.items()))
    hint(f"Licence: {store.licence}")
    ui.link("Train a model", f"/train?data={quote(name)}").classes("small")
