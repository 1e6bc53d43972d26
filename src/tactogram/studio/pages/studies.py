"""The page Studies."""

from __future__ import annotations

from nicegui import ui

from tactogram.studio.layout import page
from tactogram.studio.studio import Studio


def add(studio: Studio) -> None:
    """Register the page."""

    @ui.page("/studies")
    def show() -> None:
        with page("Studies"):
            ui.label("To come.")
