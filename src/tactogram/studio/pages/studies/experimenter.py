"""The experimenter's page of a session: who is where, the link to join, codes, notes, the end, export and analysis."""

from __future__ import annotations

import asyncio
from collections.abc import Callable
from pathlib import Path
from typing import TYPE_CHECKING, Any

from nicegui import app, ui
from starlette.requests import Request
from starlette.responses import FileResponse, PlainTextResponse, Response

from tactogram.errors import TactogramError
from tactogram.recipe import parse_changes
from tactogram.studio.context import Studio
from tactogram.studio.layout import busy, in_background, page, report_errors
from tactogram.studio.pages.studies.experiment_view import (
    ParticipantRow,
    SessionView,
    address_of,
    answers_rows,
    folder_of,
    peeking_text,
    report_of,
    view_of,
)
from tactogram.studio.pages.studies.joining import JoinCard
from tactogram.studio.server.guard import REPORT_POLICY
from tactogram.study.session.states import NOT_BEGUN, status_label
from tactogram.workflows.study.export import export_zip
from tactogram.workflows.study.simulation import simulate_session

if TYPE_CHECKING:
    from tactogram.studio.participants.sessions import OpenSession

EVERY_S = 2.0
"""How often the page looks at the answers."""


def add(studio: Studio) -> None:
    """Register the page and its report."""

    @ui.page("/experiment/{session}")
    async def show(session: str, request: Request) -> None:
        opened: OpenSession | None = None
        wrong = ""
        try:
            opened = studio.sessions.open(Path(folder_of(session)))
        except TactogramError as error:
            wrong = str(error)
        title = "Experiment" if opened is None else opened.study.title.en or opened.study.title.ja
        with page(title, navigation=not studio.study_only):
            ui.add_head_html('<link rel="stylesheet" href="/static/experiment.css">')
            if opened is None:
                ui.label(wrong).classes("text-negative").props('role="alert"')
                return
            await ExperimenterPage(studio, opened, session, str(request.base_url).rstrip("/")).draw()

    @app.get("/experiment/{session}/report.html")
    def report(session: str) -> Response:
        try:
            path = report_of(studio.workspace.inside(folder_of(session)))
        except TactogramError as error:
            return PlainTextResponse(str(error), status_code=404)
        if not path.is_file():
            return PlainTextResponse("no analysis yet; analyse the answers first", status_code=404)
        return FileResponse(path, headers={"Content-Security-Policy": REPORT_POLICY})


