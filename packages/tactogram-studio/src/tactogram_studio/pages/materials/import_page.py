"""Page that imports a folder of recordings: its choice, settings, preview, and the import into a store."""

from __future__ import annotations

import shlex
from collections.abc import Mapping
from typing import Any

from nicegui import app, ui

from tactogram.datasets import (
    MATERIAL_FROM,
    proposed_layouts,
    read_mapping,
    write_mapping,
)
from tactogram.errors import ParameterError, TactogramError
from tactogram.workflows import list_sets
from tactogram_studio import kit
from tactogram_studio.kit.fields import (
    RECEIVING_HEAD,
    add_receiving_route,
    drop_zone,
    folder_chooser,
    import_address,
)
from tactogram_studio.kit.tasks import TaskCards, TaskStart
from tactogram_studio.pages.materials.media import HEAD, address
from tactogram_studio.pages.materials.preview_view import PreviewView
from tactogram_studio.tasks.queue import output_name, trainings_of
from tactogram_studio.workspace.commands import arguments, free_name
from tactogram_studio.workspace.folder import Workspace
from tactogram_studio.workspace.imports import ImportSettings
from tactogram_studio.workspace.received import ReceivedFolders

MAPPINGS = "mappings"
"""Folder of the workspace for mappings."""
UPDATE_S = 1.0
MATERIALS = {
    "folder": "the first folder",
    "last_folder": "the folder next to the file",
    "file": "the file name without the number at its end",
    "file_start": "the file name up to the first _",
}


def add(workspace: Workspace) -> None:
    """Register ``/materials/import`` and the route that takes folders."""
    add_receiving_route(workspace)

    @kit.route("/materials/import")
    async def show(folder: str = "", set: str = "folder") -> None:
        ui.add_head_html(HEAD + RECEIVING_HEAD)
        with kit.page("Materials"):
            ui.link("All stores", "/materials").classes("small")
            await ImportPage(workspace, folder, set).draw()


class ImportPage:
    """A folder to import; its settings survive a reload."""

    def __init__(self, workspace: Workspace, folder: str, set_name: str) -> None:
        self.workspace, self.folder = workspace, folder
        self.received = ReceivedFolders(workspace)
        self.values: dict[str, Any] = app.storage.user.setdefault("import", {}).setdefault(folder, {})
        self.values.setdefault("set", set_name)
        for name, value in {"material_from": "folder", "options": "", "layouts": [], "mapping": ""}.items():
            self.values.setdefault(name, value)
        self.settings = ImportSettings(workspace, folder, self.values)
        self.preview = PreviewView(self.settings, self._answer)

    async def draw(self) -> None:
        """Draw the page, and begin the preview."""
        self._draw_source()
        if not self.folder:
            return
        name, sets = self.settings.path.name, await kit.in_background(list_sets)
        with kit.card(name, label="Preview"):
            self._draw_settings(sets["import"])
            self.preview.draw_summary()
        self.preview.draw()
        _ImportStart(self)

    def _draw_source(self) -> None:
        workspace = self.workspace
        offered = {workspace.name_of(path): workspace.name_of(path) for path in workspace.recording_folders()}
        offered |= {
            workspace.name_of(path): f"{path.name} (sent to the studio)" for path in self.received.all()
        }
        with ui.element("section").classes("card w-full"), drop_zone():
            kit.heading("Import recordings")
            kit.hint(
                "Drop a folder with a folder for each material, or with tables that have a column of materials, or a "
                "zip of it. The files stay on this machine, and a "
                "preview shows how each would be read before anything is imported."
            )
            folder_chooser()
            if offered:
                chosen = self.folder if self.folder in offered else None
                field = ui.select(
                    offered, label="Or a folder of the workspace", value=chosen, with_input=True
                )
                field.classes("w-full max-w-lg")
                field.on_value_change(lambda event: ui.navigate.to(import_address(event.value)))

    def _draw_settings(self, sets: Mapping[str, Any]) -> None:
        saved = [path for path, values in self.workspace.toml_files() if "layout" in values]
        mappings = {"": "none"} | {self.workspace.name_of(path): path.stem for path in saved}
        if self.values["mapping"] not in mappings:
            self.values["mapping"] = ""
        if self.values["set"] not in sets:
            self.values["set"] = "folder"
        with ui.row().classes("w-full items-end gap-3"):
            kinds = {name: f"{name}: {facts['title']}" for name, facts in sets.items()}
            kind = ui.select(kinds, label="Kind of data", value=self.values["set"]).classes("w-72")
            kind.on_value_change(lambda event: self._set_and_reload(set=event.value))
            if self.settings.is_folder:
                materials = ui.select(
                    {name: MATERIALS[name] for name in MATERIAL_FROM},
                    label="Material named by",
                    value=self.values["material_from"],
                ).classes("w-72")
                materials.on_value_change(lambda event: self.change(material_from=event.value))
                mapping = ui.select(mappings, label="Saved mapping", value=self.values["mapping"])
                mapping.classes("w-48").on_value_change(lambda event: self._use_mapping(event.value))
            more = ui.input(
                "Not stated in the files", value=self.values["options"], placeholder="unit=g rate=1000"
            )
            more.props("debounce=700").classes("w-60")
            more.on_value_change(lambda event: self.change(options=event.value or ""))
            if self.received.contains(self.settings.path):
                ui.button("Remove from the studio", on_click=self._remove).props("flat color=negative")

    def _use_mapping(self, name: str) -> None:
        try:
            layouts = read_mapping(self.workspace.inside(name)).layout if name else ()
        except TactogramError as error:
            self.preview.problem.text = str(error)
            return
        self._set_and_reload(mapping=name, layouts=[layout.model_dump(mode="json") for layout in layouts])

    def _answer(self, pattern: str) -> None:
        self._set_and_reload(options=f"{self.values['options'] or ''} path={pattern}".strip())

    def _set_and_reload(self, **values: Any) -> None:
        self.values.update(values)
        ui.navigate.to(import_address(self.folder))

    def _remove(self) -> None:
        self.received.remove(self.settings.path)
        app.storage.user["import"].pop(self.folder, None)
        ui.navigate.to("/materials/import")

    def change(self, **values: Any) -> None:
        """Store settings, and preview anew."""
        self.values.update(values)
        ui.timer(0, self.preview.refresh, once=True)


