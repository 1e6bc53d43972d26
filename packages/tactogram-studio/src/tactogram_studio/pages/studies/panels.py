"""Parts of the page Studies: power of a planned study, and analysis of answers."""

from __future__ import annotations

from pathlib import Path
from urllib.parse import quote

from nicegui import ui

from tactogram.datasets import finite_number
from tactogram.errors import ParameterError
from tactogram_studio.layout import busy, heading, hint, in_background, report_errors
from tactogram_studio.pages.studies.catalogue import (
    SessionEntry,
    analysis_folder,
    counts_of,
    pairs_of,
    power_rows,
)
from tactogram_studio.pages.studies.experiment_view import participant_count
from tactogram_studio.workspace.folder import RUN, STORE, Workspace
from tactogram_study.answers import SUFFIXES
from tactogram_study.designs import designs
from tactogram_study.designs.catalogue import power_tables

SIMULATIONS = 2000


def power() -> None:
    """Draw the form and table of statistical power."""
    with ui.element("section").classes("card w-full stack"):
        heading("Before a study: statistical power")
        hint(
            f"Each row simulates {SIMULATIONS} studies with simulated participants. Empty fields have typical values; "
            "enter those of a pilot."
        )
        with ui.row().classes("items-end gap-4"):
            tables = list(power_tables())
            design = ui.select(tables, value=tables[0], label="Design").props("dense").classes("w-36")
            people = ui.input("Participants").props('dense placeholder="10,20"').classes("w-32")
            trials = ui.input("Trials each").props('dense placeholder="30,90"').classes("w-32")
            effect = ui.number("Effect").props("dense").classes("w-24")
            margin = ui.number("Margin").props("dense").classes("w-24")
            button = ui.button("Calculate power")
        shown = ui.column().classes("w-full gap-2").props('aria-live="polite"')

        @report_errors
        async def calculate() -> None:
            from tactogram_study.workflows.power import study_power

            with busy("simulating studies", button=button):
                result = await in_background(
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
                    *power_rows(result["rows"]),
                    caption=f"Design {result['design']}: share of simulated studies with each result",
                )
                with (
                    ui.expansion("Full report with assumptions").classes("w-full"),
                    ui.element("div").classes("power"),
                ):
                    ui.element("pre")._text = result["text"]

        button.on_click(calculate)


def analysis(workspace: Workspace, sessions: list[SessionEntry]) -> None:
    """Draw the form that analyses a session or a table of answers."""
    with ui.element("section").classes("card w-full stack"):
        heading("After a study: analysis")
        hint(
            "The publication's test and a sound one, with intervals and verdicts; margins are those of the study's "
            "file. Tables of other programs are read by their headings."
        )
        tables = [workspace.name_of(path) for path in workspace.files(*SUFFIXES) if _may_be_answers(path)]
        sources = {
            session.name: f"session {session.name}{' (simulated)' if session.simulated else ''}"
            for session in sessions
        }
        sources |= {name: f"table {name}" for name in tables}
        if not sources:
            ui.label("No sessions or tables (.csv, .tsv, .parquet) in this workspace yet.").classes("quiet")
            return
        first = sessions[0].name if sessions else None  # it is unknown which tables hold answers
        source = ui.select(sources, label="Answers", value=first, with_input=True).props("dense")
        source.classes("w-96")
        with (
            ui.expansion("Tables of other programs, other margins").classes("w-full"),
            ui.row().classes("items-end gap-4"),
        ):
            design = ui.input("Design of the table").props(f'dense placeholder="{next(iter(designs()))}"')
            columns = ui.input("Names of columns in the table").props(
                'dense placeholder="participant=subject"'
            )
            constants = ui.input("Values that are the same in every row").props(
                'dense placeholder="question=which"'
            )
            margins = ui.input("Other margins").props('dense placeholder="which=0.1"')
        button = ui.button("Analyse")
        shown = ui.column().classes("w-full gap-1").props('aria-live="polite"')

        @report_errors
        async def analyse() -> None:
            from tactogram_study.workflows.analysis import analyse_study

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
                    margins={
                        name: finite_number("margin", name, text)
                        for name, text in pairs_of(margins.value or "", "margins").items()
                    },
                )
            shown.clear()
            with shown:
                for note in result["notes"]:
                    ui.label(note)
                for section in result["sections"]:
                    who = participant_count(section["participants"], simulated=section["simulated"])
                    for finding in section["findings"]:
                        if finding["role"] == "confirmatory":
                            text = finding["verdict"] or f"{finding['measure']} {finding['estimate']:.3g}"
                            ui.label(f"{section['title']}, {finding['of']}: {text} ({who})")
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
    """Return whether a table may hold answers: it does not belong to a session's export, a store or a run."""
    if path.name.endswith((".participants.csv", ".notes.csv")):
        return False
    if any((path.parent / name).is_file() for name in (STORE, RUN)):
        return False
    return not any(parent.name in ("beh", "sourcedata") for parent in path.parents)
