"""Page of an uploaded recording: read it, compare it, and add it to a store."""

from __future__ import annotations

from collections.abc import Mapping
from contextlib import suppress
from pathlib import Path
from typing import Any

from nicegui import app, ui
from starlette.requests import Request

from tactogram.datasets import Store
from tactogram.errors import ParameterError, TactogramError
from tactogram.model import condition_types
from tactogram.parameters import parameters
from tactogram.signal import Signal
from tactogram.signal.io import READABLE, USUAL, SignalFile, read_file
from tactogram.workflows import add_signal, reading_parameters
from tactogram_studio import kit
from tactogram_studio.pages.materials.media import COMPARED_BY, HEAD, address, draw_similar
from tactogram_studio.signals.view import add_routes, signal_card
from tactogram_studio.workspace.folder import Workspace
from tactogram_studio.workspace.recordings import open_named
from tactogram_studio.workspace.uploads import save_upload

FIELDS = ("unit", "rate", "axes", "time", "part", "sheet")
"""What the page asks of a file that does not state it: arguments of `read_file`."""
LABELS = {name: name.capitalize() for name in FIELDS} | {
    "rate": "Rate, Hz",
    "axes": "Axes or columns",
    "time": "Time stamps",
}
CONDITIONS = ("speed_mm_s", "force_n", "contactor", "session", "subject")
PICTURES = (".png", ".jpg", ".jpeg", ".webp", ".tif", ".tiff", ".bmp")


def add(workspace: Workspace) -> None:
    """Register ``/materials/drop``."""
    add_routes()

    @kit.route("/materials/drop")
    async def show(request: Request, file: str = "", set: str = "", by: str = "") -> None:
        if by:
            app.storage.user[COMPARED_BY] = by
        fields = {name: request.query_params.get(name, "") for name in FIELDS}
        ui.add_head_html(HEAD)
        with kit.page("Materials"):
            ui.link("All stores", "/materials").classes("small")
            uploaded = _UploadedFile(workspace, file, set, fields)
            uploaded.draw_upload()
            if file:
                with uploaded.analysis:
                    await uploaded.draw_file()


