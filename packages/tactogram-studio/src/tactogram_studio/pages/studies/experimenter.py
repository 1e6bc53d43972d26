"""The experimenter's page of a session: progress, joining, notes, end, export and analysis."""

from __future__ import annotations

import asyncio
from collections.abc import Callable
from pathlib import Path
from typing import TYPE_CHECKING, Any

from nicegui import app, ui
from starlette.requests import Request
from starlette.responses import FileResponse, Response

from tactogram.errors import DataError, TactogramError
from tactogram_studio import kit
from tactogram_studio.context import Studio
from tactogram_studio.layout import without_folder
from tactogram_studio.pages.studies.catalogue import pairs_of
from tactogram_studio.pages.studies.joining import JoinCard
from tactogram_studio.server.guard import REPORT_POLICY
from tactogram_studio.workspace.session_view import (
    ParticipantRow,
    SessionView,
    address_of,
    answers_rows,
    folder_of,
    peeking_text,
    report_of,
    view_of,
)
from tactogram_study.session.progress import NOT_BEGUN, status_label
from tactogram_study.workflows.answers import export_zip
from tactogram_study.workflows.sessions import simulate_session
from tactogram_study.workflows.stimuli import limited_lines

if TYPE_CHECKING:
    from tactogram_study.participants.sessions import OpenSession

UPDATE_S = 2.0
COLUMNS = ("participant", "trial", "question", "answer", "at (UTC)")
ALL = {"": "the whole study"}


def add(studio: Studio) -> None:
    """Register the page and its report."""

    @kit.route("/experiment/{session}")
    async def show(session: str, request: Request) -> None:
        navigation = not studio.study_only
        try:
            opened = studio.sessions.open(Path(folder_of(session)))
        except TactogramError as error:
            with kit.page("Experiment", navigation=navigation):
                if navigation:
                    ui.link("All studies", "/studies").classes("small")
                kit.alert(without_folder(error, studio.workspace.folder)).classes("card refused")
            return
        with kit.page(opened.study.title.in_english(), navigation=navigation):
            if navigation:
                ui.link("All studies", "/studies").classes("small")
            await ExperimenterPage(studio, opened, session, str(request.base_url).rstrip("/")).draw()

    @app.get("/experiment/{session}/report.html")
    def report(session: str) -> Response:
        path = report_of(studio.workspace.inside(folder_of(session)))
        if not path.is_file():
            raise DataError("no analysis yet; analyse the answers first")
        return FileResponse(path, headers={"Content-Security-Policy": REPORT_POLICY})


