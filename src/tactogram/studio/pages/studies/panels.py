"""Parts of the page Studies: what a study of some size could show, and what answers show."""

from __future__ import annotations

from pathlib import Path
from urllib.parse import quote

from nicegui import ui

from tactogram.errors import ParameterError
from tactogram.studio.layout import busy, in_background, report_errors
from tactogram.studio.pages.studies.catalogue import (
    SessionEntry,
    analysis_folder,
    counts_of,
    pairs_of,
    power_rows,
)
from tactogram.studio.workspace.folder import RUN, STORE, Workspace
from tactogram.study.answers import SUFFIXES
from tactogram.study.designs import designs
from tactogram.study.designs.catalogue import power_tables

SIMULATIONS = 2000


def power() -> None:
    """Draw the form and the table of what a study of some size could show."""
    with ui.element("section").classes("card w-full stack"):
        ui.label("Before a study: how many trials can show what").classes("h2")
        ui.label(
            f"By {SIMULATIONS} studies of simulated participants for each row. What is left empty is as typical; "
            "put in what a pilot gave."
        ).classes("quiet small")
        with ui.row().classes("items-end gap-4"):
            tables = list(power_tables())
            design = ui.select(tables, value=tables[0], label="Design").props("dense").classes("w-36")
            people = ui.input("Participants").props('dense placeholder="10,20"').classes("w-32")
            trials = ui.input("Trials of each").props('dense placeholder="30,90"').classes("w-32")
            effect = ui.number("Effect").props("dense").classes("w-24")
            margin = ui.number("Margin").props("dense").classes("w-24")
            button = ui.button("Reckon")
        shown = ui.column().classes("w-full gap-2").props('aria-live="polite"')

        @report_errors
        async def reckon() -> None:
            from tactogram.workflows.study.power import study_power

            with busy("taking studies by simulated participants", button=button):
                found = await in_background(
                    study_power,
                    design.value,
                    participants=counts_of(people.value or "", "participants"),
                    trials=counts_of(trials.value or "", "trials"),
                    effect=effect.value,
                    margin=margin.value,
                    simulations=SIMULATIONS,
                )
            shown.clear()
            with shown:
                _table(
                    *power_rows(found["rows"]),
                    caption=f"What a study of design {found['design']} shows, as a share of studies",
                )
                with (
                    ui.expansion("In full, with what is assumed").classes("w-full"),
                    ui.element("div").classes("power"),
                ):
                    ui.element("pre")._text = found["text"]

        button.on_click(reckon)


def analysis(workspace: Workspace, sessions: list[SessionEntry]) -> None:
    """Draw the form that analyses a session or a table of answers."""
    with ui.element("section").classes("card w-full stack"):
        ui.label("After a study: what answers show").classes("h2")
        ui.label(
            "The publication's own test and the sound one, with intervals and verdicts; margins are those of the "
            "study's file. Tables of others are read by their headings."
        ).classes("quiet small")
        tables = [workspace.name_of(path) for path in workspace.files(*SUFFIXES) if _may_be_answers(path)]
        sources = {
            one.name: f"session {one.name}{' (simulated)' if one.simulated else ''}" for one in sessions
        }
        sources |= {name: f"table {name}" for name in tables}
        if not sources:
            ui.label("No session was begun here, and no table lies here (.csv, .tsv, .parquet).").classes(
                "quiet"
            )
            return
        first = sessions[0].name if sessions else None  # which table holds answers is not known
        source = ui.select(sources, label="Answers", value=first, with_input=True).props("dense")
        source.classes("w-96")
        with (
            ui.expansion("A table of others, other margins").classes("w-full"),
            ui.row().classes("items-end gap-4"),
        ):
            design = ui.input("Design of its rows").props(f'dense placeholder="{next(iter(designs()))}"')
            columns = ui.input("Their headings of our columns").props(
                'dense placeholder="participant=subject"'
            )
            constants = ui.input("What a column is in every row").props('dense placeholder="question=which"')
            margins = ui.input("Margins instead of the file's").props('dense placeholder="which=0.1"')
        button = ui.button("Analyse")
        shown = ui.column().classes("w-full gap-1").props('aria-live="polite"')

        @report_errors
        async def analyse() -> None:
            from tactogram.workflows.study.analysis import analyse_study, margins_of

            if not source.value:
                raise ParameterError("choose the answers first: a session or a table")
            chosen = workspace.inside(source.value)
            out = analysis_folder(workspace, chosen)
            with busy("analysing the answers", button=button), workspace.readable_errors():
                result = await in_background(
                    analyse_study,
                    chosen,
                    out,
                    design=(design.value or "").strip() or None,
                    columns=pairs_of(columns.value or "", "headings"),
                    constants=pairs_of(constants.value or "", "columns"),
                    margins=margins_of(
                        [part.strip() for part in (margins.value or "").split(",") if part.strip()]
                    ),
                )
            shown.clear()
            with shown:
                for section in result["sections"]:
                    who = f"{section['participants']} {'simulated ' if section['simulated'] else ''}participants"
                    for found in section["findings"]:
                        if found["role"] == "confirmatory":
                            said = found["verdict"] or f"{found['measure']} {found['estimate']:.3g}"
                            ui.label(f"{section['title']}, {found['of']}: {said} ({who})")
                ui.link("Open the report", f"/reports?of={quote(workspace.name_of(out / 'report.html'))}")

        button.on_click(analyse)


def _table(headings: list[str], rows: list[list[str]], *, caption: str) -> None:
    with ui.element("div").classes("w-full overflow-x-auto"), ui.element("table").classes("people"):
        ui.element("caption").classes("quiet small text-left")._text = caption
        with ui.element("thead"), ui.element("tr"):
            for heading in headings:
                ui.element("th").props('scope="col"')._text = heading
        with ui.element("tbody"):
            for row in rows:
                with ui.element("tr"):
                    for cell in row:
                        ui.element("td")._text = cell


def _may_be_answers(path: Path) -> bool:
    """Return whether a file is a table that stands alone: not one of those beside answers, of a store or of a run."""
    if path.name.endswith((".participants.csv", ".notes.csv")):
        return False
    if any((path.parent / name).is_file() for name in (STORE, RUN)):
        return False
    return not any(parent.name in ("beh", "sourcedata") for parent in path.parents)
