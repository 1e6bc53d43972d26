"""Haptic files of the page Edit, written or uploaded and felt on a phone, and saved effects."""

from __future__ import annotations

import hmac
from contextlib import suppress
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from fastapi import Request, Response
from fastapi.responses import HTMLResponse, JSONResponse
from nicegui import app

from tactogram.errors import DataError, TactogramError
from tactogram.rendering import (
    DocumentHeader,
    HapticFile,
    events_of,
    file_name,
    haptic_format,
    read_haptic,
    to_one_axis,
    write_haptic,
)
from tactogram.signal import Signal
from tactogram.signal.io import write_text
from tactogram.text_files import read_json, read_text
from tactogram_studio import kit
from tactogram_studio.effects.effect import Effect, effect_from_json, mixed
from tactogram_studio.signals.sound import range_response, sound_of
from tactogram_studio.workspace.commands import stem_of
from tactogram_studio.workspace.folder import FACTS, DatedFolders
from tactogram_studio.workspace.uploads import check_upload
from tactogram_study.participants.tickets import SessionKeys

EFFECT_FILE = "effect.json"
EFFECT = "effect"
"""Fact of a kept result that holds the effect it was made of."""
MOST_FILES = 40
"""Older files are deleted."""
PATTERN = "vibration"
"""The format of what a browser does to a phone's motor."""
MARKUP = Path(__file__).parents[1] / "static" / "feel.html"
SEPARATOR = "~"
BROKEN_LINK = (
    "<!doctype html><html lang='en'><meta charset='utf-8'>"
    "<meta name='viewport' content='width=device-width, initial-scale=1'><title>tactogram</title>"
    "<p>This link does not work: the file was deleted. Write it again on the page Edit.</p></html>"
)


@dataclass(frozen=True)
class WrittenFile:
    """A haptic file in a folder named ``id``; ``told`` says what it keeps and loses, a sentence each."""

    id: str
    path: Path
    format: str
    title: str
    simulated: bool
    told: tuple[str, ...]

    def signal(self) -> Signal:
        """Return what the file encodes, as a signal of one axis."""
        return to_one_axis(read_haptic(self.path, format=self.format).signal)[0]

    def pattern(self) -> list[int]:
        """Return what `navigator.vibrate` can do of the file: on, off, on … in ms; of a pattern that is all."""
        if self.format == PATTERN:
            document = read_json(self.path)
            return list(document if isinstance(document, list) else document["pattern"])
        file = read_haptic(self.path, format=self.format)
        # Level is nothing to a motor that is on or off.
        events = file.events or events_of(to_one_axis(file.signal)[0])
        return list(haptic_format(PATTERN).encode(events, DocumentHeader())["pattern"])


@dataclass(frozen=True)
class WrittenFiles:
    """The files in ``folder``."""

    folder: Path

    @property
    def _folders(self) -> DatedFolders:
        return DatedFolders(self.folder)

    def write(self, effect: Effect, format: str) -> WrittenFile:
        """Write an effect; errors as of `mixed` and `write_haptic`, and no file then."""
        events = mixed(effect)
        stem = stem_of(effect.title, "effect")

        def write(part: Path) -> dict[str, Any]:
            path = part / file_name(stem, format)
            metadata = {"simulated": True} if effect.simulated else {}
            written = write_haptic(path, events, format=format, metadata=metadata)
            return {
                "file": path.name,
                "format": format,
                "title": effect.title,
                "simulated": effect.simulated,
                "told": _told(written),
            }

        return self.get(self._folders.add(write, most=MOST_FILES))

    def upload(self, name: str, data: bytes) -> tuple[WrittenFile, HapticFile]:
        """Store an uploaded haptic file, and return it with its content; `DataError` if it is not valid."""
        safe = check_upload(name, data, kind="haptic")
        read: list[HapticFile] = []

        def write(part: Path) -> dict[str, Any]:
            (part / safe).write_bytes(data)
            try:
                file = read_haptic(part / safe)
            except DataError as error:
                raise DataError(error.message.replace(f"{part}/", "")) from None
            read.append(file)
            return {
                "file": safe,
                "format": file.facts["format"],
                "title": Path(safe).stem,
                "simulated": bool(file.metadata.get("simulated")),
                "told": [],
            }

        return self.get(self._folders.add(write, most=MOST_FILES)), read[0]

    def get(self, identifier: str) -> WrittenFile:
        """Return a file by its id; `DataError` if there is none."""
        folder = self._folders.get(identifier, "file", " to make room for newer ones; write it again")
        facts = read_json(folder / FACTS)
        try:
            return WrittenFile(
                identifier,
                folder / Path(facts["file"]).name,
                str(facts["format"]),
                str(facts["title"]),
                bool(facts["simulated"]),
                tuple(map(str, facts["told"])),
            )
        except (KeyError, TypeError):
            raise DataError(folder / FACTS, "damaged; write the file again") from None


