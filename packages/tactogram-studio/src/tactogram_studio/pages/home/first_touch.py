"""A card on the start page: a surface in words, made by the model that comes trained, or a photograph, drawn."""

from __future__ import annotations

from urllib.parse import quote

from nicegui import app, ui

from tactogram.rendering import SPEED_MM_S, WIDTH_MM, photo_to_touch
from tactogram.signal.io import decode_image_metadata
from tactogram_studio import kit
from tactogram_studio.context import Studio
from tactogram_studio.pages.make.form import GenerationRequest
from tactogram_studio.pages.make.runs import GeneratingRuns
from tactogram_studio.pages.make.state import MakePageState
from tactogram_studio.workspace.shelf import KeptResult
from tactogram_studio.workspace.uploads import read_uploaded_image

SHIPPED = "texture_flow"
PHOTOGRAPHS = "photographs.json"
"""File of a run that was trained with photographs."""


def draw_first_touch(studio: Studio) -> None:
    """Draw the card: a text becomes materials of the page Make, a photograph a kept result on the page Send."""
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
        state.set(weights=described.weights, text=described.text, photo="", vibration="", words={})
        state.commit()
        ui.navigate.to("/make?generate=true")

    async def draw(name: str, data: bytes) -> None:
        width_mm = width.checked(least=1, most=10_000) or WIDTH_MM
        with kit.busy(f"Drawing {name} …"):
            kept = await kit.in_background(_drawn, studio, name, data, width_mm)
        ui.navigate.to(f"/send?of={quote(f'kept:{kept.id}')}&tab=file")

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


def _drawn(studio: Studio, name: str, data: bytes, width_mm: float) -> KeptResult:
    signal = photo_to_touch(read_uploaded_image(name, data, width_mm=width_mm))
    simulated = bool(decode_image_metadata(data, name=name).get("simulated"))
    facts = {"drawn_from": name, "width_mm": width_mm, "speed_mm_s": SPEED_MM_S, "simulated": simulated}
    return studio.shelf.keep(signal, title=f"{name}, drawn", facts=facts)
