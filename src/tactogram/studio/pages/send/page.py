"""The page Send: any result to the drive of a display or to a haptic file, with what that changed; and playing it."""

from __future__ import annotations

from pathlib import Path
from typing import Any

from fastapi.responses import FileResponse, JSONResponse
from nicegui import app, ui
from nicegui.events import UploadEventArguments

from tactogram.errors import TactogramError
from tactogram.signal.io import write_signal
from tactogram.studio.context import Studio
from tactogram.studio.layout import in_background, page, report_errors, upload
from tactogram.studio.pages.send.display import DisplayCards
from tactogram.studio.pages.send.files import FileCards
from tactogram.studio.pages.send.sending import SelectedSignal, SendService
from tactogram.studio.pages.send.speaker import Speaker
from tactogram.studio.signals.view import add_routes, placeholder, signal_card
from tactogram.studio.workspace.shelf_view import ask_removal, ask_title
from tactogram.studio.workspace.uploads import read_uploaded_signal, safe_name

KEPT = "send"
GROUPS = {"kept": "Kept results", "file": "Runs' outputs, uploads and other files", "recording": "Recordings"}
MOST_BYTES = 256 * 2**20


def add(studio: Studio) -> None:
    """Register the page, and where its results are fetched."""
    sending, speaker = SendService(studio.workspace, studio.shelf), Speaker(studio.workspace.studio_folder)
    add_routes()
    app.on_shutdown(speaker.stop)

    @app.get("/send/result/{identifier}/{name}")
    def result(identifier: str, name: str) -> Any:
        try:
            return FileResponse(_file_of(sending, identifier, name), filename=_told_name(name))
        except TactogramError as error:
            return JSONResponse({"error": str(error)}, status_code=404)

    @ui.page("/send")
    def show(of: str = "") -> None:
        ui.add_head_html('<link rel="stylesheet" href="/static/send.css">')
        with page("Send"):
            SendPage(studio, sending, speaker, of=of)


def _file_of(sending: SendService, identifier: str, name: str) -> Path:
    """Return a file of a result; only what the result itself names."""
    sent = sending.get(identifier)
    files = sent.found.get("files", {})
    named = {facts["file"] for facts in files.values() if "file" in facts}
    named |= {sent.found["zip"]} if sent.found.get("zip") else set()
    if name in named or (name in ("drive.report.json", "drive.report.png") and "report" in sent.found):
        return sent.folder / name
    return sending.drive_file(sent, f".{name.removeprefix('drive.')}" if name.startswith("drive.") else name)


def _told_name(name: str) -> str | None:
    """Return under which name a file is saved; pictures are shown, not saved."""
    return None if name.endswith(".png") else name


