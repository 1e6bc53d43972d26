"""Start page: example surfaces, links to all pages, and a summary of the workspace."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

from nicegui import ui

from tactogram_studio.context import Studio
from tactogram_studio.layout import PAGES, heading, hint, page, route
from tactogram_studio.pages.home.first_touch import draw_first_touch
from tactogram_studio.pages.materials import receiving

DESCRIPTIONS = {
    "Make": "Generate touch signals from materials, photographs or words; view, play and compare them.",
    "Touch": "Stroke a surface with a finger, pen or mouse and feel it through the headphone jack.",
    "Edit": "Draw a haptic effect on a timeline, feel it on a phone, and download it as AHAP, .haptic and others.",
    "Materials": "Browse recordings; import your own, or upload one and see which materials it resembles.",
    "Train": "Train a model on your recordings; monitor, stop and resume the training.",
    "Send": "Convert a result to the drive of a display, or to a file for a game engine.",
    "Live": "View a sensor's signal, classify it while you measure, and record by a plan.",
    "Studies": "Test with participants whether differences can be felt, and analyse their answers.",
    "Reports": "Read the reports of runs, and compare published figures with ours.",
}


def add(studio: Studio) -> None:
    """Register ``/``, and prepare the example surfaces if the workspace has no finished run."""
    if not studio.workspace.finished_runs():
        studio.starter.make()

    @route("/")
    def show() -> None:
        @ui.refreshable
        def summary() -> None:
            _draw_summary(studio)

        ui.add_head_html(receiving.HEAD)
        with page("Studio"), receiving.drop_zone(whole_page=True):
            draw_first_touch(studio)
            _draw_starter(studio, ready=summary.refresh)
            with ui.element("div").classes("tiles"):
                for name, address in PAGES.items():
                    with ui.element("section").classes("card whole"):
                        ui.link(name, address).classes("h2 whole-link")
                        ui.label(DESCRIPTIONS[name]).classes("quiet")
            summary()
            receiving.draw_status(
                "Drop a folder or a zip of recordings anywhere on this page to import it, or a photograph to draw it."
            )


def _draw_starter(studio: Studio, *, ready: Callable[[], object]) -> None:
    """Draw the progress of the example surfaces until they are ready, and call ``ready`` then."""
    starter = studio.starter
    if starter.state == "ready" or studio.workspace.finished_runs():
        return

    @ui.refreshable
    def state() -> None:
        with ui.element("section").classes("card w-full").props('aria-live="polite"'):
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


def _draw_summary(studio: Studio) -> None:
    contents: dict[str, tuple[list[Path], str]] = {
        "run": (studio.workspace.runs(), "/train"),
        "store": (studio.workspace.stores(), "/materials"),
        "study session": (studio.workspace.sessions(), "/studies"),
        "kept result": ([made.folder for made in studio.shelf.all()], "/send"),
    }
    with ui.element("section").classes("card w-full"):
        heading("In this workspace")
        hint(studio.workspace.display_path)
        with ui.row().classes("gap-6"):
            for name, (folders, address) in contents.items():
                ui.link(f"{len(folders)} {name}{'' if len(folders) == 1 else 's'}", address)
