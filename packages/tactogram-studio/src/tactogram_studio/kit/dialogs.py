"""Dialogs: questions before something irreversible, and small forms."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from contextlib import contextmanager
from typing import Any

from nicegui import ui

from tactogram_studio.kit.cards import attribute, heading


async def confirm(question: str, action: str) -> bool:
    """Ask before something irreversible; return whether the user chose the button ``action``."""
    with ui.dialog().props('aria-label="Are you sure?"') as dialog, ui.card().classes("max-w-lg"):
        ui.label(question)
        with ui.row().classes("justify-end w-full"):
            ui.button("Cancel", on_click=lambda: dialog.submit(False)).props("outline autofocus")
            ui.button(action, color="negative", on_click=lambda: dialog.submit(True))
    confirmed = bool(await dialog)
    if dialog.is_deleted:  # the page was closed
        return False
    dialog.delete()
    return confirmed


@contextmanager
def form_dialog(title: str, action: str, done: Callable[[], Any], *, label: str = "") -> Iterator[ui.dialog]:
    """Open a dialog whose form is drawn inside; the button ``action`` calls ``done``, which closes it at its end.

    The dialog stays when the part of the page that it was opened from is drawn anew.
    """
    with (
        ui.context.client.content,
        ui.dialog(value=True).props(f'aria-label="{attribute(label or title)}"') as dialog,
        ui.card().classes("w-96 max-w-full"),
    ):
        heading(title)
        yield dialog
        with ui.row().classes("justify-end w-full"):
            ui.button("Cancel", on_click=dialog.close).props("flat")
            ui.button(action, on_click=done)
    dialog.on("hide", dialog.delete)


def ask_title(title: str, most: int, rename: Callable[[str], Any]) -> None:
    """Ask for another title of at most so many characters, and call ``rename`` with it, unless it stays."""

    async def done() -> None:
        if field.value != title:
            result = rename(str(field.value))
            if result is not None:
                await result
        dialog.close()

    with form_dialog("Rename", "Rename", done) as dialog:
        field = ui.input("Title", value=title).classes("w-full").props(f"autofocus maxlength={most}")
        field.on("keydown.enter", done)
