"""The first page: something to play with at once, what lies in the workspace, and where to go."""

from __future__ import annotations

from pathlib import Path

from nicegui import ui

from tactogram.studio.context import Studio
from tactogram.studio.layout import page

ERRANDS = (
    ("Make", "/make", "Generate touch from materials, photographs or words; see, hear and compare it."),
    ("Touch", "/touch", "Move a finger, pen or mouse over a surface and feel it through the headphone jack."),
    ("Materials", "/materials", "Look through recordings; drop a new one and find out what it is like."),
    ("Train", "/train", "Train a model on your recordings, watch it, stop it, go on with it."),
    ("Send", "/send", "Turn a result into the drive of a display or a file that an engine plays."),
    ("Live", "/live", "See a sensor's traces, what it is taken for, and record by a plan."),
    ("Studies", "/studies", "Ask people whether they feel the difference, and find out what was shown."),
    ("Reports", "/reports", "Read the reports of runs, and published figures beside ours."),
)


def add(studio: Studio) -> None:
    """Register ``/`` and begin to make what can be played with where no run is."""
    if not studio.workspace.finished_runs():
        studio.first.make()

    @ui.page("/")
    def show() -> None:
        with page("Studio"):
            _first_voices(studio)
            with ui.element("div").classes("tiles"):
                for name, address, what in ERRANDS:
                    with ui.element("section").classes("card"):
                        ui.link(name, address).classes("h2")
                        ui.label(what).classes("quiet")
            _lies_here(studio)


def _first_voices(studio: Studio) -> None:
    """Say how far the first voices are, as long as they are not there."""
    if studio.first.state == "there" or studio.workspace.finished_runs():
        return

    @ui.refreshable
    def state() -> None:
        with ui.element("section").classes("card w-full").props('aria-live="polite"'):
            if studio.first.state == "there":
                ui.label("Nine simulated surfaces are ready to be played with.").classes("h2")
                with ui.row():
                    ui.button("Make something of them", on_click=lambda: ui.navigate.to("/make"))
                    ui.button("Touch them", on_click=lambda: ui.navigate.to("/touch")).props("outline")
            elif studio.first.state == "failed":
                ui.label(f"{studio.first.line}.").classes("text-negative")
                ui.button("Try again", on_click=studio.first.make)
            else:
                with ui.row().classes("items-center"):
                    ui.spinner()
                    ui.label("Making something to play with, from simulated surfaces: " + studio.first.line)

    state()
    seen = [studio.first.state, studio.first.line]

    def look() -> None:
        now = [studio.first.state, studio.first.line]
        if now != seen:
            seen[:] = now
            state.refresh()

    ui.timer(0.5, look)


def _lies_here(studio: Studio) -> None:
    """List what the workspace holds."""
    held = {
        "run": (studio.workspace.runs(), "/train"),
        "data set": (studio.workspace.stores(), "/materials"),
        "study session": (studio.workspace.sessions(), "/studies"),
        "kept result": ([made.folder for made in studio.shelf.all()], "/send"),
    }
    with ui.element("section").classes("card w-full"):
        ui.label("In this workspace").classes("h2")
        ui.label(studio.workspace.shown).classes("quiet small")
        with ui.row().classes("gap-6"):
            for name, (found, address) in held.items():
                ui.link(_counted(found, name), address)


def _counted(found: list[Path], name: str) -> str:
    return f"{len(found)} {name}{'' if len(found) == 1 else 's'}"
