"""Card of the effect's files: a download with what it loses, how it plays, and a QR code for a phone."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

from nicegui import ui

from tactogram.rendering import haptic_format, haptic_formats
from tactogram_studio import kit
from tactogram_studio.context import Studio
from tactogram_studio.effects.effect import Effect, signal_of
from tactogram_studio.pages.edit.exports import EFFECT, WrittenFile, WrittenFiles, feel_path
from tactogram_studio.server.listening import svg_qr_code
from tactogram_studio.signals.view import SignalEntry, signal_cards
from tactogram_study.participants.tickets import SessionKeys

MOST_SHOWN = 24
"""Entries of a pattern that are written out."""
VIBRATES = (
    "A phone's browser can only switch the motor on and off, here for {pattern} ms; strength and frequency are in the "
    "sound."
)
NOT_REACHABLE = (
    "To feel it on a phone, stop the studio and start it for the local network: tactogram studio --host 0.0.0.0. A QR "
    "code appears here then."
)


class FilesCard:
    """Card that writes ``effect()`` and shows the last file; ``state`` holds the browser's format."""

    def __init__(
        self,
        studio: Studio,
        files: WrittenFiles,
        keys: SessionKeys,
        state: dict[str, Any],
        effect: Callable[[], Effect],
    ) -> None:
        self.studio, self.files, self.keys, self.state, self.effect = studio, files, keys, state, effect
        self.file: WrittenFile | None = None
        self._written: Effect | None = None
        self._pattern: list[int] = []
        with kit.card("File", classes="w-full edit-card"):
            titles = {name: f"{kind.title} ({kind.suffix})" for name, kind in haptic_formats().items()}
            with ui.row().classes("items-center gap-4"):
                last = str(state.get("format", "ahap"))
                self._format = ui.select(titles, label="Format", value=last if last in titles else "ahap")
                self._format.classes("w-72")
                self._button = ui.button("Download", icon="download", on_click=self._write)
                ui.button("Keep", icon="push_pin", on_click=self._keep).props("outline")
            self._result()

    def show(self, file: WrittenFile) -> None:
        """Show how a file plays that was not written here."""
        self._written = None
        self._show(file, file.pattern())

    def _show(self, file: WrittenFile, pattern: list[int]) -> None:
        self.file, self._pattern = file, pattern
        self._result.refresh()

    async def _write(self) -> None:
        effect, name = self.effect(), str(self._format.value)
        with kit.busy("writing and reading back", button=self._button):
            file = await kit.in_background(self.files.write, effect, name)
            pattern = await kit.in_background(file.pattern)
        self.state["format"], self._written = name, effect
        self._show(file, pattern)
        ui.download(f"/edit/file/{file.id}/{file.path.name}", file.path.name)

    async def _keep(self) -> None:
        effect = self.effect()
        signal = await kit.in_background(signal_of, effect)
        facts = {"simulated": effect.simulated, EFFECT: effect.to_json()}
        kept = await kit.in_background(
            lambda: self.studio.shelf.keep(signal, title=effect.title, facts=facts)
        )
        ui.notify(f"{kept.title} is kept: it is on the pages Send and Make, and opens here with its tracks.")

    @ui.refreshable_method
    def _result(self) -> None:
        file = self.file
        if file is None:
            kit.hint("What the file keeps and loses, and how it plays, will appear here.")
            return
        with ui.row().classes("items-center gap-2"):
            ui.link(file.path.name, f"/edit/file/{file.id}/{file.path.name}").props("download")
            kit.hint(haptic_format(file.format).title)
            kit.mark_simulated(file.simulated, "from a simulated signal")
        for sentence in file.told:
            ui.label(sentence)
        entries = [SignalEntry(file.signal(), "As the file plays it", file.simulated, key="2")]
        if (drawn := self._written) is not None:
            entries.insert(0, SignalEntry(signal_of(drawn), "As drawn", drawn.simulated, key="1"))
        with ui.element("div").classes("edit-plays"):
            signal_cards(entries, same_gain=True, small=True)
        self._phone(file)

    def _phone(self, file: WrittenFile) -> None:
        ui.label("On a phone").classes("font-bold mt-2").props('role="heading" aria-level="3"')
        shown = ", ".join(map(str, self._pattern[:MOST_SHOWN]))
        more = " …" if len(self._pattern) > MOST_SHOWN else ""
        kit.hint(VIBRATES.format(pattern=shown + more))
        path = feel_path(file, self.keys)
        if not self.studio.roots:
            kit.hint(NOT_REACHABLE)
            ui.link("Open the phone's page here", path, new_tab=True)
            return
        address = f"{self.studio.roots[0]}{path}"
        image = ui.element("img").classes("edit-qr")
        image.props.update(src=svg_qr_code(address), alt="QR code: the phone's page of this file")
        ui.link(address, address, new_tab=True).classes("break-all")
        kit.hint(
            "The address leads to this file only, without the studio's token, until 40 newer files are written."
        )