def _told(written: dict[str, Any]) -> list[str]:
    """Return what a file keeps and loses, the verdict, and how it was scaled."""
    told = [*written["told"], f"Verdict: {written['verdict']}."]
    if written["full_scale"] != 1:
        told.append(
            f"The strongest moment is {written['full_scale']:.3g}, more than the file's 1: everything is written "
            f"{1 / written['full_scale']:.2f} times as strong. Lower a gain to decide yourself."
        )
    return told


@dataclass(frozen=True)
class SavedEffects:
    """The effects in ``folder``."""

    folder: Path

    @property
    def _folders(self) -> DatedFolders:
        return DatedFolders(self.folder)

    def add(self, effect: Effect) -> str:
        """Save a new effect and return its id."""
        return self._folders.add(lambda part: write_text(part / EFFECT_FILE, effect.to_json()))

    def save(self, identifier: str, effect: Effect, *, before: Effect) -> Effect:
        """Replace an effect and return what is stored then; `DataError` if it was deleted.

        Nothing is replaced if the stored effect is no longer the one ``before``: another tab has changed it.
        """
        stored = self.get(identifier)
        if stored != before:
            return stored
        write_text(self._folder(identifier) / EFFECT_FILE, effect.to_json())
        return effect

    def get(self, identifier: str) -> Effect:
        """Return an effect; `DataError` if there is none, or its file is damaged."""
        path = self._folder(identifier) / EFFECT_FILE
        return effect_from_json(read_text(path), where=str(path))

    def titles(self) -> dict[str, str]:
        """Return the titles of the readable effects by id, newest first."""
        titles = {}
        for identifier in self._folders.names():
            with suppress(DataError):
                titles[identifier] = self.get(identifier).title
        return titles

    def remove(self, identifier: str) -> None:
        """Delete an effect."""
        self._folder(identifier)
        self._folders.remove(identifier)

    def _folder(self, identifier: str) -> Path:
        return self._folders.get(identifier, "effect", ": choose another, or begin a new one")


def feel_path(file: WrittenFile, keys: SessionKeys) -> str:
    """Return the path of a file's page for phones."""
    return f"/feel/{file.id}{SEPARATOR}{keys.ticket(file.id)}"


def file_by_ticket(text: str, files: WrittenFiles, keys: SessionKeys) -> WrittenFile:
    """Return the file that a ticket leads to; `DataError` if there is none, whatever the reason."""
    identifier, _, ticket = text.partition(SEPARATOR)
    if not hmac.compare_digest(ticket.encode(), keys.ticket(identifier).encode()):
        raise DataError("no such file")
    return files.get(identifier)


def add_feel_routes(files: WrittenFiles, keys: SessionKeys) -> None:
    """Register the page for phones, its facts and its sound."""

    @app.get("/feel/{ticket}")
    def page(ticket: str) -> Response:
        try:
            file_by_ticket(ticket, files, keys)
        except TactogramError:
            return HTMLResponse(BROKEN_LINK, 404)
        return HTMLResponse(MARKUP.read_text(encoding="utf-8"))

    @app.get("/feel/{ticket}/file")
    async def facts(ticket: str) -> Response:
        def made() -> dict[str, Any]:
            file = file_by_ticket(ticket, files, keys)
            return {
                "title": file.title,
                "file": file.path.name,
                "format": haptic_format(file.format).title,
                "simulated": file.simulated,
                "pattern": file.pattern(),
            }

        try:
            return JSONResponse(await kit.in_background(made))
        except TactogramError:
            return JSONResponse({"error": "no such file"}, 404)

    @app.get("/feel/{ticket}/sound.wav")
    async def sound(ticket: str, request: Request) -> Response:
        try:
            file = file_by_ticket(ticket, files, keys)
            clip = await kit.in_background(lambda: sound_of(file.signal()))
        except TactogramError:
            return JSONResponse({"error": "no such file"}, 404)
        return range_response(clip.wav, request.headers.get("range"), media_type="audio/wav", headers={})