class ExperimenterPage:
    """One page on a session; several may be open at once.

    Parameters
    ----------
    studio : Studio
    opened : OpenSession
    name : str
        As the address has it.
    server : str
        Address under which the browser reached the page.
    """

    def __init__(self, studio: Studio, opened: OpenSession, name: str, server: str) -> None:
        self.studio, self.opened, self.store = studio, opened, opened.store
        self.name, self.server = name, server
        self.view: SessionView | None = None
        self.shown: dict[str, _ParticipantRowView] = {}
        self.looking = asyncio.Lock()

    async def draw(self) -> None:
        """Draw everything, and keep it up to date."""
        self._about()
        with ui.element("div").classes("grid-people"):
            with ui.column().classes("w-full gap-4"):
                self._people()
                self._latest()
            with ui.column().classes("w-full gap-4"):
                self.joining = JoinCard(self.opened, self.server, self.studio.roots, self.look)
                self._notes()
        self._results()
        await self.look()
        ui.timer(EVERY_S, self.look, immediate=False)

    async def look(self) -> None:
        """Look at what came since; one look after the other, so that none shows what an earlier one saw."""
        async with self.looking:
            self._show(await in_background(view_of, self.store))

    def _show(self, view: SessionView) -> None:
        before, self.view = self.view, view
        self.summary.text = view.summary()
        self.joining.card.set_visibility(
            not view.simulated
        )  # people and simulated participants are kept apart
        self.ended.set_visibility(view.ended is not None)
        self.end.text = "Let it go on" if view.ended else "End the study"
        codes = [row.code for row in view.rows]
        self._rows(view)
        if before is None or view.latest != before.latest:
            self.answers.rows = [
                {"key": key, **dict(zip(ANSWERS, row, strict=True))}
                for key, row in enumerate(answers_rows(view.latest))
            ]
            self.answers.update()
        if before is None or view.notes != before.notes:
            self._list_notes(view)
        options = {"": "the whole study", **{code: code for code in codes}}
        if self.about.options != options:
            self.about.set_options(options, value=self.about.value if self.about.value in options else "")

    def _about(self) -> None:
        study = self.opened.study
        kind = study.design.kind
        practice = f", {study.practice.trials} of practice" if study.practice else ""
        with ui.element("section").classes("card w-full stack"):
            with ui.row().classes("items-center justify-between w-full"):
                self.summary = ui.label("").classes("h2").props('aria-live="polite"')
                self.end = ui.button("End the study", on_click=report_errors(self._end)).props("outline")
            ui.label(
                f"{kind}, up to {study.trials} trials{practice}; {study.display}, level {study.level}; "
                f"folder {self.studio.workspace.name_of(self.store.path.parent)}"
            ).classes("quiet small")
            if any(stimulus.is_simulated for stimulus in study.made_stimuli):
                ui.label("simulated stimuli").classes("simulated")
            self.ended = ui.label("Ended: nobody joins, and who has not finished does not go on.").classes(
                "text-negative"
            )
            for name, reason in self.opened.failures.items():
                ui.label(f"{name} cannot be played: {reason}").classes("text-negative").props('role="alert"')

    def _people(self) -> None:
        with ui.element("section").classes("card w-full stack overflow-x-auto"):
            ui.label("Participants").classes("h2")
            with ui.element("table").classes("people"):
                with ui.element("thead"), ui.element("tr"):
                    for heading in ("Code", "Status", "Where", "Last answer", "Device", "What to do"):
                        ui.element("th").props('scope="col"')._text = heading
                self.body = ui.element("tbody")
            self.nobody = ui.label("Nobody yet.").classes("quiet")

    def _latest(self) -> None:
        said = "Without conditions, and without what is right: nothing here tells how the study comes out."
        headings = [{"name": name, "label": name, "field": name, "align": "left"} for name in ANSWERS]
        folded = ui.element("section").classes("card w-full stack")
        with folded, ui.expansion("Answers as they come").classes("w-full"):
            ui.label(said).classes("quiet small")
            table = ui.table(columns=headings, rows=[], row_key="key").classes("w-full")
            self.answers = table.props("flat dense hide-pagination")

    def _notes(self) -> None:
        with ui.element("section").classes("card w-full stack"):
            ui.label("Notes").classes("h2")
            ui.label("Kept with the answers and exported. No names.").classes("quiet small")
            self.about = (
                ui.select({"": "the whole study"}, value="", label="About").props("dense").classes("w-full")
            )
            self.text = ui.textarea("Note").props("dense autogrow maxlength=4000").classes("w-full")
            ui.button("Write down", on_click=report_errors(self._note)).props("outline")
            self.results = ui.column().classes("w-full gap-1")

    def _results(self) -> None:
        with ui.element("section").classes("card w-full stack"):
            ui.label("Answers").classes("h2")
            with ui.row().classes("items-center"):
                ui.button(
                    "Download tables (ZIP)", on_click=lambda e: self._download("tables", e.sender)
                ).props("outline")
                ui.button("Download BIDS (ZIP)", on_click=lambda e: self._download("bids", e.sender)).props(
                    "outline"
                )
                ui.button("Analyse", on_click=lambda e: self._analyse(e.sender))
            self.report = ui.column()
            if report_of(self.store.path.parent).is_file():
                self._report_link("The last report")
            with ui.expansion("Simulated participants").classes("w-full"):
                ui.label(
                    "Programs that take this study as people do, into a folder of their own: to test the way, and for "
                    "power. They say nothing about touch."
                ).classes("quiet small")
                with ui.row().classes("items-end"):
                    self.count = ui.number("How many", value=20, min=1, max=1000, precision=0).props("dense")
                    self.effect = ui.input("What is true of them").props(
                        'dense placeholder="nothing, or d_prime=1"'
                    )
                    ui.button("Let them take it", on_click=lambda e: self._simulate(e.sender)).props(
                        "outline"
                    )

    def _rows(self, view: SessionView) -> None:
        """Take out who withdrew, put in who came, leave the other rows where they are: a hand may be on one."""
        for code in self.shown.keys() - {row.code for row in view.rows}:
            self.shown.pop(code).row.delete()
        for place, row in enumerate(view.rows):
            if row.code not in self.shown:
                with self.body:
                    self.shown[row.code] = _ParticipantRowView(row, self)
                self.shown[row.code].row.move(target_index=place)
            self.shown[row.code].update(row)
        self.nobody.set_visibility(not view.rows)

    def _list_notes(self, view: SessionView) -> None:
        self.results.clear()
        with self.results:
            for note in reversed(view.notes):
                ui.label(
                    f"{note['at'][:16].replace('T', ' ')} UTC, {note['participant'] or 'the study'}: {note['text']}"
                ).classes("small whitespace-pre-wrap")

    async def _note(self) -> None:
        await in_background(self.store.note, self.text.value or "", code=self.about.value or None)
        self.text.value = ""
        await self.look()

    async def _end(self) -> None:
        if await in_background(lambda: self.store.ended):
            await in_background(self.store.reopen_study)
        else:
            left = self.view.unfinished if self.view else 0
            who = f" {left} who have not finished, or not begun, can answer no more." if left else ""
            if not await asked(
                f"End the study?{who} What was answered stays, and it can be let go on.", "End the study"
            ):
                return
            await in_background(self.store.end)
        await self.look()

    @report_errors
    async def _download(self, kind: Any, button: ui.button) -> None:
        with busy("packing the answers", button=button):
            name, packed = await in_background(export_zip, self.store.path.parent, kind=kind)
        ui.download.content(packed, name, "application/zip")

    @report_errors
    async def _analyse(self, button: ui.button) -> None:
        view = await in_background(view_of, self.store)
        warning = peeking_text(view)
        if warning and not await asked(warning, "Look all the same"):
            return
        from tactogram.workflows.study.analysis import analyse_study

        folder = self.store.path.parent
        with busy("analysing the answers", button=button):
            await in_background(analyse_study, folder, report_of(folder).parent)
        if warning:
            said = f"The analysis was looked at before the end: {view.summary()}"
            await in_background(self.store.note, said)
        self._report_link("The report is there")
        await self.look()

    def _report_link(self, said: str) -> None:
        self.report.clear()
        with self.report:
            ui.link(f"{said}: open it", f"/experiment/{self.name}/report.html", new_tab=True)

    @report_errors
    async def _simulate(self, button: ui.button) -> None:
        effect = parse_changes(
            [part.strip() for part in (self.effect.value or "").split(",") if part.strip()]
        )
        count = int(self.count.value or 0)
        with busy("simulated participants take the study", button=button):
            made = await in_background(
                simulate_session, self.store.path.parent, participants=count, effect=effect
            )
        name = self.studio.workspace.name_of(Path(made["folder"]))
        with self.report:
            ui.link(f"{count} simulated participants took it: open their folder", address_of(name))