class SendPage:
    """One tab."""

    def __init__(self, studio: Studio, sending: SendService, speaker: Speaker, *, of: str) -> None:
        self.studio, self.sending = studio, sending
        self.kept: dict[str, Any] = app.storage.user.setdefault(KEPT, {})
        self.chosen: SelectedSignal | None = None
        self._reading = bool(of or self.kept.get("of"))
        of = of or str(self.kept.get("of", ""))
        self.kept["of"] = of
        with ui.element("div").classes("grid-2"):
            with ui.column().classes("items-stretch gap-4"):
                self._choose_card(of)
            with ui.column().classes("items-stretch gap-4"):
                self._signal()
        with ui.tabs().classes("w-full") as tabs:
            display_tab = ui.tab("display", label="To a display")
            file_tab = ui.tab("file", label="To a haptic file")
        at = display_tab if self.kept.get("tab", "display") == "display" else file_tab
        with (
            ui.tab_panels(tabs, value=at, on_change=self._turned)
            .classes("w-full bg-transparent")
            .props("keep-alive")
        ):
            with ui.tab_panel(display_tab).classes("p-0"):
                self.display = DisplayCards(sending, speaker, self.kept, self._chosen_now)
            with ui.tab_panel(file_tab).classes("p-0"):
                self.files = FileCards(sending, self.kept, self._chosen_now)
        if of:
            ui.timer(0.05, lambda: self._take(of), once=True)

    def _turned(self, event: Any) -> None:
        self.kept["tab"] = event.value

    def _chosen_now(self) -> SelectedSignal | None:
        return self.chosen

    def _choose_card(self, of: str) -> None:
        with ui.element("section").classes("card w-full").props('aria-label="What to send"'):
            ui.label("What to send").classes("h2")
            kind = of.partition(":")[0] if of.partition(":")[0] in GROUPS else self._first_group()
            self._group = ui.select(GROUPS, label="From", value=kind, on_change=self._group_chosen).classes(
                "w-full"
            )
            self._listed()
            with ui.expansion("Upload a file").classes("w-full"):
                self._unit = ui.input("Unit, if the file does not say").props('hint="m/s^2, g, N, 1 …"')
                self._rate = ui.number("Rate, Hz, if the file does not say")
                upload(
                    "WAV, FLAC, CSV, NPZ, Excel",
                    max_file_size=MOST_BYTES,
                    on_upload=self._uploaded,
                    on_rejected=lambda: ui.notify("at most 256 MiB can be sent here", type="negative"),
                ).classes("w-full")

    def _group_chosen(self) -> None:
        self._listed.refresh()

    def _first_group(self) -> str:
        return "kept" if self.sending.kept() else "file" if self.sending.files() else "recording"

    @ui.refreshable_method
    def _listed(self) -> None:
        kind = str(self._group.value)
        if kind == "recording":
            stores = self.sending.stores()
            if not stores:
                ui.label("No data set in this workspace yet.").classes("quiet")
                return
            of = str(self.kept.get("of", ""))
            held = of.removeprefix("recording:").partition("#")[0]
            store = ui.select(
                stores, label="Data set", value=held if held in stores else next(iter(stores))
            ).classes("w-full")
            place = ui.column().classes("w-full")
            store.on_value_change(lambda: self._recordings(place, str(store.value)))
            self._recordings(place, str(store.value))
            return
        found = self.sending.kept() if kind == "kept" else self.sending.files()
        if not found:
            ui.label(
                "Nothing is kept yet: make something and keep it."
                if kind == "kept"
                else "No signal file lies in the workspace."
            ).classes("quiet")
            return
        self._item(found, "Result" if kind == "kept" else "File")

    def _recordings(self, place: ui.column, store: str) -> None:
        place.clear()
        with place:
            self._item(self.sending.recordings(store), "Recording")

    def _item(self, found: dict[str, str], label: str) -> None:
        held = self.kept.get("of")
        picked = ui.select(
            found, label=label, value=held if held in found else None, with_input=len(found) > 12
        ).classes("w-full")
        picked.on_value_change(lambda: self._take(str(picked.value)) if picked.value else None)

    @report_errors
    async def _uploaded(self, event: UploadEventArguments) -> None:
        options = {"unit": (self._unit.value or "").strip() or None, "rate": self._rate.value or None}
        data = await event.file.read()
        given = {key: value for key, value in options.items() if value is not None}
        name = event.file.name

        def keep() -> str:
            signal = read_uploaded_signal(name, data, **given)
            folder = self.studio.workspace.studio_folder / "uploads"
            folder.mkdir(parents=True, exist_ok=True)
            stem, count = Path(safe_name(name)).stem, 1
            while (path := folder / f"{stem}{'' if count == 1 else f'-{count}'}.npz").exists():
                count += 1
            write_signal(path, signal, metadata={"uploaded": name})
            return f"file:{self.studio.workspace.name_of(path)}"

        of = await in_background(keep)
        self._group.value = "file"
        self.kept["of"] = of
        self._listed.refresh()
        await self._take(of)

    @report_errors
    async def _take(self, of: str) -> None:
        try:
            chosen = await in_background(self.sending.chosen, of)
            self.chosen, self.signal = chosen, await in_background(chosen.signal)
            self.kept["of"] = of
        finally:
            self._reading = False
            self._signal.refresh()
        self.display.signal_chosen(self.signal)
        self.files.signal_chosen(self.signal)

    @ui.refreshable_method
    def _signal(self) -> None:
        if self.chosen is None:
            with ui.element("section").classes("card w-full").props('aria-label="The signal"'):
                if self._reading:
                    placeholder("Reading …", small=True)
                else:
                    ui.label("Choose a kept result, a file or a recording.").classes("quiet")
            return
        with ui.element("div").props('aria-label="The signal" role="region"').classes("w-full"):
            top = signal_card(
                self.signal, title=self.chosen.title, simulated=self.chosen.simulated, small=True
            )
            if self.chosen.of.startswith("kept:"):
                with top, ui.element("div").classes("done"):
                    ui.button("Rename", on_click=self._rename).props("flat dense")
                    ui.button("Delete", on_click=self._remove).props("flat dense color=negative")

    @report_errors
    async def _rename(self) -> None:
        chosen = self.chosen
        title = None if chosen is None else await ask_title(chosen.title)
        if chosen is not None and title is not None:
            self.studio.shelf.rename(chosen.of.removeprefix("kept:"), title)
            self._listed.refresh()
            await self._take(chosen.of)

    @report_errors
    async def _remove(self) -> None:
        chosen = self.chosen
        if chosen is not None and await ask_removal(chosen.title):
            self.studio.shelf.remove(chosen.of.removeprefix("kept:"))
            self.chosen, self.kept["of"] = None, ""
            self._listed.refresh()
            self._signal.refresh()