class ExperimenterPage:
    """One tab of a session, whose ``name`` is that of the address; ``server`` is the beginning of the tab's address."""

    def __init__(self, studio: Studio, session: OpenSession, name: str, server: str) -> None:
        self.studio, self.session, self.store = studio, session, session.store
        self.name, self.server = name, server
        self.folder = self.store.path.parent
        self.view: SessionView | None = None
        self.rows: dict[str, _RowView] = {}
        self.updating = asyncio.Lock()

    async def draw(self) -> None:
        """Draw the page, and keep it up to date."""
        self._about()
        with ui.element("div").classes("grid-people"):
            with ui.column().classes("w-full gap-4"):
                self._participants()
                self._latest_answers()
            with ui.column().classes("w-full gap-4"):
                self.joining = JoinCard(self.session, self.server, self.studio.roots, self.update)
                self._notes()
        self._results()
        await self.update()
        made_stimuli, stimuli = self.session.study.made_stimuli, self.session.stimuli
        self.simulated_stimuli.set_visibility(
            await kit.in_background(lambda: any(map(stimuli.is_simulated, made_stimuli)))
        )
        limited = await kit.in_background(stimuli.limited)
        with self.card:
            for line in limited_lines(limited):
                kit.hint(f"{line[:1].upper()}{line[1:]}.")
        ui.timer(UPDATE_S, self.update, immediate=False)

    async def update(self) -> None:
        """Show the present state; updates run one after the other, so that none shows an older state."""
        async with self.updating:
            self._show(await kit.in_background(view_of, self.store))

    def _show(self, view: SessionView) -> None:
        before, self.view = self.view, view
        self.summary.text = view.summary()
        # People and simulated participants are kept apart.
        self.joining.card.set_visibility(not view.simulated)
        self.ended.set_visibility(view.ended is not None)
        self.end_button.text = "Continue the study" if view.ended else "End the study"
        self._update_rows(view)
        if before is None or view.latest != before.latest:
            self.answers.clear()
            with self.answers:
                kit.table(COLUMNS, answers_rows(view.latest))
        if before is None or view.notes != before.notes:
            self._list_notes(view)
        options = ALL | {row.code: row.code for row in view.rows}
        if self.about.options != options:
            self.about.set_options(options, value=self.about.value if self.about.value in options else "")

    def _about(self) -> None:
        study = self.session.study
        practice = f", {study.practice.trials} of practice" if study.practice else ""
        with ui.element("section").classes("card w-full stack") as self.card:
            with ui.row().classes("items-center justify-between w-full"):
                self.summary = kit.heading("").props('aria-live="polite"')
                self.end_button = ui.button("End the study", on_click=self._end)
                self.end_button.props("outline")
            kit.hint(
                f"{study.design.kind}, up to {study.trials} trials{practice}; {study.display}, level {study.level}; "
                f"folder {self.studio.workspace.name_of(self.folder)}"
            )
            self.simulated_stimuli = ui.label("simulated stimuli").classes("simulated")
            self.simulated_stimuli.set_visibility(False)
            self.ended = ui.label("Ended: nobody can join, and unfinished participants cannot continue.")
            self.ended.classes("text-negative")
            for name, reason in self.session.failures.items():
                kit.alert(f"{name or 'A stimulus'} cannot be played: {reason}")

    def _participants(self) -> None:
        with kit.card("Participants", classes="w-full stack overflow-x-auto"):
            with ui.element("table").classes("people"):
                kit.table_head(["Code", "Status", "Progress", "Last answer", "Device", "Actions"])
                self.body = ui.element("tbody")
            self.nobody = ui.label("No participants yet: they join by the address under Take part.").classes(
                "quiet"
            )

    def _latest_answers(self) -> None:
        with kit.card(classes="w-full stack"), ui.expansion("Latest answers").classes("w-full"):
            kit.hint("Without conditions and correct answers, so that nothing here reveals the result.")
            self.answers = ui.column().classes("w-full")

    def _notes(self) -> None:
        with kit.card("Notes", classes="w-full stack"):
            kit.hint("Stored with the answers and exported. Do not write names.")
            self.about = ui.select(ALL, value="", label="About").classes("w-full")
            self.text = ui.textarea("Note").props("autogrow maxlength=4000").classes("w-full")
            ui.button("Add note", on_click=self._note).props("outline")
            self.notes = ui.column().classes("w-full gap-1")

    def _results(self) -> None:
        with kit.card("Answers", classes="w-full stack"):
            with ui.row().classes("items-center"):
                for kind, name in (("tables", "tables"), ("bids", "BIDS")):
                    button = ui.button(f"Download {name} (ZIP)").props("outline")
                    button.on_click(lambda e, kind=kind: self._download(kind, e.sender))
                ui.button("Analyse", on_click=lambda e: self._analyse(e.sender))
            self.report = ui.column()
            if report_of(self.folder).is_file():
                self._report_link("Open the last report")
            with ui.expansion("Simulated participants").classes("w-full"):
                kit.hint(
                    "Programs that take this study like people, in a separate folder: to test the study and its power. "
                    "They say nothing about touch."
                )
                with ui.row().classes("items-end"):
                    self.count = ui.number("How many", value=20, min=1, max=1000, precision=0)
                    self.effect = ui.input("True effect").props('placeholder="none, or d_prime=1"')
                    ui.button("Simulate", on_click=lambda e: self._simulate(e.sender)).props("outline")

    def _update_rows(self, view: SessionView) -> None:
        """Add and delete rows, and leave the others in place: a hand may be on one."""
        for code in self.rows.keys() - {row.code for row in view.rows}:
            self.rows.pop(code).row.delete()
        for index, row in enumerate(view.rows):
            if row.code not in self.rows:
                with self.body:
                    self.rows[row.code] = _RowView(row, self)
                self.rows[row.code].row.move(target_index=index)
            self.rows[row.code].update(row)
        self.nobody.set_visibility(not view.rows)

    def _list_notes(self, view: SessionView) -> None:
        self.notes.clear()
        with self.notes:
            for note in reversed(view.notes):
                about = note["participant"] or "the study"
                ui.label(f"{note['at'][:16].replace('T', ' ')} UTC, {about}: {note['text']}").classes(
                    "small whitespace-pre-wrap"
                )

    async def _note(self) -> None:
        # Emptied at once: the next note may be written while this one is stored.
        text, self.text.value = self.text.value or "", ""
        try:
            await kit.in_background(self.store.note, text, code=self.about.value or None)
        except Exception:
            self.text.value = self.text.value or text
            raise
        await self.update()

    async def _end(self) -> None:
        if await kit.in_background(lambda: self.store.ended):
            await kit.in_background(self.store.reopen_study)
        else:
            left = self.view.unfinished if self.view else 0
            who = f" {left} participants who have not finished can no longer answer." if left else ""
            question = f"End the study?{who} Answers so far are kept, and the study can be continued."
            if not await kit.confirm(question, "End the study"):
                return
            await kit.in_background(self.store.end)
        await self.update()

    async def _download(self, kind: Any, button: ui.button) -> None:
        with kit.busy("packing the answers", button=button):
            name, packed = await kit.in_background(export_zip, self.folder, kind=kind)
        ui.download.content(packed, name, "application/zip")

    async def _analyse(self, button: ui.button) -> None:
        view = await kit.in_background(view_of, self.store)
        warning = peeking_text(view)
        if warning and not await kit.confirm(warning, "Look anyway"):
            return
        from tactogram_study.workflows.analysis import analyse_study

        with kit.busy("analysing the answers", button=button):
            await kit.in_background(analyse_study, self.folder, report_of(self.folder).parent)
        if warning:
            await kit.in_background(self.store.note, f"Analysis viewed before the end: {view.summary()}")
        self._report_link("Open the new report")
        await self.update()

    def _report_link(self, text: str) -> None:
        self.report.clear()
        with self.report:
            ui.link(text, f"/experiment/{self.name}/report.html", new_tab=True)

    async def _simulate(self, button: ui.button) -> None:
        effect = pairs_of(self.effect.value, "True effect")
        count = int(self.count.value or 0)
        with kit.busy("simulating participants", button=button):
            result = await kit.in_background(simulate_session, self.folder, participants=count, effect=effect)
        name = self.studio.workspace.name_of(Path(result["folder"]))
        with self.report:
            ui.link(f"{count} simulated participants finished: open their session", address_of(name))


