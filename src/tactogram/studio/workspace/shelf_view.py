"""Questions that pages ask about kept results."""

from __future__ import annotations

from nicegui import ui

from tactogram.studio.workspace.shelf import LONGEST_TITLE


async def ask_title(title: str) -> str | None:
    """Ask for another title, and return it; None where it was left as it is."""
    with ui.dialog() as dialog, ui.card():
        ui.label("Rename").classes("h2")
        field = ui.input("Title", value=title).classes("w-80").props(f"autofocus maxlength={LONGEST_TITLE}")
        field.on("keydown.enter", lambda: dialog.submit(field.value))
        with ui.row():
            ui.button("Rename it", on_click=lambda: dialog.submit(field.value)).props("no-caps unelevated")
            ui.button("Leave it", on_click=lambda: dialog.submit(None)).props("no-caps flat")
    given = await dialog
    dialog.delete()
    return None if given is None or given == title else str(given)


async def ask_removal(title: str) -> bool:
    """Ask whether a kept result is to be deleted."""
    with ui.dialog() as dialog, ui.card():
        ui.label(f"Delete {title} from what is kept? This cannot be undone.")
        with ui.row():
            ui.button("Delete it", color="negative", on_click=lambda: dialog.submit(True)).props("no-caps")
            ui.button("Keep it", on_click=lambda: dialog.submit(False)).props("no-caps outline autofocus")
    yes = bool(await dialog)
    dialog.delete()
    return yes
