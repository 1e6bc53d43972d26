"""The page Edit: haptic effects on a timeline, from ready ones, results and files, to files that are felt."""

from __future__ import annotations

from collections.abc import Callable
from functools import partial
from typing import Any

from fastapi import Response
from fastapi.responses import FileResponse
from nicegui import app, ui

from tactogram.errors import DataError, ParameterError
from tactogram.rendering import effects, haptic_format, haptic_labels, to_one_axis
from tactogram_studio import kit
from tactogram_studio.context import Studio
from tactogram_studio.effects.editing import ready_track
from tactogram_studio.effects.editor import Editor
from tactogram_studio.effects.effect import (
    Effect,
    Track,
    effect_from_json,
    signal_of,
    track_of,
    track_of_signal,
)
from tactogram_studio.effects.files import (
    EFFECT,
    SavedEffects,
    WrittenFile,
    WrittenFiles,
    add_feel_routes,
    feel_path,
)
from tactogram_studio.pages.edit.timeline_view import Timeline
from tactogram_studio.server.listening import svg_qr_code
from tactogram_studio.signals.sound import NORMAL_PEAK, sound_of
from tactogram_studio.signals.view import SignalEntry, load_player, signal_cards
from tactogram_studio.workspace.shelf import SignalSources
from tactogram_study.participants.tickets import SessionKeys, load_keys

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
CHANGED_ELSEWHERE = "Another tab has changed this effect: its version is shown now. Undo brings yours back."
MOST_MIB = 32
Insert = Callable[[tuple[Track, ...], bool], None]
STATE = "edit"
"""Key of the page's settings in the browser's storage."""


class FilesCard:
    """Card that writes ``effect()`` and shows the last file; ``state`` holds the browser's format."""

    def __init__(
        self,
        studio: Studio,
        files: WrittenFiles,
        keys: SessionKeys,
        state: dict[str, Any],
        effect: Callable[[], Effect],
        kept: Callable[[], Any],
    ) -> None:
        self.studio, self.files, self.keys, self.state, self.effect = studio, files, keys, state, effect
        self._kept = kept
        self.file: WrittenFile | None = None
        self._written: Effect | None = None
        self._pattern: list[int] = []
        with kit.card("File", classes="w-full edit-card"):
            titles = haptic_labels()
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
        self._kept()
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


def draw_sources(
    studio: Studio,
    files: WrittenFiles,
    insert: Insert,
    *,
    of: str,
    audition: Callable[[WrittenFile], None],
) -> Callable[[], Any]:
    """Draw the cards, and return what lists the kept results anew; ``insert`` adds tracks, ``audition`` shows a file.

    ``of`` is the id of a signal to begin with, or empty.
    """
    sources = SignalSources(studio.workspace, studio.shelf)

    async def add_signal(identifier: str) -> None:
        tracks, simulated = await kit.in_background(tracks_from, studio, sources, identifier)
        insert(tracks, simulated)

    async def opened(name: str, data: bytes) -> None:
        file, content = await kit.in_background(files.upload, name, data)
        audition(file)  # also of one that is too long to be edited
        if content.events is None:
            track = await kit.in_background(track_of_signal, to_one_axis(content.signal)[0], file.title)
        else:
            track = await kit.in_background(track_of, content.events, file.title)
        insert((track,), file.simulated)

    with kit.card("Ready effects", classes="w-full edit-card"):
        kit.hint("Each becomes a track at the cursor.")
        with ui.element("div").classes("edit-ready"):
            for name, ready in effects().items():
                button = ui.button(ready.title, on_click=partial(insert, (ready_track(name),), False))
                button.props("outline dense").tooltip(ready.about)
    with kit.card("Results and files", classes="w-full edit-card"):
        kept = ui.refreshable(lambda: kit.signal_choice(sources, "kept", add_signal))
        kept()
        kit.file_field("A haptic file: AHAP, .haptic, HJIF, JSON", opened, most_mib=MOST_MIB)
    if of:
        ui.timer(0.05, partial(add_signal, of), once=True)
    return kept.refresh


def tracks_from(studio: Studio, sources: SignalSources, identifier: str) -> tuple[tuple[Track, ...], bool]:
    """Return a signal of the workspace as tracks, those of a kept effect as they were, and whether it is simulated."""
    if identifier.startswith("kept:"):
        facts = studio.shelf.get(identifier.removeprefix("kept:")).facts
        if isinstance(text := facts.get(EFFECT), str):
            effect = effect_from_json(text, where="the kept result's effect")
            if not effect.tracks:
                raise DataError("the kept result's effect is empty")
            return effect.tracks, effect.simulated
    selected = sources.select(identifier)
    return (track_of_signal(selected.signal(), selected.title),), selected.simulated