class _RowView:
    """One participant's row; its cells are updated in place, for fingers and screen readers."""

    def __init__(self, row: ParticipantRow, page: ExperimenterPage) -> None:
        self.code, self.page = row.code, page
        with ui.element("tr") as self.row:
            with ui.element("th").props('scope="row"'):
                ui.label(row.code)
                kit.mark_simulated(row.simulated)
            self.status = _cell()
            with ui.element("td"):
                self.place = ui.label()
                self.bar = ui.linear_progress(0, show_value=False, size="4px")
                self.bar.props(f'aria-label="Trials of {kit.attribute(row.code)}"')
            self.since = _cell()
            self.device = _cell("small quiet")
            with ui.element("td"), ui.row().classes("gap-1 no-wrap items-center"):
                address = page.joining.local_address(row.code)
                ui.link("pages", address, new_tab=True).props["aria-label"] = f"Pages of {row.code}"
                if not page.joining.loopback:
                    self._button("QR code", lambda: page.joining.show_qr_code(row.code))
                self.abort = self._button("Abort", self._abort)
                self._button("Withdraw", self._withdraw)

    def update(self, row: ParticipantRow) -> None:
        self.status.text = status_label(row.status)
        self.place.text = row.place
        self.bar.value = row.share
        self.since.text = row.since
        add, remove = ("text-negative", "") if row.quiet else ("", "text-negative")
        self.since.classes(add=add, remove=remove)
        self.device.text = row.device
        self.abort.text = "Reopen" if row.status == "aborted" else "Abort"
        self.abort.set_visibility(row.status in ("aborted", "active", NOT_BEGUN))

    def _button(self, text: str, handler: Callable[[], Any]) -> ui.button:
        button = ui.button(text, on_click=handler).props("flat dense")
        # Named by the code, since every row has the same buttons; the text of Abort changes.
        if text != "Abort":
            button.props["aria-label"] = f"{text} {self.code}"
        return button

    async def _abort(self) -> None:
        if self.abort.text == "Reopen":
            await kit.in_background(self.page.store.reopen, self.code)
        elif await kit.confirm(f"End the session of {self.code} now? It can be reopened.", "Abort"):
            await kit.in_background(self.page.store.abort, self.code)
        await self.page.update()

    async def _withdraw(self) -> None:
        question = (
            f"Delete all data of {self.code}? This cannot be undone. Earlier exports and analyses still contain them: "
            "delete those, and export again."
        )
        if await kit.confirm(question, f"Delete {self.code}"):
            await kit.in_background(self.page.store.withdraw, self.code)
        await self.page.update()


def _cell(classes: str = "") -> ui.label:
    with ui.element("td"):
        return ui.label().classes(classes)
