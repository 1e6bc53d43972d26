"""The page Materials: the stores of the workspace, a form to simulate one, and a place to drop recordings."""

from __future__ import annotations

from collections.abc import Callable

from nicegui import ui

from tactogram.errors import ParameterError, TactogramError
from tactogram.workflows import list_sets
from tactogram_studio.context import Studio
from tactogram_studio.layout import NumberField, heading, hint, in_background, page, report_errors, route
from tactogram_studio.pages.materials import drop, import_page, receiving, recording, store
from tactogram_studio.pages.materials.media import HEAD, MaterialsContext, add_routes
from tactogram_studio.pages.materials.overview import StoreOverview
from tactogram_studio.pages.materials.receiving import draw_chooser, drop_zone
from tactogram_studio.pages.train.request import NAME
from tactogram_studio.pages.train.trainings import command_line, free_name, trainings_of


def add(studio: Studio) -> None:
    """Register ``/materials`` and the pages below it."""
    context = MaterialsContext(studio, trainings_of(studio.workspace))
    context.trainings.keep_advancing()
    add_routes(context)
    store.add(context)
    recording.add(context)
    drop.add(context)
    import_page.add(context)

    @route("/materials")
    async def show() -> None:
        ui.add_head_html(HEAD + receiving.HEAD)
        with page("Materials"):
            with (
                ui.element("section").classes("card w-full"),
                ui.row().classes("items-center justify-between w-full"),
            ):
                ui.label("Upload a recording to see which materials it resembles, and add it to a store.")
                ui.button("Upload a recording", on_click=lambda: ui.navigate.to("/materials/drop"))
            await StoreOverview(context).draw()
            sets = await in_background(list_sets)
            with ui.element("div").classes("grid-2") as columns:
                columns.style("grid-template-columns: repeat(auto-fit, minmax(18rem, 1fr))")
                _draw_simulation(context, sets["simulate"])
                _draw_import(context)


def _draw_simulation(context: MaterialsContext, sets: dict[str, str]) -> None:
    with ui.element("section").classes("card").props('aria-label="Simulate a data set"'):
        heading("Simulate a data set")
        hint("Surfaces computed from formulas. Everything derived from them is marked as simulated.")
        options = {name: f"{name}: {text}" for name, text in sets.items()}
        kind = ui.select(options, label="Set", value="stroking9").classes("w-full")
        with ui.row().classes("w-full no-wrap"):
            per_class = NumberField("Recordings per class", placeholder="default").classes("col")
            seconds = NumberField("Seconds", placeholder="default").classes("col")
        with ui.row().classes("w-full no-wrap"):
            photographs = NumberField("Photographs per surface", placeholder="one").classes("col")
            seed = NumberField("Seed", value=0).classes("col")
        name = ui.input("Name", value="").classes("w-full")

        def arguments() -> list[str]:
            found = ["data", "simulate", str(kind.value), "--out", _output(name.value)]
            for option, value in (
                ("--seed", seed.checked(least=0, whole=True)),
                ("--per-class", per_class.checked(least=1, whole=True)),
                ("--seconds", seconds.checked(least=0.1, most=3600)),
                ("--photographs", photographs.checked(least=0, most=9, whole=True)),
            ):
                if value is not None:
                    found += [option, f"{value:.16g}"]
            return found

        _draw_start(context, arguments, name, kind)


def _draw_import(context: MaterialsContext) -> None:
    with ui.element("section").classes("card").props('aria-label="Import recordings"'), drop_zone():
        heading("Import recordings")
        hint(
            "Drop a folder with a folder for each material, or a zip of it: the studio shows how every file would be "
            "read before it imports them."
        )
        draw_chooser()
        ui.link(
            "Import from a folder of the workspace, or a published data set", "/materials/import"
        ).classes("small")


def _draw_start(
    context: MaterialsContext, arguments: Callable[[], list[str]], name: ui.input, kind: ui.select
) -> None:
    """Draw the equivalent command and the button that starts the simulation; suggest a name for each ``kind``."""
    workspace = context.studio.workspace
    command = ui.element("code").classes("small")
    command.style("overflow-wrap: anywhere; display: block; min-height: 1.2em")
    problem = ui.label().classes("text-negative").props('role="alert"')

    def suggest() -> None:
        name.value = free_name(workspace.folder / "data", str(kind.value))

    def show() -> None:
        try:
            command._text = command_line(arguments())
        except (TactogramError, ValueError):
            command._text = ""
        command.update()

    async def begin() -> None:
        problem.text = ""
        try:
            found = arguments()
            output = workspace.inside(_output(name.value))
            if output.exists():
                raise ParameterError(f"{_output(name.value)}: already exists; choose another name")
            output.parent.mkdir(parents=True, exist_ok=True)
            await in_background(context.trainings.begin, "simulate", found, output)
        except (TactogramError, ValueError) as error:
            problem.text = str(error)
            return
        ui.notify("Started. It continues if you close this tab.")

    kind.on_value_change(suggest)
    suggest()
    show()
    ui.timer(1.0, show)
    ui.button("Simulate", on_click=report_errors(begin))


def _output(name: str | None) -> str:
    text = (name or "").strip()
    if not NAME.fullmatch(text):
        raise ParameterError(f"Name: letters, digits, '.', '_' and '-', at most 80; got {text[:100]!r}")
    return f"data/{text}"
