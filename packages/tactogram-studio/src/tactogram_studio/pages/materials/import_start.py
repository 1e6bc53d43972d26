"""Last card of the import page: name of the store, equivalent command, saving of the mapping, and progress."""

from __future__ import annotations

import shlex
from typing import TYPE_CHECKING

from nicegui import ui

from tactogram.datasets import proposed_layouts, read_mapping, write_mapping
from tactogram.errors import ParameterError, TactogramError
from tactogram_studio.layout import heading, hint, in_background, report_errors
from tactogram_studio.pages.materials.media import address
from tactogram_studio.pages.train.request import NAME
from tactogram_studio.pages.train.trainings import StudioTask, command_line, free_name
from tactogram_studio.pages.train.widgets import TaskCards, TrainContext

if TYPE_CHECKING:
    from tactogram_studio.pages.materials.import_page import ImportPage

MAPPINGS = "mappings"
"""Folder of the workspace for mappings."""
UPDATE_S = 1.0


class ImportStart:
    """Form that starts the import of a previewed folder, as a process that outlives the page."""

    def __init__(self, importing: ImportPage) -> None:
        self.page = importing
        self.workspace = importing.workspace
        self.trainings = importing.context.trainings
        self.started: StudioTask | None = None

    def draw(self) -> None:
        """Draw the form."""
        suggested = free_name(self.workspace.folder / "data", safe_store_name(self.page.path.name))
        with ui.element("section").classes("card w-full").props('aria-label="Import into a store"'):
            heading("Import into a store")
            with ui.row().classes("items-end gap-3 w-full"):
                self.name = ui.input("Name of the store", value=suggested).classes("w-60")
                self.skip = ui.checkbox("Leave the skipped files out")
            self.command = ui.element("code").classes("small")
            self.command.style("overflow-wrap: anywhere; display: block; min-height: 1.2em")
            self.problem = ui.label().classes("text-negative").props('role="alert"')
            with ui.row().classes("items-center gap-3"):
                self.button = ui.button("Import", on_click=report_errors(self._begin)).props("no-caps")
                if self.page.is_folder:
                    ui.button("Save mapping", on_click=report_errors(self._save)).props("outline no-caps")
            self.done = ui.column().classes("gap-1").props('role="status"')
            context = TrainContext(self.page.context.studio, self.trainings)
            self.cards = TaskCards(context, ("import",))
            self.cards.draw()
        ui.timer(UPDATE_S, report_errors(self._update))

    def _arguments(self, mapping: str) -> list[str]:
        page, name = self.page, (self.name.value or "").strip()
        if not NAME.fullmatch(name):
            raise ParameterError(f"Name: letters, digits, '.', '_' and '-', at most 80; got {name[:100]!r}")
        found = [
            "data",
            "import",
            page.values["set"],
            self.workspace.name_of(page.path),
            "--out",
            f"data/{name}",
        ]
        if mapping:
            found += ["--mapping", mapping]
        if page.is_folder and page.values["material_from"] != "folder":
            found += ["--set", f"material_from={page.values['material_from']}"]
        for setting in shlex.split(page.values["options"] or ""):
            found += ["--set", setting]
        return [*found, "--skip-bad"] if self.skip.value else found

    def _mapping_name(self) -> str:
        """Return the file of the mapping in use: a saved one, or one that is saved with the store's name."""
        if not (self.page.is_folder and self.page.layouts):
            return ""
        return self.page.values["mapping"] or f"{MAPPINGS}/{(self.name.value or '').strip()}.toml"

    async def _begin(self) -> None:
        self.problem.text = ""
        try:
            mapping = self._mapping_name()
            arguments = self._arguments(mapping)
            output = self.workspace.inside(f"data/{self.name.value.strip()}")
            if output.exists():
                raise ParameterError(f"data/{output.name}: already exists; choose another name")
            if self.page.preview.facts.get("question"):
                raise ParameterError("Say first what the paths name: the summary above asks")
            if self.page.preview.facts.get("needs_skip_bad") and not self.skip.value:
                raise ParameterError("Some files cannot be read: tick the box above to leave them out")
            if mapping and mapping != self.page.values["mapping"]:
                self._write(mapping)
            output.parent.mkdir(parents=True, exist_ok=True)
            self.started = await in_background(self.trainings.begin, "import", arguments, output)
        except (TactogramError, ValueError) as error:
            self.problem.text = str(error)
            return
        self.done.clear()
        with self.done:
            hint("Started. It continues if you close this tab.")

    def _write(self, mapping: str) -> None:
        """Write the mapping in use; one that exists is replaced only by the same."""
        path = self.workspace.inside(mapping)
        if path.exists():
            if [*read_mapping(path).layout] != self.page.layouts:
                raise ParameterError(f"{mapping}: holds another mapping; choose another name")
            return
        write_mapping(path, self.page.layouts)

    async def _save(self) -> None:
        if not self.page.preview.facts:
            raise ParameterError("Wait for the preview first")
        folder = self.workspace.folder / MAPPINGS
        path = folder / free_name(folder, safe_store_name(self.page.path.name), ".toml")
        layouts = proposed_layouts(self.page.preview.facts, self.page.layouts)
        await in_background(write_mapping, path, layouts)
        ui.notify(f"Saved as {self.workspace.name_of(path)}: it is offered above for other folders, too.")

    async def _update(self) -> None:
        try:
            self.command._text = command_line(self._arguments(self._mapping_name()))
        except (TactogramError, ValueError):
            self.command._text = ""
        self.command.update()
        self.skip.visible = bool(self.page.preview.facts.get("needs_skip_bad"))
        self.cards.update(await in_background(lambda: self.cards.unfinished(self.trainings.all())))
        if self.started is not None:
            status = await in_background(self.trainings.status, self.started)
            if status.state == "finished":
                self._show_finished(self.started.about)
                self.started = None

    def _show_finished(self, about: str) -> None:
        self.done.clear()
        with self.done:
            ui.label(f"{about} is complete.")
            ui.link("Open the store", address("set", set=about))
            ui.link("Train a model", f"/train?data={about}")


def safe_store_name(name: str) -> str:
    """Return a name that a store may have."""
    kept = "".join(c if c.isascii() and (c.isalnum() or c in "._-") else "_" for c in name)
    return kept.strip("._-")[:80] or "recordings"
