"""Start page: example surfaces, links to all pages, and a summary of the workspace."""

from __future__ import annotations

from pathlib import Path
from urllib.parse import quote

from nicegui import app, ui

from tactogram.rendering import WIDTH_MM
from tactogram_studio import kit
from tactogram_studio.context import Studio
from tactogram_studio.generation.form import GenerationRequest
from tactogram_studio.generation.runs import GeneratingRuns
from tactogram_studio.generation.state import MakePageState
from tactogram_studio.kit.fields import RECEIVING_HEAD, drop_zone, receiving_status
from tactogram_studio.kit.tasks import draw_progress
from tactogram_studio.layout import PAGES
from tactogram_studio.touch.photographs import keep_drawn

SHIPPED = "texture_flow"
PHOTOGRAPHS = "photographs.json"
"""File of a run that was trained with photographs."""
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


def draw_first_touch(studio: Studio) -> None:
    """Draw the card: a text becomes materials of the page Make, a photograph a kept result on the page Touch."""
    runs = GeneratingRuns(studio.workspace)
    materials = runs.get(SHIPPED).kind.materials

    async def make() -> None:
        text = (field.value or "").strip()
        if not text:
            field.run_method("focus")
            return
        with kit.busy(f"Making {text} …"):
            described = await kit.in_background(runs.described, GenerationRequest(SHIPPED), text)
        state = MakePageState(studio.workspace, studio.shelf, runs, app.storage.user.setdefault("make", {}))
        state.choose(SHIPPED)
        described_by = dict.fromkeys(("material", "text", "image", "vibration", "words"))
        state.set(**{**described_by, **described.values})
        state.commit()
        ui.navigate.to("/make?generate=true")

    async def draw(name: str, data: bytes) -> None:
        width_mm = width.checked(least=1, most=10_000) or WIDTH_MM
        with kit.busy(f"Drawing {name} …"):
            kept = await kit.in_background(keep_drawn, studio.shelf, name, data, width_mm=width_mm)
        ui.navigate.to(f"/touch?where=kept&of={kept.id}")

    with kit.card("What should it feel like?"):
        with ui.row().classes("w-full items-center no-wrap my-2"):
            field = ui.input(
                "A surface, in English",
                placeholder="corduroy, cheese grater, silk …",
                autocomplete=list(materials),
            )
            field.classes("grow").props('outlined dense data-first="1"').on("keydown.enter", make)
            ui.button("Make it", on_click=make).props("unelevated")
        kit.hint(
            f"One of {len(materials)} simulated everyday materials, or a mix of those most like your words."
        )
        with ui.row().classes("w-full items-center mt-4 mb-2"):
            refused = "This file is not a picture."
            kit.file_button(
                "Draw a photograph", draw, accept="image/*", refused=refused, marks="data-photograph"
            )
            width = kit.NumberField("Width that it shows, mm", value=WIDTH_MM)
            width.classes("w-48").props("outlined dense")
        kit.hint(
            "Dropped here or chosen. Its brightness becomes a relief that a finger crosses: a design, no prediction of "
            "how the material feels."
        )
        if seeing := next((run for run in runs.finished() if (run.folder / PHOTOGRAPHS).is_file()), None):
            ui.link(f"Predict it from a photograph, with {seeing.name}", f"/make?run={quote(seeing.name)}")


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
        "kept result": ([result.folder for result in studio.shelf.all()], "/send"),
    }
    with kit.card("In this workspace"):
        kit.hint(studio.workspace.display_path)
        with ui.row().classes("gap-6"):
            for name, (folders, address) in contents.items():
                ui.link(f"{len(folders)} {name}{'' if len(folders) == 1 else 's'}", address)
