"""The page Make."""

from __future__ import annotations

from nicegui import ui

from tactogram.studio.layout import page
from tactogram.studio.studio import Studio


def add(studio: Studio) -> None:
    """Register the page."""

    @ui.page("/make")
    def show() -> None:
        with page("Make"):
            ui.label("To come.")