class _UploadedFile:
    """An uploaded file, stored in the workspace until it is removed; its settings are part of the page's address."""

    def __init__(self, workspace: Workspace, file: str, set_name: str, fields: Mapping[str, str]) -> None:
        self.workspace, self.file = workspace, file
        self.query = {"file": file, "set": set_name, **fields}
        self.folder = workspace.studio_folder / "dropped"
        self.sets = [workspace.name_of(path) for path in workspace.stores()]
        self.chosen_set = set_name if set_name in self.sets else ""
        self.set = self.chosen_set or next(iter(self.sets), "")

    @property
    def path(self) -> Path:
        path = self.workspace.inside(self.folder / self.file)
        if path.parent != self.folder or not path.is_file():
            raise ParameterError(f"{self.file[:100]}: no longer available; upload it again")
        return path

    @property
    def reading(self) -> dict[str, Any]:
        """Arguments of `read_file` that the file itself may lack."""
        known = {parameter.name: parameter for parameter in reading_parameters()}
        return {
            name: kit.value_of(known[name], text) for name in FIELDS if (text := self.query[name].strip())
        }

    def go(self, **changes: Any) -> None:
        ui.navigate.to(address("drop", **(self.query | {"set": self.set} | changes)))

    def _message(self, error: Exception) -> str:
        return kit.in_fields(error, LABELS).replace(f"{self.folder}/", "")

    def draw_upload(self) -> None:
        async def take(name: str, data: bytes) -> None:
            try:
                with kit.busy(f"Reading {name}"):
                    saved = await kit.in_background(store_signal, self.folder, name, data)
            except (TactogramError, OSError) as error:
                self._draw_failure(name, error)
                return
            ui.navigate.to(address("drop", file=saved.name, set=self.chosen_set))

        with kit.card("Upload a recording"):
            kit.hint(f"Supported files: {USUAL}. The recording stays on this machine.")
            kit.file_field(
                "Drop a file here, or choose one", take, accept=READABLE, refused=f"Expected one of {USUAL}."
            )
        self.analysis = kit.column()

    def _draw_failure(self, name: str, error: Exception) -> None:
        """Replace what is shown of an earlier file by the reason why a later one could not be read."""
        self.analysis.clear()
        ui.navigate.history.replace(address("drop", set=self.chosen_set))
        with self.analysis, ui.element("section").classes("card w-full"):
            kit.heading(name)
            kit.alert(self._message(error))

    async def draw_file(self) -> None:
        try:
            read = await kit.in_background(lambda: read_file(self.path, **self.reading))
        except (TactogramError, OSError, ValueError) as error:
            with kit.card(self.file):
                kit.alert(self._message(error))
                self._draw_reading()
            return
        signal = read.signal
        self.set = self.chosen_set or self._matching_set(signal)
        simulated = str(read.metadata.get("simulated", "")).lower() == "true"
        signal_card(signal, title=self.file, simulated=simulated)
        with kit.card(label="How it was read"):
            self._draw_notes(read)
            self._draw_reading(closed=True)
        if not self.sets:
            ui.label("There is no store to compare it with, or to add it to.")
            ui.link("Simulate or import one", "/materials")
            return
        with kit.card():
            sets = ui.select(self.sets, label="Store to compare with and add to", value=self.set)
            sets.classes("w-full max-w-lg").on_value_change(lambda event: self.go(set=event.value))
        stream = matching_stream(open_named(self.workspace, self.set), signal)
        draw_similar(self.workspace, signal, set_name=self.set, stream=stream)
        _AddForm(self, simulated, stream)

    def _draw_notes(self, read: SignalFile) -> None:
        if read.timing is not None and not read.timing.even:
            kit.hint("Its uneven time stamps were converted to even spacing.")
        others = [f"{name} ({', '.join(other.axes)}, {other.unit})" for name, other in read.others.items()]
        for note in (*read.notes, *([f"also holds {', '.join(others)}"] if others else [])):
            kit.hint(f"{kit.in_fields(note, LABELS)}.")

    def _matching_set(self, signal: Signal) -> str:
        """Return the first store with a stream of the signal's unit and domain, else the first."""
        for name in self.sets:
            with suppress(TactogramError, OSError):
                if matching_stream(open_named(self.workspace, name), signal):
                    return name
        return next(iter(self.sets), "")

    def _draw_reading(self, *, closed: bool = False) -> None:
        """Draw the fields for what many files lack, or leave open."""
        expansion = ui.expansion("Unit, rate, axes …", value=not closed).classes("w-full")
        examples = {"unit": "m/s^2, g, N", "axes": "x,y,z", "time": "ticks [us], or none"}
        with expansion, ui.row().classes("items-end gap-3"):
            kit.ParameterFields(
                reading_parameters(), FIELDS, labels=LABELS, examples=examples, entries=self.query
            )
            ui.button("Read again", on_click=self.go).props("outline")
            ui.button("Remove", on_click=self._remove).props("flat color=negative")

    def _remove(self) -> None:
        self.path.unlink(missing_ok=True)
        ui.navigate.to(address("drop", set=self.set))


