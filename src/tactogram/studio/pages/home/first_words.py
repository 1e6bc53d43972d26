"""A field on the start page: a surface in words, made by the model that comes trained."""

from __future__ import annotations

from urllib.parse import quote

from nicegui import app, ui

from tactogram.studio.context import Studio
from tactogram.studio.layout import busy, heading, hint, in_background, report_errors
from tactogram.studio.pages.make.runs import RunCatalogue
from tactogram.studio.pages.make.state import MakePageState

SHIPPED = "texture_flow"
PHOTOGRAPHS = "photographs.json"
"""File of a run that was trained with photographs."""


def draw_first_words(studio: Studio) -> None:
    """Draw the field; its text becomes materials of the page Make, which generates them at once."""
    runs = RunCatalogue(studio.workspace)
    materials = runs.get(SHIPPED).form.materials

    async def make() -> None:
        text = (field.value or "").strip()
        if not text:
            field.run_method("focus")
            return
        with busy(f"Making {text} …"):
            weights = await in_background(_weights_of, text, materials)
        state = MakePageState(studio.workspace, studio.shelf, runs, app.storage.user.setdefault("make", {}))
        state.choose(SHIPPED)
        state.set(weights=weights)
        state.commit()
        ui.navigate.to("/make?generate=true")

    with ui.element("section").classes("card w-full"):
        heading("What should it feel like?")
        with ui.row().classes("w-full items-center no-wrap my-2"):
            field = ui.input(
                "A surface, in English",
                placeholder="corduroy, cheese grater, silk …",
                autocomplete=list(materials),
            )
            field.classes("grow").props('outlined dense data-first="1"').on(
                "keydown.enter", report_errors(make)
            )
            ui.button("Make it", on_click=report_errors(make)).props("no-caps unelevated")
        hint(f"One of {len(materials)} simulated everyday materials, or a mix of those most like your words.")
        if seeing := next((run for run in runs.finished() if (run.folder / PHOTOGRAPHS).is_file()), None):
            ui.link(f"Make it of a photograph, with {seeing.name}", f"/make?run={quote(seeing.name)}")


def _weights_of(text: str, materials: tuple[str, ...]) -> dict[str, float]:
    if text in materials:
        return {text: 1.0}
    from tactogram.workflows.generation.descriptions import materials_like

    return materials_like(text, materials)
