"""Dialogs of pages about kept results."""

from __future__ import annotations

from nicegui import ui

from tactogram_studio.layout import heading
from tactogram_studio.workspace.shelf import LONGEST_TITLE


async def ask_title(title: str) -> str | None:
    """Return a new title from a dialog; None if it stays."""
    with ui.dialog() as dialog, ui.card():
        heading("Rename")
        field = ui.input("Title", value=title).classes("w-80").props(f"autofocus maxlength={LONGEST_TITLE}")
        field.on("keydown.enter", lambda: dialog.submit(field.value))
        with ui.row():
            ui.button("Rename", on_click=lambda: dialog.submit(field.value)).props("no-caps unelevated")
            ui.button("Cancel", on_click=lambda: dialog.submit(None)).props("no-caps flat")
    answer = await dialog
    dialog.delete()
    return None if answer is None or answer == title else str(answer)