class _AddForm:
    """Form that adds the uploaded recording to a store; its entries survive a reload."""

    def __init__(self, uploaded: _UploadedFile, simulated: bool, stream: str) -> None:
        self.uploaded = uploaded
        self.store = open_named(uploaded.workspace, uploaded.set)
        self.values: dict[str, Any] = app.storage.user.setdefault("drop", {}).setdefault(uploaded.file, {})
        fields = kit.Form(self.values, classes="w-36")
        materials = sorted({info.material for info in self.store.index if info.material})
        with kit.card(f"Add to {uploaded.set}", label="Add to the store"):
            with ui.row().classes("items-end gap-3"):
                fields.text("material", "Material", autocomplete=materials).classes("w-56", remove="w-36")
                if len(self.store.streams) > 1:
                    fields.choice("stream", list(self.store.streams), "Stream", stream)
                labels = {name: condition_types()[name].label for name in ("speed_mm_s", "force_n")}
                self.fields = kit.ParameterFields(
                    parameters(add_signal), CONDITIONS, labels=labels, entries=self.values
                )
            kit.hint("Enter a code as the subject, never a name.")
            photograph = kit.file_field("Photograph (optional)", self._take_photograph, accept=PICTURES)
            photograph.classes("max-w-lg")
            self.photograph = ui.label().classes("small")
            self._show_photograph()
            fields.classes, fields.changed = "", self._warn
            fields.box("simulated", "Simulated, or generated by a model", simulated).set_enabled(
                not simulated
            )
            self.warning = ui.label().classes("small")
            self.agreed = fields.box("agreed", "Mix measured and simulated recordings")
            self.problem = kit.alert()
            self.button = ui.button("Add", on_click=self._add)
            self.done = ui.column().classes("gap-1").props('role="status"')
        self._warn()

    def _warn(self) -> None:
        every = all(info.simulated for info in self.store.index)
        self.warning.text = mixing_warning(self.store.simulated, every, bool(self.values["simulated"]))
        self.agreed.visible = bool(self.warning.text)

    def _show_photograph(self) -> None:
        name = self.values.get("photograph")
        self.photograph.text = f"photograph: {name}" if name else ""

    async def _take_photograph(self, name: str, data: bytes) -> None:
        saved = await kit.in_background(save_upload, self.uploaded.folder, name, data, kind="image")
        self.values["photograph"] = saved.name
        self._show_photograph()

    async def _add(self) -> None:
        report: dict[str, Any] = {}
        with kit.refusals(self.problem, self.uploaded._message):
            if not (self.values.get("material") or "").strip():
                raise ParameterError("Material: enter the material that was touched")
            if self.agreed.visible and not self.values.get("agreed"):
                raise ParameterError(
                    "Measured and simulated recordings would be mixed: tick the box above to allow it"
                )
            with kit.busy("Adding the recording", button=self.button):
                report = await kit.in_background(self._added)
        self.done.clear()
        if not report:
            return
        with self.done:
            if report["added"]:
                ui.label(f"Added: {self.uploaded.set} now has {report['recordings']:,} recordings.")
                ui.label(
                    f"Its sha256 changed from {report['sha256_before'][:12]}… to {report['sha256'][:12]}…. New "
                    "trainings use the recording; existing runs refer to their own recordings as before."
                ).classes("small")
            else:
                ui.label("The store already has a recording with the same samples; nothing was changed.")
            query = {"set": self.uploaded.set, "id": report["id"], "stream": self.values.get("stream")}
            ui.link("Show the recording", address("recording", **query))

    def _added(self) -> dict[str, Any]:
        """Add the recording and return the report of `add_signal`."""
        values, workspace = self.values, self.uploaded.workspace
        photograph = values.get("photograph")
        return add_signal(
            workspace.inside(self.uploaded.set),
            self.uploaded.path,
            material=values["material"].strip(),
            stream=values["stream"] if len(self.store.streams) > 1 else None,
            photograph=workspace.inside(self.uploaded.folder / photograph) if photograph else None,
            simulated=bool(values["simulated"]),
            **self.uploaded.reading,
            **self.fields.values(),
        )


def store_signal(folder: Path, name: str, data: bytes) -> Path:
    """Store an uploaded signal under a safe, unused name; its errors may name arguments, which the page asks for."""
    try:
        return save_upload(folder, name, data, kind="signal")
    except TactogramError as error:
        if not any(remedy.parameter in FIELDS for remedy in error.message.remedies):
            raise
        return save_upload(folder, name, data, kind="signal", read=False)


def matching_stream(store: Store, signal: Signal) -> str:
    """Return the first stream of a store with the unit and domain of a signal; empty if there is none."""
    for name, facts in store.streams.items():
        if (facts.unit, facts.domain) == (signal.unit, signal.domain):
            return name
    return ""


def mixing_warning(any_simulated: bool, all_simulated: bool, adding_simulated: bool) -> str:
    """Return the consequences of mixing measured and simulated recordings; empty if nothing would be mixed.

    The first two parameters refer to the store, the last to the recording.
    """
    if adding_simulated and not any_simulated:
        return (
            "This store contains measured recordings only. With this recording, the store, every run trained on "
            "it and all their results are marked as simulated, permanently."
        )
    if not adding_simulated and all_simulated:
        return (
            "This store is simulated. A measured recording is marked as measured, but runs and results of the data "
            "set stay marked as simulated."
        )
    return ""
