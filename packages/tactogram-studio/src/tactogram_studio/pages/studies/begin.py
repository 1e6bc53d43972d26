"""Dialog that begins a session of a study."""

from __future__ import annotations

from pathlib import Path

from nicegui import ui

from tactogram.recipe import parse_changes
from tactogram_studio.context import Studio
from tactogram_studio.layout import busy, heading, hint, in_background, report_errors
from tactogram_studio.pages.studies.catalogue import free_session_name, new_session_folder, split_commas
from tactogram_studio.pages.studies.experiment_view import address_of


def begin_dialog(studio: Studio, source: Path | str, *, title: str, name: str) -> None:
    """Ask for the session's folder, begin a session of a study file or shipped study, and open its page."""
    with (
        ui.dialog(value=True).props('aria-label="Begin a session"') as dialog,
        ui.card().classes("w-96 max-w-full"),
    ):
        heading(f"Begin a session: {title}")
        folder = ui.input("Name of the session's folder", value=free_session_name(studio.workspace, name))
        folder.classes("w-full")
        changes = ui.input("Changes (optional)").props('placeholder="design.repeats=2, seed=7"')
        changes.classes("w-full")
        hint("Answers are stored in this folder. The study cannot be changed once the session has begun.")

        async def begin() -> None:
            place = new_session_folder(studio.workspace, folder.value or "")
            values = parse_changes(split_commas(changes.value))
            with busy("beginning the session"):
                await in_background(studio.sessions.begin, source, place, changes=values)
            ui.navigate.to(address_of(place.as_posix()))

        with ui.row().classes("justify-end w-full"):
            ui.button("Cancel", on_click=dialog.close).props("flat")
            ui.button("Begin", on_click=report_errors(begin))
    dialog.on("hide", dialog.delete)
