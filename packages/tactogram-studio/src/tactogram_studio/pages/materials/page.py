"""The page Materials: the stores of the workspace, a form to simulate one, and a place to drop recordings."""

from __future__ import annotations

from urllib.parse import quote

from nicegui import ui

from tactogram.datasets import Store
from tactogram.errors import TactogramError
from tactogram.workflows import list_sets
from tactogram_studio import kit
from tactogram_studio.context import Studio
from tactogram_studio.kit.files import RECEIVING_HEAD, drop_zone, folder_chooser
from tactogram_studio.kit.tasks import TaskCards, TaskStart
from tactogram_studio.pages.materials import drop, import_page, store
from tactogram_studio.pages.materials.media import HEAD, add_routes, address
from tactogram_studio.tasks.queue import StudioTask, TaskStatus, output_name, trainings_of
from tactogram_studio.workspace.commands import arguments, free_name
from tactogram_studio.workspace.folder import Workspace
from tactogram_studio.workspace.recordings import open_named

UPDATE_S = 1.5


def add(studio: Studio) -> None:
    """Register ``/materials`` and the pages below it."""
    workspace = studio.workspace
    trainings_of(workspace).keep_advancing()
    add_routes(workspace)
    store.add(workspace)
    drop.add(workspace)
    import_page.add(workspace)

    @kit.route("/materials")
    async def show() -> None:
        ui.add_head_html(HEAD + RECEIVING_HEAD)
        with kit.page("Materials"):
            with kit.card(), ui.row().classes("items-center justify-between w-full"):
                ui.label("Upload a recording to see which materials it resembles, and add it to a store.")
                ui.button("Upload a recording", on_click=lambda: ui.navigate.to("/materials/drop"))
            await _StoreOverview(workspace).draw()
            sets = await kit.in_background(list_sets)
            with ui.element("div").classes("grid-2") as columns:
                columns.style("grid-template-columns: repeat(auto-fit, minmax(18rem, 1fr))")
                _draw_simulation(workspace, sets["simulate"])
                _draw_import()


def _draw_simulation(workspace: Workspace, sets: dict[str, str]) -> None:
    with kit.card("Simulate a data set", classes=""):
        kit.hint("Surfaces computed from formulas. Everything derived from them is marked as simulated.")
        options = {name: f"{name}: {text}" for name, text in sets.items()}
        kind = ui.select(options, label="Set", value="stroking9").classes("w-full")
        with ui.row().classes("w-full no-wrap"):
            per_class = kit.NumberField("Recordings per class", placeholder="default").classes("col")
            seconds = kit.NumberField("Seconds", placeholder="default").classes("col")
        with ui.row().classes("w-full no-wrap"):
            photographs = kit.NumberField("Photographs per surface", placeholder="one").classes("col")
            seed = kit.NumberField("Seed", value=0).classes("col")
        name = ui.input("Name").classes("w-full")

        def command() -> list[str]:
            options = {
                "--out": output_name("data", name.value),
                "--seed": seed.checked(least=0, whole=True),
                "--per-class": per_class.checked(least=1, whole=True),
                "--seconds": seconds.checked(least=0.1, most=3600),
                "--photographs": photographs.checked(least=0, most=9, whole=True),
            }
            return arguments("data", "simulate", str(kind.value), options=options)

        def suggest() -> None:
            name.value = free_name(workspace.folder / "data", str(kind.value))

        kind.on_value_change(suggest)
        suggest()
        TaskStart(
            trainings_of(workspace),
            "simulate",
            "Simulate",
            arguments=command,
            output=lambda: output_name("data", name.value),
        )


def _draw_import() -> None:
    with kit.card("Import recordings", classes=""), drop_zone():
        kit.hint(
            "Drop a folder with a folder for each material, or a zip of it: the studio shows how every file would be "
            "read before it imports them."
        )
        folder_chooser()
        text = "Import from a folder of the workspace, or a published data set"
        ui.link(text, "/materials/import").classes("small")


class _StoreOverview:
    """Stores and unfinished tasks, updated regularly."""

    def __init__(self, workspace: Workspace) -> None:
        self.workspace, self.queue = workspace, trainings_of(workspace)
        self._cards = TaskCards(self.queue, ("simulate", "import"))
        self._stores: list[tuple[str, Store | str]] = []

    async def draw(self) -> None:
        """Draw tasks and stores, and keep them up to date."""
        self._stores, tasks = await kit.in_background(self._gather)
        self._cards.update(tasks)
        self._cards.draw()
        self._tiles()
        ui.timer(UPDATE_S, self._update)

    async def _update(self) -> None:
        drawn = self._stores
        self._stores, tasks = await kit.in_background(self._gather)
        if [name for name, _ in self._stores] != [name for name, _ in drawn]:
            self._tiles.refresh()
        self._cards.update(tasks)

    def _gather(self) -> tuple[list[tuple[str, Store | str]], list[tuple[StudioTask, TaskStatus]]]:
        """Return the stores, each opened or with the reason why it cannot be, and the unfinished tasks."""
        names = [self.workspace.name_of(path) for path in self.workspace.stores()]
        return [(name, self._open(name)) for name in names], self._cards.unfinished(self.queue.all())

    def _open(self, name: str) -> Store | str:
        try:
            return open_named(self.workspace, name)
        except (TactogramError, OSError) as error:
            return str(error)

    @ui.refreshable_method
    def _tiles(self) -> None:
        kit.heading("Stores")
        if not self._stores:
            ui.label("None yet: simulate or import one below.").classes("quiet")
        with ui.element("div").classes("tiles w-full"):
            for name, store in self._stores:
                with kit.card(classes="whole"):
                    _draw_tile(name, store)


def _draw_tile(name: str, store: Store | str) -> None:
    ui.link(name, address("set", set=name)).classes("h2 whole-link").style("overflow-wrap: anywhere")
    if isinstance(store, str):
        ui.label(store).classes("small text-negative")
        return
    kit.mark_simulated(store.simulated)
    ui.label(f"{store.name} · {len(store):,} recordings")
    kit.hint(", ".join(f"{key} ({facts.unit})" for key, facts in store.streams.items()))
    kit.hint(f"Licence: {store.licence}")
    ui.link("Train a model", f"/train?data={quote(name)}").classes("small")
