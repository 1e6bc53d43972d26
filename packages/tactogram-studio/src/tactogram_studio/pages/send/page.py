"""The page Send: renders a signal for a display or as haptic files, and plays it."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

from fastapi.responses import FileResponse
from nicegui import app, ui

from tactogram.errors import ParameterError
from tactogram.signal import Signal
from tactogram.signal.io import write_signal
from tactogram.workflows import reading_parameters
from tactogram_studio import kit
from tactogram_studio.context import Studio
from tactogram_studio.pages.send.display import DisplayCards
from tactogram_studio.pages.send.files import FileCards
from tactogram_studio.signals.sound import LISTENING, listening_name, sound_of, sound_text
from tactogram_studio.signals.view import add_routes, placeholder, signal_card
from tactogram_studio.tasks.speaker import Speaker
from tactogram_studio.workspace.commands import free_name, stem_of
from tactogram_studio.workspace.sent import SendResult, SendService
from tactogram_studio.workspace.shelf import LONGEST_TITLE, SelectedSignal
from tactogram_studio.workspace.uploads import read_uploaded_signal, safe_name

STATE = "send"
"""Key of the page's settings in the browser's storage."""
GROUPS = {
    "kept": "Kept results",
    "file": "Files: outputs of runs, uploads and others",
    "recording": "Recordings",
}
"""Titles of the kinds of signals."""
MOST_MIB = 256


def add(studio: Studio) -> None:
    """Register the page and the route of its results."""
    service, speaker = SendService(studio.workspace, studio.shelf), Speaker(studio.workspace.studio_folder)
    add_routes()
    app.on_shutdown(speaker.stop)

    @app.get("/send/result/{identifier}/{name}")
    def result(identifier: str, name: str) -> FileResponse:
        path = _result_file(service, identifier, name)
        return FileResponse(path, filename=None if name.endswith(".png") else name)  # pictures are displayed

    @kit.route("/send")
    def show(of: str = "", tab: str = "", key: str = "") -> None:
        with kit.page("Send"):
            SendPage(studio, service, speaker, of, tab, key)


def _result_file(service: SendService, identifier: str, name: str) -> Path:
    result = service.get(identifier)
    files = result.facts.get("files", {}).values()
    names = {facts["file"] for facts in files if "file" in facts}
    if name in names or (name in ("drive.report.json", "drive.report.png") and "report" in result.facts):
        return result.folder / name
    suffix = f".{name.removeprefix('drive.')}" if name.startswith("drive.") else name
    return service.drive_file(result, suffix)


class SendPage:
    """One browser tab, opened with the signal ``of`` and the ``tab`` display or file, or the last ones."""

    def __init__(
        self, studio: Studio, service: SendService, speaker: Speaker, of: str, tab: str, key: str
    ) -> None:
        self.studio, self.sources = studio, service.sources
        self.state = kit.TabSettings(app.storage.user.setdefault(STATE, {}), key)
        self.state["tab"] = tab or self.state.get("tab", "display")
        self.selected: SelectedSignal | None = None
        self.signal: Signal | None = None
        of = of or str(self.state.get("of", ""))
        self._loading = bool(of)
        self._asked = of
        self._keep(of=of)
        with ui.element("div").classes("grid-2"):
            with kit.column():
                self._source_card(of)
            with kit.column():
                self._signal()
        with ui.tabs().classes("w-full") as tabs:
            display_tab = ui.tab("display", label="To a display")
            file_tab = ui.tab("file", label="To a haptic file")
        shown = file_tab if self.state["tab"] == "file" else display_tab
        panels = ui.tab_panels(tabs, value=shown, on_change=lambda event: self._keep(tab=event.value))
        with panels.classes("w-full bg-transparent").props("keep-alive"):
            with ui.tab_panel(display_tab).classes("p-0"):
                display = DisplayCards(service, speaker, self.state)
            with ui.tab_panel(file_tab).classes("p-0"):
                files = FileCards(service, self.state)
        self._cards, self._latest = (display, files), service.latest
        if of:
            ui.timer(0.05, lambda: self._select(of), once=True)

    def _keep(self, **changes: str) -> None:
        """Remember the signal and the tab, and name them in the address: for a reload, the way back and other tabs."""
        self.state.update(changes)
        kit.keep_address("/send", of=self.state["of"], tab=self.state["tab"], key=self.state.key)

    def _required(self) -> SelectedSignal:
        if self.selected is None:
            raise ParameterError("Choose a signal to send first.")
        return self.selected

    def _source_card(self, of: str) -> None:
        with kit.card("Signal to send"):
            kind = of.partition(":")[0]
            if kind not in GROUPS:
                kind = "kept" if self.sources.kept() else "file" if self.sources.files() else "recording"
            self._group = ui.select(GROUPS, label="From", value=kind, on_change=self._listed.refresh)
            self._group.classes("w-full")
            self._listed()
            empty = kind == "recording" and not self.sources.stores()
            with ui.expansion("Upload a file", value=empty).classes("w-full"):
                kit.hint("If they are not in the file:")
                labels, examples = {"rate": "Rate, Hz"}, {"unit": "m/s^2, g, N, 1 …"}
                self._reading = kit.ParameterFields(
                    reading_parameters(), ("unit", "rate"), labels=labels, examples=examples
                )
                kit.file_field("WAV, FLAC, CSV, NPZ, Excel", self._upload, most_mib=MOST_MIB)

    @ui.refreshable_method
    def _listed(self) -> None:
        kit.signal_choice(self.sources, self._group.value, self._select, last=str(self.state.get("of", "")))

    async def _upload(self, name: str, data: bytes) -> None:
        def store() -> str:
            signal = read_uploaded_signal(name, data, **self._reading.values())
            folder = self.studio.workspace.studio_folder / "uploads"
            folder.mkdir(parents=True, exist_ok=True)
            path = folder / free_name(folder, Path(safe_name(name)).stem, ".npz")
            write_signal(path, signal, metadata={"uploaded": name})
            return f"file:{self.studio.workspace.name_of(path)}"

        self.state["of"] = of = await kit.in_background(store)
        self._group.value = "file"
        self._listed.refresh()
        await self._select(of)

    async def _select(self, of: str) -> None:
        """Show a signal with its own newest results, and nothing of the one before meanwhile."""
        self._asked = of
        self._show(None, loading=True)
        try:
            selected = await kit.in_background(self.sources.select, of)
            signal = await kit.in_background(selected.signal)
            results = [await kit.in_background(self._latest, selected, cards.kind) for cards in self._cards]
        except Exception:
            if of == self._asked:
                self._show(None)
            raise
        if of == self._asked:  # no other one has been chosen meanwhile
            self._keep(of=of)
            self._show(selected, signal, results)

    def _show(
        self,
        selected: SelectedSignal | None,
        signal: Signal | None = None,
        results: Sequence[SendResult | None] = (None, None),
        *,
        loading: bool = False,
    ) -> None:
        self.selected, self.signal, self._loading = selected, signal, loading
        self._signal.refresh()
        for cards, result in zip(self._cards, results, strict=True):
            cards.set_signal(selected, signal, result)

    @ui.refreshable_method
    def _signal(self) -> None:
        if self.selected is None or self.signal is None:
            with kit.card(label="The signal"):
                if self._loading:
                    placeholder("Reading …", small=True)
                else:
                    ui.label("Choose a kept result, a file or a recording, or upload a file.").classes(
                        "quiet"
                    )
            return
        with ui.element("div").props('aria-label="The signal" role="region"').classes("w-full"):
            title, simulated = self.selected.title, self.selected.simulated
            top = signal_card(self.signal, title=title, simulated=simulated, small=True)
            with top, ui.element("div").classes("done"):
                listen = ui.button("For listening (WAV)", on_click=self._listen).props("flat dense")
                listen.tooltip(LISTENING)
                if self.selected.id.startswith("kept:"):
                    rename = ui.button(
                        "Rename", on_click=lambda: kit.ask_title(title, LONGEST_TITLE, self._rename)
                    )
                    rename.props("flat dense")
                    ui.button("Delete", on_click=self._remove).props("flat dense color=negative")

    async def _listen(self) -> None:
        signal = self.signal
        if signal is not None:
            name = listening_name(stem_of(Path(self._required().title).stem))
            clip = await kit.in_background(sound_of, signal, subtype="PCM_16")
            ui.download.content(clip.wav, name)
            ui.notify(f"{name} {sound_text(signal)}.")

    async def _rename(self, title: str) -> None:
        selected = self._required()
        self.studio.shelf.rename(selected.id.removeprefix("kept:"), title)
        self._listed.refresh()
        await self._select(selected.id)

    async def _remove(self) -> None:
        selected = self._required()
        text = f"Delete {selected.title} from the kept results? This cannot be undone."
        if await kit.confirm(text, "Delete"):
            self.studio.shelf.remove(selected.id.removeprefix("kept:"))
            self._keep(of="")
            self._listed.refresh()
            self._show(None)
