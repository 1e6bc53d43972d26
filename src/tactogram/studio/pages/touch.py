"""The page Touch."""

from __future__ import annotations

from nicegui import ui

from tactogram.studio.layout import page
from tactogram.studio.studio import Studio


def add(studio: Studio) -> None:
    """Register the page."""

    @ui.page("/touch")
    def show() -> None:
        with page("Touch"):
            ui.label("To come.")
