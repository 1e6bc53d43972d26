"""The page Materials: the stores of the workspace, and forms to simulate or import one."""

from __future__ import annotations

import os
import shlex
from collections.abc import Callable
from typing import Any

from nicegui import ui

from tactogram.errors import ParameterError, TactogramError
from tactogram.studio.context import Studio
from tactogram.studio.layout import NumberField, heading, hint, in_background, page, report_errors, route
from tactogram.studio.pages.materials import drop, recording, store
from tactogram.studio.pages.materials.media import HEAD, MaterialsContext, add_routes
from tactogram.studio.pages.materials.overview import StoreOverview
from tactogram.studio.pages.train.request import NAME
from tactogram.studio.pages.train.trainings import Kind, command_line, free_name, trainings_of
from tactogram.workflows.data.stores import list_sets


def add(studio: Studio) -> None:
    """Register ``/materials`` and the pages below it."""
    context = MaterialsContext(studio, trainings_of(studio.workspace))
    context.trainings.keep_advancing()
    add_routes(context)
    store.add(context)
    recording.add(context)
    drop.add(context)

    @route("/materials")
    async def show() -> None:
        ui.add_head_html(HEAD)
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
                _draw_import(context, sets["import"])


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

        _draw_start(context, "simulate", arguments, name, kind, lambda: str(kind.value))


def _draw_import(context: MaterialsContext, sets: dict[str, Any]) -> None:
    workspace = context.studio.workspace
    with ui.element("section").classes("card").props('aria-label="Import a data set"'):
        heading("Import a data set")
        hint(
            f"From a folder inside the workspace {workspace.display_path}. The command tactogram data import reads "
            "from any folder."
        ).style("overflow-wrap: anywhere")
        options = {key: f"{key}: {facts['title']}" for key, facts in sets.items()}
        kind = ui.select(options, label="Kind", value="folder").classes("w-full")
        path = ui.input("Folder", placeholder="recordings").classes("w-full")
        settings = ui.input("Information missing from the files", placeholder="rate=1000 unit=m/s^2")
        settings.classes("w-full")
        skip = ui.checkbox("Skip broken files")
        name = ui.input("Name", value="").classes("w-full")

        def arguments() -> list[str]:
            if not (path.value or "").strip():
                raise ParameterError("Folder: enter a folder of the workspace to import")
            source = workspace.inside(path.value.strip())
            if not source.is_dir():
                raise ParameterError(f"{path.value}: no such folder in the workspace")
            found = [
                "data",
                "import",
                str(kind.value),
                workspace.name_of(source),
                "--out",
                _output(name.value),
            ]
            for setting in shlex.split(settings.value or ""):
                found += ["--set", setting]
            return [*found, "--skip-bad"] if skip.value else found

        def suggestion() -> str:
            return os.path.basename((path.value or "").strip("/")) or "set"

        _draw_start(context, "import", arguments, name, kind, suggestion)


def _draw_start(
    context: MaterialsContext,
    task: Kind,
    arguments: Callable[[], list[str]],
    name: ui.input,
    kind: ui.select,
    suggestion: Callable[[], str],
) -> None:
    """Draw the equivalent command and the button that starts the task; fill in an unused name for each ``kind``."""
    workspace = context.studio.workspace
    command = ui.element("code").classes("small")
    command.style("overflow-wrap: anywhere; display: block; min-height: 1.2em")
    problem = ui.label().classes("text-negative").props('role="alert"')

    def suggest() -> None:
        name.value = free_name(workspace.folder / "data", suggestion())

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
            await in_background(context.trainings.begin, task, found, output)
        except (TactogramError, ValueError) as error:
            problem.text = str(error)
            return
        ui.notify("Started. It continues if you close this tab.")

    kind.on_value_change(suggest)
    suggest()
    show()
    ui.timer(1.0, show)
    ui.button(task.capitalize(), on_click=report_errors(begin))


def _output(name: str | None) -> str:
    text = (name or "").strip()
    if not NAME.fullmatch(text):
        raise ParameterError(f"Name: letters, digits, '.', '_' and '-', at most 80; got {text[:100]!r}")
    return f"data/{text}"