def add(studio: Studio) -> None:
    """Register the page, its sound, its files and the phones' pages."""
    folder = studio.workspace.studio_folder
    saved, files = SavedEffects(folder / "effects"), WrittenFiles(folder / "effect-files")
    (folder / "state").mkdir(parents=True, exist_ok=True)
    keys = load_keys(folder / "state")
    add_feel_routes(files, keys)

    @app.get("/edit/sound/{identifier}.wav")
    def sound(identifier: str) -> Response:
        clip = sound_of(signal_of(saved.get(identifier)), gain=NORMAL_PEAK)
        headers = {"X-Gain": f"{clip.gain:.6g}", "X-Limited": f"{clip.limited:.6g}", "X-Own-Level": "0"}
        return Response(clip.wav, media_type="audio/wav", headers=headers)

    @app.get("/edit/file/{identifier}/{name}")
    def file(identifier: str, name: str) -> Response:
        written = files.get(identifier)
        if name != written.path.name:
            raise DataError(f"no file {name[:60]!r}")
        return FileResponse(written.path, media_type="application/octet-stream", filename=name)

    @kit.route("/edit")
    def show(effect: str = "", of: str = "") -> None:
        ui.add_head_html('<link rel="stylesheet" href="/static/edit.css">')
        load_player()
        with kit.page("Edit"):
            EditPage(studio, saved, files, keys, effect, of)
        ui.add_body_html('<script type="module" src="/static/edit.js"></script>')


class EditPage:
    """One browser tab with an effect, the last one by default; ``of`` names a signal to add, as on the page Send."""

    def __init__(
        self,
        studio: Studio,
        saved: SavedEffects,
        files: WrittenFiles,
        keys: SessionKeys,
        effect: str,
        of: str,
    ) -> None:
        self.studio, self.saved = studio, saved
        self.state: dict[str, Any] = app.storage.user.setdefault(STATE, {})
        self.id = effect or str(self.state.get("effect", ""))
        try:
            self.editor = Editor(saved.get(self.id) if self.id else Effect())
        except DataError as error:
            self.id, self.editor = "", Editor(Effect())
            if effect:
                kit.alert(str(error))
        self.editor.cursor = round(self.editor.effect.seconds, 2)
        self._changes, self._title, self._stored = 0, self.editor.effect.title, self.editor.effect
        if self.id:
            kit.keep_address("/edit", effect=self.id)
        self._effect_card()
        with ui.element("div").classes("edit"):
            with ui.column().classes("items-stretch gap-4"):
                kept = draw_sources(studio, files, self._insert, of=of, audition=self._audition)
            with ui.column().classes("items-stretch gap-4 edit-main"):
                self.timeline = Timeline(self.editor, self._changed, self._sound, self._follow)
                self.files = FilesCard(studio, files, keys, self.state, lambda: self.editor.effect, kept)

    @ui.refreshable_method
    def _effect_card(self) -> None:
        with kit.card(label="Effect"), ui.row().classes("items-center gap-4 w-full"):
            title = ui.input("Title", value=self.editor.effect.title)
            title.props("maxlength=120").classes("w-64")
            title.on("change", lambda: self._rename(str(title.value)))
            titles = self.saved.titles()
            if titles and (select := kit.option_choice(titles, "Saved effects", self._open, last=self.id)):
                select.classes("w-64", remove="w-full")
            ui.button("New", icon="add", on_click=lambda: self._open("")).props("flat dense")
            if self.id:
                ui.button("Delete", on_click=self._delete).props("flat dense color=negative")
            kit.mark_simulated(self.editor.effect.simulated)

    def _audition(self, file: WrittenFile) -> None:
        self.files.show(file)

    def _insert(self, tracks: tuple[Track, ...], simulated: bool) -> None:
        if not self.editor.effect.tracks and self.editor.effect.title == Effect().title:
            self.editor.effect = self.editor.effect.changed(title=tracks[0].title)
        self.timeline.do(lambda: self.editor.insert(tracks, simulated=simulated))

    def _rename(self, title: str) -> None:
        title = " ".join(title.split())
        if not title:
            raise ParameterError("an effect needs a title")
        self.timeline.do(
            lambda: self.editor.change(self.editor.effect.changed(title=title[:120]), step="title")
        )

    def _open(self, identifier: str) -> None:
        self.state["effect"] = identifier
        ui.navigate.to(f"/edit?effect={identifier}" if identifier else "/edit")

    async def _delete(self) -> None:
        if await kit.confirm(f"Delete {self.editor.effect.title}? This cannot be undone.", "Delete"):
            self.saved.remove(self.id)
            self._open("")

    def _changed(self) -> None:
        """Save the effect, as a new one the first time."""
        self._changes += 1
        new, title = not self.id, self._title
        if new:
            self.id = self.saved.add(self.editor.effect)
            self.state["effect"], self._stored = self.id, self.editor.effect
            kit.keep_address("/edit", effect=self.id)
        else:
            mine = self.editor.effect
            self._stored = self.saved.save(self.id, mine, before=self._stored)
            if self._stored != mine:
                self.editor.change(self._stored)
                ui.notify(CHANGED_ELSEWHERE, multi_line=True, timeout=12_000, close_button="Close")
        if new or title != self.editor.effect.title:
            self._effect_card.refresh()

    def _follow(self) -> None:
        """Take over what another tab has made of the effect; Undo brings this tab's back."""
        if self.id and (stored := self.saved.get(self.id)) != self._stored:
            self._stored = stored
            self.editor.change(stored)

    def _sound(self) -> str:
        """Return the address of the effect's sound, another after each change."""
        return f"/edit/sound/{self.id}.wav?n={self._changes}" if self.id else ""
