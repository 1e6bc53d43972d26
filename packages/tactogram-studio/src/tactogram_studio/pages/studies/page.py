"""The page Studies: designs, sessions, power and analysis."""

from __future__ import annotations

from functools import partial
from pathlib import Path
from urllib.parse import quote

from nicegui import ui

from tactogram_studio import kit
from tactogram_studio.context import Studio
from tactogram_studio.pages.studies.catalogue import (
    SessionEntry,
    StudyEntry,
    analysis,
    begin_dialog,
    power,
    workspace_sessions,
    workspace_studies,
)
from tactogram_studio.pages.studies.editor.page import add as add_editor
from tactogram_studio.study_draft.draft import STUDIES, copy_study, free_name
from tactogram_studio.workspace.session_view import address_of
from tactogram_studio.workspace.uploads import save_upload
from tactogram_study.wording import own_name


def add(studio: Studio) -> None:
    """Register the page and the editor."""
    add_editor(studio)

    @kit.route("/studies")
    async def show() -> None:
        with kit.page("Studies"):
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
        studies = await kit.in_background(workspace_studies, self.workspace)
        sessions = await kit.in_background(workspace_sessions, self.workspace)
        self._sessions(sessions)
        own = [study for study in studies if not study.shipped]
        with ui.element("section").classes("w-full stack"):
            kit.heading("Study files of this workspace")
            if own:
                self._cards(own)
            else:
                ui.label("None yet: make your own from a design below, or add a file.").classes("quiet")
            kit.file_field("Add a study file (TOML)", self._upload, accept=[".toml"])
            kit.heading("Designs")
            self._cards([study for study in studies if study.shipped])
        power()
        analysis(self.workspace, [session for session in sessions if not session.error])

    def _cards(self, studies: list[StudyEntry]) -> None:
        with ui.element("div").classes("studies w-full"):
            for study in studies:
                with ui.element("section").classes("card stack") as section:
                    section.props["data-study"] = study.name
                    self._card(study)

    def _card(self, study: StudyEntry) -> None:
        kit.heading(study.title)
        if not study.shipped:
            kit.hint(study.name)
        if study.error:
            kit.alert(study.error)
            return
        ui.label(study.question_text)
        kit.hint(study.size)
        kit.mark_simulated(study.facts["simulated_stimuli"], "simulated stimuli")
        with ui.expansion("Details").classes("w-full"):
            for line in study.details:
                kit.hint(line)
        with ui.row().classes("gap-2 foot"):
            begin = ui.button("Begin", on_click=lambda: self._begin(study)).props("dense")
            begin.props(f'aria-label="Begin a session of {kit.attribute(study.name)}"')
            copy = ui.button("Make your own", on_click=lambda: self._copy(study)).props("outline dense")
            copy.props(f'aria-label="Make your own from {kit.attribute(study.name)}"')
            if not study.shipped:
                link = ui.link("Edit", edit_address(study.name))
                link.props(f'aria-label="Edit {kit.attribute(study.name)}"').classes("self-center")

    def _sessions(self, sessions: list[SessionEntry]) -> None:
        if not sessions:
            return
        with kit.card("Sessions", classes="w-full stack"):
            kit.table(
                ["Folder", "Study", "Progress", "Report"],
                [
                    [
                        partial(self._session_name, session),
                        session.title,
                        session.line or session.error,
                        partial(self._report_link, session),
                    ]
                    for session in sessions
                ],
            )

    def _session_name(self, session: SessionEntry) -> None:
        if session.error:
            ui.label(session.name)
        else:
            ui.link(session.name, address_of(session.name))
        kit.mark_simulated(session.simulated)

    def _report_link(self, session: SessionEntry) -> None:
        if session.report is not None:
            address = f"/reports?of={quote(self.workspace.name_of(session.report))}"
            ui.link("Open", address).props(f'aria-label="Open the report of {kit.attribute(session.name)}"')

    def _begin(self, study: StudyEntry) -> None:
        begin_dialog(self.studio, study.source, title=study.title, name=study.facts["name"])

    def _copy(self, study: StudyEntry) -> None:
        async def copy() -> None:
            path = await kit.in_background(
                copy_study, self.workspace, study.source, name.value or "", languages=languages.value
            )
            ui.navigate.to(edit_address(self.workspace.name_of(path)))

        with kit.form_dialog(f"Your own from {study.title}", "Copy and edit", copy, label="Make your own"):
            name = ui.input("Name of your study", value=free_name(self.workspace, study.source))
            name.classes("w-full")
            kit.hint(
                "Lower-case letters, digits and _; it is the file's name, and part of every row of answers."
            )
            offered = {language: own_name(language) for language in study.facts["languages"]}
            first = "en" if "en" in offered else next(iter(offered))
            languages = ui.select(offered, label="Languages", multiple=True, value=[first])
            languages.classes("w-full").props("use-chips")
            kit.hint("More can be added later; the texts of all of them are copied.")

    async def _upload(self, name: str, data: bytes) -> None:
        folder = self.workspace.inside(STUDIES)
        path: Path = await kit.in_background(save_upload, folder, name, data, kind="study")
        ui.notify(f"added as {self.workspace.name_of(path)}")
        ui.navigate.reload()
