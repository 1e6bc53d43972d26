"""The page Studies: what can be asked, sessions begun, what a study could show, and what answers show."""

from __future__ import annotations

from pathlib import Path
from urllib.parse import quote

from nicegui import events, ui

from tactogram.recipe import parse_changes
from tactogram.studio.context import Studio
from tactogram.studio.layout import busy, in_background, page, report_errors, upload
from tactogram.studio.pages.studies.catalogue import (
    STUDIES,
    SessionEntry,
    StudyEntry,
    begun,
    copy_study,
    session_folder,
    workspace_studies,
)
from tactogram.studio.pages.studies.experiment_view import address_of
from tactogram.studio.pages.studies.panels import analysis, power
from tactogram.studio.workspace.uploads import save_upload
from tactogram.workflows.study.studies import check_study


def add(studio: Studio) -> None:
    """Register the page."""

    @ui.page("/studies")
    async def show() -> None:
        with page("Studies"):
            ui.add_head_html('<link rel="stylesheet" href="/static/experiment.css">')
            ui.label(
                "A study is a file: what is felt, in which order, what is asked. Begin a session of one, and people "
                "take it on this machine or on tablets. As they come, the designs play simulated recordings."
            ).classes("quiet")
            await StudiesPage(studio).draw()


class StudiesPage:
    """One such page.

    Parameters
    ----------
    studio : Studio
    """

    def __init__(self, studio: Studio) -> None:
        self.studio, self.workspace = studio, studio.workspace

    async def draw(self) -> None:
        """Draw everything."""
        studies = await in_background(workspace_studies, self.workspace)
        sessions = await in_background(begun, self.workspace)
        self._sessions(sessions)
        own = [study for study in studies if not study.shipped]
        with ui.element("section").classes("w-full stack"):
            with ui.row().classes("items-center justify-between w-full"):
                ui.label("Study files of this workspace").classes("h2")
                given = upload("Add a study file (TOML)", on_upload=report_errors(self._upload))
                given.props('accept=".toml"').classes("listless")
            if own:
                self._cards(own)
            else:
                ui.label("None yet: copy a design below and change it, or add a file.").classes("quiet")
            ui.label("Designs").classes("h2")
            self._cards([study for study in studies if study.shipped])
        power()
        analysis(self.workspace, [one for one in sessions if not one.wrong])

    def _cards(self, studies: list[StudyEntry]) -> None:
        with ui.element("div").classes("studies w-full"):
            for study in studies:
                with ui.element("section").classes("card stack").props(f'data-study="{study.name}"'):
                    self._card(study)

    def _card(self, study: StudyEntry) -> None:
        ui.label(study.title).classes("h2")
        ui.label(study.name).classes("quiet small")
        if study.wrong:
            ui.label(study.wrong).classes("text-negative").props('role="alert"')
            return
        ui.label(study.question_text)
        ui.label(study.line).classes("quiet small")
        if study.facts["source"]:
            ui.label(f"Reproduces: {study.facts['source']}").classes("quiet small")
        if study.facts["simulated_stimuli"]:
            ui.label("simulated stimuli").classes("simulated")
        with ui.row().classes("gap-2 foot"):
            begin = ui.button("Begin a session", on_click=lambda: self._begin(study))
            begin.props(f'aria-label="Begin a session of {study.name}"')
            check = ui.button("Check", on_click=lambda e: self._check(study, e.sender)).props("outline")
            check.props(f'aria-label="Check {study.name}: make and render every stimulus"')
            if study.shipped:
                copied = ui.button("Copy", on_click=report_errors(lambda: self._copy(study))).props("outline")
                copied.props(f'aria-label="Copy {study.name} into the workspace"')

    def _sessions(self, sessions: list[SessionEntry]) -> None:
        if not sessions:
            return
        with ui.element("section").classes("card w-full stack overflow-x-auto"):
            ui.label("Sessions").classes("h2")
            with ui.element("table").classes("people"):
                with ui.element("thead"), ui.element("tr"):
                    for heading in ("Folder", "Study", "How far", "Report"):
                        ui.element("th").props('scope="col"')._text = heading
                with ui.element("tbody"):
                    for one in sessions:
                        self._session(one)

    def _session(self, one: SessionEntry) -> None:
        with ui.element("tr"):
            with ui.element("th").props('scope="row"'):
                if one.wrong:
                    ui.label(one.name)
                else:
                    ui.link(one.name, address_of(one.name))
                if one.simulated:
                    ui.label("simulated").classes("simulated")
            for text in (one.title, one.line or one.wrong):
                with ui.element("td"):
                    ui.label(text)
            with ui.element("td"):
                if one.report is not None:
                    ui.link("open", f"/reports?of={quote(self.workspace.name_of(one.report))}").props(
                        f'aria-label="Report of {one.name}"'
                    )

    def _begin(self, study: StudyEntry) -> None:
        with (
            ui.dialog().props('aria-label="Begin a session"') as dialog,
            ui.card().classes("w-96 max-w-full"),
        ):
            ui.label(f"Begin a session: {study.title}").classes("h2")
            name = ui.input("Name of the session's folder", value=study.facts["name"]).classes("w-full")
            changed = (
                ui.input("Changes (optional)")
                .props('placeholder="design.repeats=2, seed=7"')
                .classes("w-full")
            )
            ui.label(
                "Answers go into this folder of the workspace. What the study is cannot change once begun."
            ).classes("quiet small")

            async def go() -> None:
                folder = session_folder(self.workspace, name.value or "")
                changes = parse_changes(
                    [part.strip() for part in (changed.value or "").split(",") if part.strip()]
                )
                with busy("beginning the session"):
                    await in_background(self.studio.sessions.begin, study.source, folder, changes=changes)
                ui.navigate.to(address_of(folder.as_posix()))

            with ui.row().classes("justify-end w-full"):
                ui.button("Not now", on_click=dialog.close).props("flat")
                ui.button("Begin", on_click=report_errors(go))
        dialog.open()

    @report_errors
    async def _check(self, study: StudyEntry, button: ui.button) -> None:
        with busy(f"making and rendering the stimuli of {study.name}", button=button):
            facts = await in_background(check_study, study.source, stimuli=True)
        count = len(facts["rendered"] or {})
        ui.notify(
            f"{study.name}: nothing is wrong; {count} signals were made and rendered on {facts['display']}"
        )

    def _copy(self, study: StudyEntry) -> None:
        path = copy_study(self.workspace, study.name)
        ui.notify(f"copied to {self.workspace.name_of(path)}; change it with any editor")
        ui.navigate.reload()

    async def _upload(self, event: events.UploadEventArguments) -> None:
        data = await event.file.read()
        path: Path = await in_background(
            save_upload, self.workspace.inside(STUDIES), event.file.name, data, kind="study"
        )
        ui.notify(f"added as {self.workspace.name_of(path)}")
        ui.navigate.reload()