ANSWERS = ("participant", "trial", "question", "answer", "at (UTC)")


class _ParticipantRowView:
    """One participant's row, whose cells are changed in place: nothing under a finger or a screen reader is redrawn."""

    def __init__(self, row: ParticipantRow, experiment: ExperimenterPage) -> None:
        self.code, self.of = row.code, experiment
        with ui.element("tr") as self.row:
            with ui.element("th").props('scope="row"'):
                ui.label(row.code)
                if row.simulated:
                    ui.label("simulated").classes("simulated")
            self.status = _cell()
            with ui.element("td"):
                self.where = ui.label()
                self.bar = ui.linear_progress(0, show_value=False, size="4px").props(
                    f'aria-label="Trials of {row.code}"'
                )
            self.since = _cell()
            self.device = _cell("small quiet")
            with ui.element("td"), ui.row().classes("gap-1 no-wrap items-center"):
                address = experiment.joining.pages_here(row.code)
                ui.link("pages", address, new_tab=True).props(f'aria-label="Pages of {row.code}"')
                if not experiment.joining.alone:
                    self._button("QR code", lambda: experiment.joining.show_qr_code(row.code))
                self.stop = self._button("Abort", self._abort)
                self._button("Withdraw", self._withdraw)

    def update(self, row: ParticipantRow) -> None:
        """Show what is so now."""
        self.status.text = status_label(row.status)
        self.where.text = row.where
        self.bar.value = row.share
        self.since.text = row.since
        self.since.classes(
            add="text-negative" if row.quiet else "", remove="" if row.quiet else "text-negative"
        )
        self.device.text = row.device
        self.stop.text = "Reopen" if row.status == "aborted" else "Abort"
        self.stop.set_visibility(row.status in ("aborted", "active", NOT_BEGUN))

    def _button(self, text: str, handler: Callable[[], Any]) -> ui.button:
        button = ui.button(text, on_click=report_errors(handler)).props("flat dense no-caps")
        # What has the same name in every row is named by its code; the third changes its name.
        return button if text == "Abort" else button.props(f'aria-label="{text} {self.code}"')

    async def _abort(self) -> None:
        if self.stop.text == "Reopen":
            await in_background(self.of.store.reopen, self.code)
        elif await asked(f"End the session of {self.code} now? It can be reopened.", "Abort"):
            await in_background(self.of.store.abort, self.code)
        await self.of.look()

    async def _withdraw(self) -> None:
        said = (
            f"Delete everything of {self.code}? This cannot be undone. What was exported or analysed before still "
            "holds them: delete that, and export again."
        )
        if await asked(said, f"Delete {self.code}"):
            await in_background(self.of.store.withdraw, self.code)
        await self.of.look()


def _cell(classes: str = "") -> ui.label:
    with ui.element("td"):
        return ui.label().classes(classes)


async def asked(question: str, yes: str) -> bool:
    """Ask before something that matters, and return whether it is wanted; away from the dialog is no."""
    with ui.dialog().props('aria-label="Are you sure?"') as dialog, ui.card().classes("max-w-lg"):
        ui.label(question)
        with ui.row().classes("justify-end w-full"):
            ui.button("No", on_click=lambda: dialog.submit(False)).props("flat")
            ui.button(yes, on_click=lambda: dialog.submit(True)).props("color=negative")
    wanted = bool(await dialog)
    if dialog.is_deleted:  # the page was left meanwhile
        return False
    dialog.delete()
    return wanted
