"""Start page: example surfaces, links to all pages, and a summary of the workspace."""

from __future__ import annotations

from pathlib import Path

from nicegui import ui

from tactogram_studio import kit
from tactogram_studio.context import Studio
from tactogram_studio.kit.files import RECEIVING_HEAD, drop_zone, receiving_status
from tactogram_studio.kit.tasks import draw_progress
from tactogram_studio.layout import PAGES
from tactogram_studio.pages.home.first_touch import draw_first_touch

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

    @kit.route("/")
    def show() -> None:
        @ui.refreshable
        def summary() -> None:
            _draw_summary(studio)

        ui.add_head_html(RECEIVING_HEAD)
        with kit.page("Studio"), drop_zone(whole_page=True):
            draw_first_touch(studio)
            if studio.starter.state != "ready" and not studio.workspace.finished_runs():
                draw_progress(studio.starter, ready=summary.refresh)
            with ui.element("div").classes("tiles"):
                for name, address in PAGES.items():
                    with kit.card(classes="whole"):
                        ui.link(name, address).classes("h2 whole-link")
                        ui.label(DESCRIPTIONS[name]).classes("quiet")
            summary()
            receiving_status(
                "Drop a folder or a zip of recordings anywhere on this page to import it, or a photograph to draw it."
            )


def _draw_summary(studio: Studio) -> None:
    contents: dict[str, tuple[list[Path], str]] = {
        "run": (studio.workspace.runs(), "/train"),
        "store": (studio.workspace.stores(), "/materials"),
        "study session": (studio.workspace.sessions(), "/studies"),
        "kept result": ([made.folder for made in studio.shelf.all()], "/send"),
    }
    with kit.card("In this workspace"):
        kit.hint(studio.workspace.display_path)
        with ui.row().classes("gap-6"):
            for name, (folders, address) in contents.items():
                ui.link(f"{len(folders)} {name}{'' if len(folders) == 1 else 's'}", address)
