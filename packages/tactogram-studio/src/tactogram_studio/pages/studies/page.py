"""The page Studies: designs, sessions, power and analysis."""

from __future__ import annotations

from pathlib import Path
from urllib.parse import quote

from nicegui import events, ui

from tactogram_studio.context import Studio
from tactogram_studio.layout import (
    attribute,
    busy,
    heading,
    hint,
    in_background,
    page,
    report_errors,
    route,
    upload,
)
from tactogram_studio.pages.studies.begin import begin_dialog
from tactogram_studio.pages.studies.catalogue import (
    SessionEntry,
    StudyEntry,
    workspace_sessions,
    workspace_studies,
)
from tactogram_studio.pages.studies.editor.draft import STUDIES, copy_study, free_name
from tactogram_studio.pages.studies.editor.page import add as add_editor
from tactogram_studio.pages.studies.experiment_view import address_of
from tactogram_studio.pages.studies.panels import analysis, power
from tactogram_studio.workspace.uploads import save_upload
from tactogram_study.wording import own_name
from tactogram_study.workflows.studies import check_study


def add(studio: Studio) -> None:
    """Register the page and the editor."""
    add_editor(studio)

    @route("/studies")
    async def show() -> None:
        with page("Studies"):
            ui.add_head_html('<link rel="stylesheet" href="/static/experiment.css">')
            ui.label(
                "A study is a file that sets stimuli, their order and the questions. Begin a session of a study, and "
                "participants take it on this machine or on tablets. Make your own to change texts, words, stimuli and "
                " languages. The designs play simulated recordings."
            ).classes("quiet")
            await StudiesPage(studio).draw()


def edit_address(name: str) -> str:
    """Return the address of the editor of a study's file, by its path relative to the workspace."""
    return f"/studies/edit?study={quote(name)}"


class StudiesPage:
    """One tab."""

    def __init__(self, studio: Studio) -> None:
        self.studio, self.workspace = studio, studio.workspace

    async def draw(self) -> None:
        """Draw the page."""
        studies = await in_background(workspace_studies, self.workspace)
        sessions = await in_background(workspace_sessions, self.workspace)
        self._sessions(sessions)
        own = [study for study in studies if not study.shipped]
        with ui.element("section").classes("w-full stack"):
            with ui.row().classes("items-center justify-between w-full"):
                heading("Study files of this workspace")
                field = upload("Add a study file (TOML)", on_upload=report_errors(self._upload))
                field.props('accept=".toml"').classes("listless")
            if own:
                self._cards(own)
            else:
                ui.label("None yet: make your own from a design below, or add a file.").classes("quiet")
            heading("Designs")
            self._cards([study for study in studies if study.shipped])
        power()
        analysis(self.workspace, [session for session in sessions if not session.error])

    def _cards(self, studies: list[StudyEntry]) -> None:
        with ui.element("div").classes("studies w-full"):
            for study in studies:
                with ui.element("section").classes("card stack").props(f'data-study="{study.name}"'):
                    self._card(study)

    def _card(self, study: StudyEntry) -> None:
        heading(study.title)
        hint(study.name)
        if study.error:
            ui.label(study.error).classes("text-negative").props('role="alert"')
            return
        ui.label(study.question_text)
        hint(study.line)
        if study.facts["source"]:
            hint(f"Reproduces: {study.facts['source']}")
        if study.facts["simulated_stimuli"]:
            ui.label("simulated stimuli").classes("simulated")
        with ui.row().classes("gap-2 foot"):
            begin = ui.button("Begin a session", on_click=lambda: self._begin(study))
            begin.props(f'aria-label="Begin a session of {study.name}"')
            check = ui.button("Check", on_click=lambda e: self._check(study, e.sender)).props("outline")
            check.props(f'aria-label="Check {study.name}: make and render every stimulus"')
            copy = ui.button("Make your own", on_click=lambda: self._copy(study)).props("outline")
            copy.props(f'aria-label="Make your own from {study.name}"')
            if not study.shipped:
                link = ui.link("Edit", edit_address(study.name))
                link.props(f'aria-label="Edit {attribute(study.name)}"').classes("self-center")

    def _sessions(self, sessions: list[SessionEntry]) -> None:
        if not sessions:
            return
        with ui.element("section").classes("card w-full stack overflow-x-auto"):
            heading("Sessions")
            with ui.element("table").classes("people"):
                with ui.element("thead"), ui.element("tr"):
                    for name in ("Folder", "Study", "Progress", "Report"):
                        ui.element("th").props('scope="col"')._text = name
                with ui.element("tbody"):
                    for session in sessions:
                        self._session(session)

    def _session(self, session: SessionEntry) -> None:
        with ui.element("tr"):
            with ui.element("th").props('scope="row"'):
                if session.error:
                    ui.label(session.name)
                else:
                    ui.link(session.name, address_of(session.name))
                if session.simulated:
                    ui.label("simulated").classes("simulated")
            for text in (session.title, session.line or session.error):
                with ui.element("td"):
                    ui.label(text)
            with ui.element("td"):
                if session.report is not None:
                    address = f"/reports?of={quote(self.workspace.name_of(session.report))}"
                    ui.link("open", address).props(f'aria-label="Report of {session.name}"')

    def _begin(self, study: StudyEntry) -> None:
        begin_dialog(self.studio, study.source, title=study.title, name=study.facts["name"])

    @report_errors
    async def _check(self, study: StudyEntry, button: ui.button) -> None:
        with busy(f"making and rendering the stimuli of {study.name}", button=button):
            facts = await in_background(check_study, study.source, stimuli=True)
        count = len(facts["rendered"] or {})
        ui.notify(f"{study.name}: no problems; {count} signals were made and rendered on {facts['display']}")

    def _copy(self, study: StudyEntry) -> None:
        with (
            ui.dialog(value=True).props('aria-label="Make your own"') as dialog,
            ui.card().classes("w-96 max-w-full"),
        ):
            heading(f"Your own from {study.title}")
            name = ui.input("Name of your study", value=free_name(self.workspace, study.source)).classes(
                "w-full"
            )
            hint("Lower-case letters, digits and _; it is the file's name, and part of every row of answers.")

            offered = {one: own_name(one) for one in study.facts["languages"]}
            first = "en" if "en" in offered else next(iter(offered))
            languages = ui.select(offered, label="Languages", multiple=True, value=[first])
            languages.classes("w-full").props("use-chips")
            hint("More can be added later; the texts of all of them are copied.")

            async def copy() -> None:
                path = await in_background(
                    copy_study, self.workspace, study.source, name.value or "", languages=languages.value
                )
                ui.navigate.to(edit_address(self.workspace.name_of(path)))

            with ui.row().classes("justify-end w-full"):
                ui.button("Cancel", on_click=dialog.close).props("flat")
                ui.button("Copy and edit", on_click=report_errors(copy))
        dialog.on("hide", dialog.delete)

    async def _upload(self, event: events.UploadEventArguments) -> None:
        data = await event.file.read()
        path: Path = await in_background(
            save_upload, self.workspace.inside(STUDIES), event.file.name, data, kind="study"
        )
        ui.notify(f"added as {self.workspace.name_of(path)}")
        ui.navigate.reload()
