"""Parts of the page Studies: power of a planned study, the begin of a session, and analysis of answers."""

from __future__ import annotations

from pathlib import Path
from urllib.parse import quote

from nicegui import ui

from tactogram.datasets import finite_number
from tactogram.errors import ParameterError
from tactogram_studio import kit
from tactogram_studio.context import Studio
from tactogram_studio.pages.studies.catalogue import (
    SessionEntry,
    analysis_folder,
    counts_of,
    free_session_name,
    new_session_folder,
    pairs_of,
    power_rows,
)
from tactogram_studio.pages.studies.experiment_view import address_of, participant_count
from tactogram_studio.workspace.folder import RUN, STORE, Workspace
from tactogram_study.answers import SUFFIXES
from tactogram_study.designs import designs
from tactogram_study.designs.catalogue import power_tables

SIMULATIONS = 2000


def begin_dialog(studio: Studio, source: Path | str, *, title: str, name: str) -> None:
    """Ask for the session's folder, begin a session of a study file or shipped study, and open its page."""

    async def begin() -> None:
        place = new_session_folder(studio.workspace, folder.value or "")
        values = pairs_of(changes.value, "Changes")
        with kit.busy("beginning the session"):
            await kit.in_background(studio.sessions.begin, source, place, changes=values)
        ui.navigate.to(address_of(place.as_posix()))

    with kit.form_dialog(f"Begin a session: {title}", "Begin", begin, label="Begin a session"):
        folder = ui.input("Name of the session's folder", value=free_session_name(studio.workspace, name))
        folder.classes("w-full")
        changes = ui.input("Changes (optional)").props('placeholder="design.repeats=2, seed=7"')
        changes.classes("w-full")
        kit.hint("Answers are stored in this folder. The study cannot be changed once the session has begun.")


def power() -> None:
    """Draw the form and table of statistical power."""
    with kit.card("Before a study: statistical power", classes="w-full stack"):
        kit.hint(
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

        async def calculate() -> None:
            from tactogram_study.workflows.power import study_power

            with kit.busy("simulating studies", button=button):
                result = await kit.in_background(
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
                caption = f"Design {result['design']}: share of simulated studies with each result"
                kit.table(*power_rows(result["rows"]), caption=caption)
                with (
                    ui.expansion("Full report with assumptions").classes("w-full"),
                    ui.element("div").classes("power"),
                ):
                    ui.element("pre")._text = result["text"]

        button.on_click(calculate)


def analysis(workspace: Workspace, sessions: list[SessionEntry]) -> None:
    """Draw the form that analyses a session or a table of answers."""
    with kit.card("After a study: analysis", classes="w-full stack"):
        kit.hint(
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

        async def analyse() -> None:
            from tactogram_study.workflows.analysis import analyse_study

            if not source.value:
                raise ParameterError("choose the answers first: a session or a table")
            chosen = workspace.inside(source.value)
            out = analysis_folder(workspace, chosen)
            with kit.busy("analysing the answers", button=button), workspace.readable_errors():
                result = await kit.in_background(
                    analyse_study,
                    chosen,
                    out,
                    design=(design.value or "").strip() or None,
                    columns={
                        name: str(value)
                        for name, value in pairs_of(columns.value, "Names of columns").items()
                    },
                    constants={
                        name: str(value) for name, value in pairs_of(constants.value, "Values").items()
                    },
                    margins={
                        name: finite_number("margin", name, str(value))
                        for name, value in pairs_of(margins.value, "Other margins").items()
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


def _may_be_answers(path: Path) -> bool:
    """Return whether a table may hold answers: it does not belong to a session's export, a store or a run."""
    if path.name.endswith((".participants.csv", ".notes.csv")):
        return False
    if any((path.parent / name).is_file() for name in (STORE, RUN)):
        return False
    return not any(parent.name in ("beh", "sourcedata") for parent in path.parents)
