"""Progress of the example surfaces of a workspace without runs."""

from __future__ import annotations

from collections.abc import Callable

from nicegui import ui

from tactogram_studio.kit.cards import card, heading
from tactogram_studio.workspace.starter_data import StarterData


def draw_progress(starter: StarterData, *, ready: Callable[[], object]) -> None:
    """Draw the progress of the example surfaces until they are ready, and call ``ready`` then."""

    @ui.refreshable
    def state() -> None:
        with card(live=True):
            if starter.state == "ready":
                heading("Nine simulated surfaces are ready to explore.")
                with ui.row():
                    ui.button("Generate signals", on_click=lambda: ui.navigate.to("/make"))
                    ui.button("Touch them", on_click=lambda: ui.navigate.to("/touch")).props("outline")
            elif starter.state == "failed":
                ui.label(f"{starter.line}.").classes("text-negative")
                ui.button("Try again", on_click=starter.make)
            else:
                with ui.row().classes("items-center"):
                    ui.spinner()
                    ui.label(f"Preparing example surfaces (simulated): {starter.line}")

    state()
    drawn = [starter.state, starter.line]

    def update() -> None:
        now = [starter.state, starter.line]
        if now != drawn:
            drawn[:] = now
            state.refresh()
            if starter.state == "ready":
                ready()

    ui.timer(0.5, update)