class _ImportStart:
    """Form that starts the import of a previewed folder, as a process that outlives the page."""

    def __init__(self, importing: ImportPage) -> None:
        self.settings, self.preview = importing.settings, importing.preview
        self.workspace = importing.workspace
        self.queue = trainings_of(self.workspace)
        suggested = free_name(self.workspace.folder / "data", safe_store_name(self.settings.path.name))
        with kit.card("Import into a store"):
            with ui.row().classes("items-end gap-3 w-full"):
                self.name = ui.input("Name of the store", value=suggested).classes("w-60")
                self.skip = ui.checkbox("Leave the skipped files out")
            self.start = TaskStart(
                self.queue,
                "import",
                "Import",
                arguments=self._arguments,
                output=lambda: output_name("data", self.name.value),
                prepare=self._prepare,
            )
            if self.settings.is_folder:
                with self.start.row:
                    ui.button("Save mapping", on_click=self._save).props("outline")
            self.done = ui.column().classes("gap-1").props('role="status"')
            TaskCards(self.queue, ("import",)).follow(UPDATE_S)
        ui.timer(UPDATE_S, self._update)

    def _arguments(self) -> list[str]:
        settings, more = self.settings, shlex.split(self.settings.values["options"] or "")
        if settings.is_folder and settings.values["material_from"] != "folder":
            more.insert(0, f"material_from={settings.values['material_from']}")
        return arguments(
            "data",
            "import",
            settings.values["set"],
            self.workspace.name_of(settings.path),
            out=output_name("data", self.name.value),
            mapping=self._mapping_name(),
            options=more,
            skip_bad=bool(self.skip.value),
        )

    def _mapping_name(self) -> str:
        """Return the file of the mapping in use: a saved one, or one that is saved with the store's name."""
        if not (self.settings.is_folder and self.settings.layouts):
            return ""
        return self.settings.values["mapping"] or f"{MAPPINGS}/{(self.name.value or '').strip()}.toml"

    def _prepare(self) -> None:
        """Refuse an import that would fail, and write the mapping in use; one that exists must be the same."""
        facts, mapping = self.preview.facts, self._mapping_name()
        if facts.get("question"):
            raise ParameterError("Say first what the paths name: the summary above asks")
        if facts.get("needs_skip_bad") and not self.skip.value:
            raise ParameterError("Some files cannot be read: tick the box above to leave them out")
        if not mapping or mapping == self.settings.values["mapping"]:
            return
        path = self.workspace.inside(mapping)
        if not path.exists():
            write_mapping(path, self.settings.layouts)
        elif [*read_mapping(path).layout] != self.settings.layouts:
            raise ParameterError(f"{mapping}: holds another mapping; choose another name")

    async def _save(self) -> None:
        if not self.preview.facts:
            raise ParameterError("Wait for the preview first")
        folder = self.workspace.folder / MAPPINGS
        path = folder / free_name(folder, safe_store_name(self.settings.path.name), ".toml")
        layouts = proposed_layouts(self.preview.facts, self.settings.layouts)
        await kit.in_background(write_mapping, path, layouts)
        ui.notify(f"Saved as {self.workspace.name_of(path)}: it is offered above for other folders, too.")

    async def _update(self) -> None:
        self.skip.visible = bool(self.preview.facts.get("needs_skip_bad"))
        if (task := self.start.task) is not None:
            status = await kit.in_background(self.queue.status, task)
            if status.state == "finished":
                self.start.task = None
                self.done.clear()
                with self.done:
                    ui.label(f"{task.about} is complete.")
                    ui.link("Open the store", address("set", set=task.about))
                    ui.link("Train a model", f"/train?data={task.about}")


def safe_store_name(name: str) -> str:
    """Return a name that a store may have."""
    kept = "".join(c if c.isascii() and (c.isalnum() or c in "._-") else "_" for c in name)
    return kept.strip("._-")[:80] or "recordings"
