"""Page that imports a folder of recordings: its choice, settings, preview, and the import into a store."""

from __future__ import annotations

import shlex
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

from nicegui import app, ui

from tactogram.datasets import MATERIAL_FROM, TableMapping, layouts_by_columns, read_mapping
from tactogram.errors import ParameterError, TactogramError
from tactogram.recipe import parse_changes
from tactogram.signal.io import TableLayout
from tactogram.workflows import list_sets
from tactogram_studio.layout import heading, hint, in_background, page, report_errors, route
from tactogram_studio.pages.materials import receiving
from tactogram_studio.pages.materials.import_start import ImportStart
from tactogram_studio.pages.materials.media import HEAD, MaterialsContext
from tactogram_studio.pages.materials.preview_view import PreviewView
from tactogram_studio.pages.materials.receiving import (
    add_routes,
    draw_chooser,
    drop_zone,
    import_address,
)
from tactogram_studio.workspace.received import ReceivedFolders

MATERIALS = {
    "folder": "the first folder",
    "last_folder": "the folder next to the file",
    "file": "the file name without the number at its end",
    "file_start": "the file name up to the first _",
}


def add(context: MaterialsContext) -> None:
    """Register ``/materials/import`` and the route that takes folders."""
    add_routes(context.studio.workspace)

    @route("/materials/import")
    async def show(folder: str = "", set: str = "folder") -> None:
        ui.add_head_html(HEAD + receiving.HEAD)
        with page("Materials"):
            ui.link("All stores", "/materials").classes("small")
            await ImportPage(context, folder, set).draw()


class ImportPage:
    """A folder to import; its settings survive a reload."""

    def __init__(self, context: MaterialsContext, folder: str, set_name: str) -> None:
        self.context, self.folder = context, folder
        self.workspace = context.studio.workspace
        self.received = ReceivedFolders(self.workspace)
        self.values: dict[str, Any] = app.storage.user.setdefault("import", {}).setdefault(folder, {})
        self.values.setdefault("set", set_name)
        for name, value in {"material_from": "folder", "options": "", "layouts": [], "mapping": ""}.items():
            self.values.setdefault(name, value)
        self.preview = PreviewView(self)

    @property
    def path(self) -> Path:
        """The folder; `ParameterError` if it is gone, or outside of the workspace."""
        path = self.workspace.inside(self.folder)
        if not path.is_dir():
            raise ParameterError(f"{self.folder[:200]}: no longer available; choose it again")
        return path

    @property
    def layouts(self) -> list[TableLayout]:
        """The mapping so far."""
        return [TableLayout.model_validate(values) for values in self.values["layouts"]]

    @property
    def is_folder(self) -> bool:
        """Whether the files are the user's own, which a mapping can describe."""
        return bool(self.values["set"] == "folder")

    def options(self) -> dict[str, Any]:
        """Return the options of the importer."""
        options = parse_changes(shlex.split(self.values["options"] or ""), option="Missing information")
        if self.is_folder:
            if self.values["material_from"] != "folder":
                options["material_from"] = self.values["material_from"]
            if layouts := self.layouts:
                options["mapping"] = TableMapping(layout=tuple(layouts))
        return options

    async def draw(self) -> None:
        """Draw the page, and begin the preview."""
        self._draw_source()
        if not self.folder:
            return
        try:
            path = self.path
        except ParameterError as error:
            with ui.element("section").classes("card w-full"):
                ui.label(str(error)).classes("text-negative").props('role="alert"')
            return
        sets = await in_background(list_sets)
        with ui.element("section").classes("card w-full").props('aria-label="Preview"'):
            heading(path.name)
            self._draw_settings(sets["import"])
            self.preview.draw_summary()
        self.preview.draw()
        ImportStart(self).draw()

    def _draw_source(self) -> None:
        workspace = self.workspace
        offered = {workspace.name_of(path): workspace.name_of(path) for path in workspace.recording_folders()}
        offered |= {
            workspace.name_of(path): f"{path.name} (sent to the studio)" for path in self.received.all()
        }
        with ui.element("section").classes("card w-full"), drop_zone():
            heading("Import recordings")
            hint(
                "Drop a folder with a folder for each material, or with tables that have a column of materials, or a "
                "zip of it. The files stay on this machine, and a "
                "preview shows how each would be read before anything is imported."
            )
            draw_chooser()
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
            if self.is_folder:
                materials = ui.select(
                    {name: MATERIALS[name] for name in MATERIAL_FROM},
                    label="Material named by",
                    value=self.values["material_from"],
                ).classes("w-72")
                materials.on_value_change(lambda event: self.change(material_from=event.value))
                mapping = ui.select(mappings, label="Saved mapping", value=self.values["mapping"]).classes(
                    "w-48"
                )
                mapping.on_value_change(lambda event: self._use_mapping(event.value))
            more = ui.input("What no file says", value=self.values["options"], placeholder="unit=g rate=1000")
            more.props("debounce=700").classes("w-60")
            more.on_value_change(lambda event: self.change(options=event.value or ""))
            if self.received.contains(self.path):
                ui.button("Remove from the studio", on_click=report_errors(self._remove)).props(
                    "flat no-caps color=negative"
                )

    def _use_mapping(self, name: str) -> None:
        try:
            layouts = read_mapping(self.workspace.inside(name)).layout if name else ()
        except TactogramError as error:
            self.preview.problem.text = str(error)
            return
        self._set_and_reload(mapping=name, layouts=[layout.model_dump(mode="json") for layout in layouts])

    def _set_and_reload(self, **values: Any) -> None:
        self.values.update(values)
        ui.navigate.to(import_address(self.folder))

    def _remove(self) -> None:
        self.received.remove(self.path)
        app.storage.user["import"].pop(self.folder, None)
        ui.navigate.to("/materials/import")

    def change(self, **values: Any) -> None:
        """Store settings, and preview anew."""
        self.values.update(values)
        ui.timer(0, report_errors(self.preview.refresh), once=True)

    def map_columns(self, layouts: Sequence[TableLayout]) -> None:
        """Store another mapping of some columns."""
        others = layouts_by_columns(self.layouts) | layouts_by_columns(layouts)
        flat = [layout.model_dump(mode="json") for alike in others.values() for layout in alike]
        self.values.update(layouts=flat, mapping="")
