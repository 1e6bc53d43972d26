"""Pages on which a phone plays a haptic file: by its motor and as sound, authorised by the address alone.

The address holds a ticket, a keyed hash of the file's id (`participants.tickets`): it leads to this file and to nothing
else of the studio, until the file is deleted.
"""

from __future__ import annotations

import hmac
from pathlib import Path
from typing import Any

from fastapi import Request, Response
from fastapi.responses import HTMLResponse, JSONResponse
from nicegui import app

from tactogram.errors import DataError, TactogramError
from tactogram.rendering import haptic_format
from tactogram_studio import kit
from tactogram_studio.pages.edit.exports import WrittenFile, WrittenFiles
from tactogram_studio.signals.sound import range_response, sound_of
from tactogram_study.participants.tickets import SessionKeys

MARKUP = Path(__file__).parents[2] / "static" / "feel.html"
SEPARATOR = "~"
BROKEN_LINK = (
    "<!doctype html><html lang='en'><meta charset='utf-8'>"
    "<meta name='viewport' content='width=device-width, initial-scale=1'><title>tactogram</title>"
    "<p>This link does not work: the file was deleted. Write it again on the page Edit.</p></html>"
)


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
            return Response(status_code=404)
        return range_response(clip.wav, request.headers.get("range"), media_type="audio/wav", headers={})
