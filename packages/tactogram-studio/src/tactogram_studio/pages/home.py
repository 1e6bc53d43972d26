"""Start page: a field for words, examples to hear, the first steps by what one wants to do, and the workspace."""

from __future__ import annotations

from functools import partial
from urllib.parse import quote

from nicegui import app, ui

from tactogram.rendering import WIDTH_MM, effects
from tactogram_studio import kit
from tactogram_studio.context import Studio
from tactogram_studio.generation.form import GenerationRequest
from tactogram_studio.generation.runs import GeneratingRuns
from tactogram_studio.generation.state import PRESSED, MakePageState
from tactogram_studio.kit.fields import RECEIVING_HEAD, drop_zone, receiving_status
from tactogram_studio.kit.tasks import draw_progress
from tactogram_studio.pages.home_examples import EXAMPLES, add_route, draw_examples
from tactogram_studio.pages.make.form_view import offer_effect, open_effect, understood_of
from tactogram_studio.touch.photographs import keep_drawn

SHIPPED = "texture_flow"
PHOTOGRAPHS = "photographs.json"
"""File of a run that was trained with photographs."""
DOORS = {
    "Design an effect": (
        "/edit",
        "Draw it on a timeline, feel it on a phone, and download it for your engine.",
    ),
    "Use my recordings": (
        "/materials",
        "Import them, train a model that names or generates them, and compare.",
    ),
    "Run a study": ("/studies", "Ask people what they feel, on tablets, and analyse their answers."),
    "Connect a device": ("/send?tab=device", "Play on an actuator or a phone; [Live](/live) reads a sensor."),
}
"""Addresses and texts of the first steps, by what one wants to do."""


def draw_first_touch(studio: Studio) -> None:
    """Draw the card: a text becomes materials of the page Make or an effect of Edit, a photograph one of Touch."""
    runs = GeneratingRuns(studio.workspace)
    materials = runs.get(SHIPPED).kind.materials

    worded = partial(kit.in_fields, labels={"text": "The words"})

    async def make() -> None:
        text = (field.value or "").strip()
        if not text:
            field.run_method("focus")
            return
        offer.clear()
        with kit.busy(f"Making {text} …"), kit.refusals(refusal, worded):
            if not (understood := understood_of(text, materials)).effect:
                described = await kit.in_background(runs.described, GenerationRequest(SHIPPED), text)
        if refusal.text:
            return
        if understood.effect and not understood.unknown:
            open_effect(studio.workspace, understood.effect, text)
            return
        if understood.effect:
            with offer:
                offer_effect(studio.workspace, understood, text)
            return
        state = MakePageState(studio.workspace, studio.shelf, runs, app.storage.user.setdefault("make", {}))
        state.choose(SHIPPED)
        described_by = dict.fromkeys(("material", "text", "image", "vibration", "words"))
        state.set(**{**described_by, **described.values}, typed=text)
        state.commit()
        state.storage[PRESSED] = True
        ui.navigate.to("/make")

    async def draw(name: str, data: bytes) -> None:
        width_mm = width.checked(least=1, most=10_000) or WIDTH_MM
        with kit.busy(f"Drawing {name} …"):
            kept = await kit.in_background(keep_drawn, studio.shelf, name, data, width_mm=width_mm)
        ui.navigate.to(f"/touch?where=kept&of={kept.id}")

    with kit.card("", label="What should it feel like?", classes="w-full first"):
        with ui.row().classes("w-full items-center no-wrap"):
            field = ui.input(
                "A surface or an effect, in English",
                placeholder="corduroy, cheese grater, heartbeat …",
                autocomplete=[*materials, *effects()],
            )
            field.classes("grow").props('data-first="1"', remove="dense").on("keydown.enter", make)
            ui.button("Make it", on_click=make).props("no-wrap").classes("first-button")
        refusal = kit.alert()
        offer = ui.row().classes("items-center")
        kit.hint(
            f"{len(materials)} simulated everyday materials, mixes of them, and {len(effects())} ready effects, "
            "such as click, engine or rain."
        )
        with ui.row().classes("w-full items-center gap-3 mt-3"):
            refused = "This file is not a picture."
            photographs = kit.file_button(
                "Draw a photograph", draw, accept="image/*", refused=refused, marks="data-photograph"
            )
            width = kit.NumberField("Width that it shows, mm", value=WIDTH_MM)
            width.classes("w-40")
            hint = kit.hint(
                "Its brightness becomes a relief: a design, no prediction of how the material feels."
            )
            hint.classes("grow")
        if seeing := next((run for run in runs.finished() if (run.folder / PHOTOGRAPHS).is_file()), None):
            ui.link(f"Predict it from a photograph, with {seeing.name}", f"/make?run={quote(seeing.name)}")

    def edit(name: str) -> None:
        open_effect(studio.workspace, name, EXAMPLES[name].title)

    def button(text: str) -> ui.button:
        return ui.button(text).props("flat dense")

    pick = f"() => getElement({photographs.id}).$refs.qRef.pickFiles()"
    draw_examples(
        {
            "sandpaper": lambda: button("Stroke surfaces").on_click(lambda: ui.navigate.to("/touch")),
            "heartbeat": lambda: button("Edit it").on_click(lambda: edit("heartbeat")),
            "click": lambda: button("Edit it").on_click(lambda: edit("click")),
            "photograph": lambda: button("Use your own").on("click", js_handler=pick),
        }
    )


def add(studio: Studio) -> None:
    """Register ``/``, and prepare the example surfaces if the workspace has no finished run."""
    add_route()
    if not studio.workspace.finished_runs():
        studio.starter.make()

    @kit.route("/")
    def show() -> None:
        @ui.refreshable
        def summary() -> None:
            _draw_summary(studio)

        ui.add_head_html(RECEIVING_HEAD)
        with kit.page("What should it feel like?"), drop_zone(whole_page=True):
            draw_first_touch(studio)
            with ui.element("div").classes("doors"):
                for title, (address, text) in DOORS.items():
                    with kit.card(classes="whole"):
                        ui.link(title, address).classes("h2 whole-link")
                        ui.markdown(text).classes("quiet")
            if studio.starter.state != "ready" and not studio.workspace.finished_runs():
                draw_progress(studio.starter, ready=summary.refresh)
            summary()
            receiving_status(
                "Drop a folder or a zip of recordings anywhere on this page to import it, or a photograph to draw it."
            )


def _draw_summary(studio: Studio) -> None:
    workspace = studio.workspace
    counts = {
        "run": (len(workspace.runs()), "/train"),
        "store": (len(workspace.stores()), "/materials"),
        "study session": (len(workspace.sessions()), "/studies"),
        "kept result": (len(studio.shelf.all()), "/send"),
    }
    with ui.row().classes("items-center gap-x-6 gap-y-1"):
        kit.hint(f"In {workspace.display_path}:")
        for name, (count, address) in counts.items():
            ui.link(f"{count} {name}{'' if count == 1 else 's'}", address).classes("small")
