"""The page Materials: the data sets of the workspace, and making or importing another."""

from __future__ import annotations

import os
import shlex
from typing import Any

from nicegui import ui

from tactogram.errors import ParameterError, TactogramError
from tactogram.studio.context import Studio
from tactogram.studio.layout import NumberField, in_background, page, report_errors
from tactogram.studio.pages.materials import data_set, drop, recording
from tactogram.studio.pages.materials.media import HEAD, MaterialsContext, add_routes
from tactogram.studio.pages.materials.overview import DataSetsPage
from tactogram.studio.pages.materials.recordings import StoreCache
from tactogram.studio.pages.train.request import NAME
from tactogram.studio.pages.train.trainings import command_line, free_name, trainings_of
from tactogram.workflows.data.stores import list_sets


def add(studio: Studio) -> None:
    """Register ``/materials`` and what belongs to it."""
    desk = MaterialsContext(studio, trainings_of(studio.workspace), StoreCache(studio.workspace))
    desk.trainings.keep_advancing()
    add_routes(desk)
    data_set.add(desk)
    recording.add(desk)
    drop.add(desk)

    @ui.page("/materials")
    async def show() -> None:
        ui.add_head_html(HEAD)
        with page("Materials"):
            with (
                ui.element("section").classes("card w-full"),
                ui.row().classes("items-center justify-between w-full"),
            ):
                ui.label("What is this recording like? What is it called?")
                ui.button("Drop a new recording", on_click=lambda: ui.navigate.to("/materials/drop"))
            await DataSetsPage(desk).show()
            with (
                ui.element("div")
                .classes("grid-2")
                .style("grid-template-columns: repeat(auto-fit, minmax(18rem, 1fr))")
            ):
                sets = await in_background(list_sets)
                _simulate(desk, sets["simulate"])
                _import(desk, sets["import"])


def _simulate(desk: MaterialsContext, sets: dict[str, str]) -> None:
    with ui.element("section").classes("card").props('aria-label="Simulate a data set"'):
        ui.label("Simulate a data set").classes("h2").props('role="heading" aria-level="2"')
        ui.label("Surfaces from formulas: what comes of them says simulated for good.").classes("small quiet")
        which = ui.select(
            {name: f"{name}: {text}" for name, text in sets.items()}, label="Set", value="stroking9"
        )
        which.classes("w-full")
        with ui.row().classes("w-full no-wrap"):
            per_class = NumberField("Recordings per class", placeholder="usual").classes("col")
            seconds = NumberField("Seconds", placeholder="usual").classes("col")
        with ui.row().classes("w-full no-wrap"):
            photographs = NumberField("Photographs per surface", placeholder="one").classes("col")
            seed = NumberField("Seed", value=0).classes("col")
        name = ui.input("Name", value="").classes("w-full")

        def arguments() -> list[str]:
            found = ["data", "simulate", str(which.value), "--out", _place(name.value)]
            for option, value in (
                ("--seed", seed.checked(least=0, whole=True)),
                ("--per-class", per_class.checked(least=1, whole=True)),
                ("--seconds", seconds.checked(least=0.1, most=3600)),
                ("--photographs", photographs.checked(least=0, most=9, whole=True)),
            ):
                if value is not None:
                    found += [option, f"{value:.16g}"]
            return found

        _begin(desk, "simulate", arguments, name, which, lambda: f"{which.value}")


def _import(desk: MaterialsContext, sets: dict[str, Any]) -> None:
    with ui.element("section").classes("card").props('aria-label="Import a data set"'):
        ui.label("Import a data set").classes("h2").props('role="heading" aria-level="2"')
        ui.label(
            f"From a folder inside the workspace {desk.studio.workspace.shown}; the command tactogram data import "
            "reads from anywhere."
        ).classes("small quiet").style("overflow-wrap: anywhere")
        which = ui.select(
            {key: f"{key}: {facts['title']}" for key, facts in sets.items()}, label="Kind", value="folder"
        ).classes("w-full")
        path = ui.input("Folder", placeholder="recordings").classes("w-full")
        options = ui.input("What the files do not say", placeholder="rate=1000 unit=m/s^2").classes("w-full")
        skip = ui.checkbox("go on without broken files")
        name = ui.input("Name", value="").classes("w-full")

        def arguments() -> list[str]:
            if not (path.value or "").strip():
                raise ParameterError("Folder: say which folder of the workspace to read")
            source = desk.studio.workspace.inside(path.value.strip())
            if not source.is_dir():
                raise ParameterError(f"{path.value}: no such folder in the workspace")
            found = [
                "data",
                "import",
                str(which.value),
                desk.studio.workspace.name_of(source),
                "--out",
                _place(name.value),
            ]
            for option in shlex.split(options.value or ""):
                found += ["--set", option]
            return [*found, "--skip-bad"] if skip.value else found

        _begin(
            desk,
            "import",
            arguments,
            name,
            which,
            lambda: os.path.basename((path.value or "").strip("/")) or "set",
        )


def _begin(
    desk: MaterialsContext, kind: Any, arguments: Any, name: ui.input, which: ui.select, usual: Any
) -> None:
    """Draw the equal command and the button that begins an errand."""
    command = (
        ui.element("code")
        .classes("small")
        .style("overflow-wrap: anywhere; display: block; min-height: 1.2em")
    )
    refused = ui.label().classes("text-negative").props('role="alert"')

    def suggest() -> None:
        name.value = free_name(desk.studio.workspace.folder / "data", usual())

    def show() -> None:
        try:
            command._text = command_line(arguments())
        except (TactogramError, ValueError):
            command._text = ""
        command.update()

    async def begin() -> None:
        refused.text = ""
        try:
            asked = arguments()
            place = desk.studio.workspace.inside(_place(name.value))
            if place.exists():
                raise ParameterError(f"{_place(name.value)}: is there already; give another name")
            place.parent.mkdir(parents=True, exist_ok=True)
            await in_background(desk.trainings.begin, kind, asked, place)
        except (TactogramError, ValueError) as error:
            refused.text = str(error)
            return
        ui.notify("Begun: it goes on when this tab is closed.")

    which.on_value_change(suggest)
    suggest()
    show()
    ui.timer(1.0, show)
    ui.button("Begin", on_click=report_errors(begin)).props(f'aria-label="Begin to {kind}"')


def _place(name: str | None) -> str:
    text = (name or "").strip()
    if not NAME.fullmatch(text):
        raise ParameterError(f"Name: letters, digits, '.', '_' and '-', at most 80; got {text[:100]!r}")
    return f"data/{text}"
