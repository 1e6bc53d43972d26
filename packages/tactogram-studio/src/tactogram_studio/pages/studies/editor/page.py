"""The editor of a study's file: forms, its check while one writes, a preview, and the way to a session."""

from __future__ import annotations

import asyncio
import copy
import secrets
from functools import partial
from pathlib import Path
from typing import Any
from weakref import WeakValueDictionary

from nicegui import app, background_tasks, ui
from starlette.responses import PlainTextResponse, RedirectResponse, Response

from tactogram.errors import DataError, TactogramError
from tactogram.validation import Fault
from tactogram_studio import kit
from tactogram_studio.context import Studio
from tactogram_studio.pages.studies.editor import cards
from tactogram_studio.pages.studies.editor.check import DraftCheck, check_draft
from tactogram_studio.pages.studies.editor.draft import Place, StudyDraft
from tactogram_studio.pages.studies.editor.questions_view import questions
from tactogram_studio.pages.studies.editor.side import SideCard
from tactogram_studio.pages.studies.editor.stimuli_view import stimuli
from tactogram_studio.pages.studies.editor.widgets import FaultMarks, part
from tactogram_study.study_file import Study

STATE = "studies_edited"
"""Key of the drafts in the browser's storage, by file."""
SCROLLED = 'tabindex="0" role="group" aria-label="Content of the file"'
"""Lets keys scroll long lines."""


def add(studio: Studio) -> None:
    """Register the page and the way to its previews."""
    editors: WeakValueDictionary[str, StudyEditor] = WeakValueDictionary()

    @kit.route("/studies/edit")
    async def show(study: str = "") -> None:
        with kit.page("Studies"):
            ui.add_head_html('<link rel="stylesheet" href="/static/experiment.css">')
            ui.link("All studies", "/studies")
            try:
                path = studio.workspace.inside(study)
                if not path.is_file():
                    raise DataError(
                        f"{study[:200]}: no such study in this workspace; copy one on the page Studies"
                    )
                editor = StudyEditor(studio, path)
            except TactogramError as error:
                kit.alert(str(error))
                return
            editors[editor.key] = editor
            editor.draw()

    @app.get("/studies/preview/{key}")
    def preview(key: str) -> Response:
        editor = editors.get(key)
        if editor is None:
            return PlainTextResponse("The editor of this study was closed; open it again.", status_code=404)
        try:
            shown = Study.of(editor.draft.values)
            return RedirectResponse(studio.sessions.preview(shown, editor.draft.path), status_code=303)
        except TactogramError as error:
            return PlainTextResponse(str(error), status_code=409)


class StudyEditor:
    """One tab with the draft of a study's file, which survives a reload."""

    def __init__(self, studio: Studio, path: Path) -> None:
        self.studio, self.name = studio, studio.workspace.name_of(path)
        self.key = secrets.token_urlsafe(12)
        self.drafts: dict[str, Any] = app.storage.user.setdefault(STATE, {})
        self.draft = StudyDraft.open(path, self.drafts.get(self.name))
        self.faults = FaultMarks()
        self.version = 0
        self.checking = asyncio.Lock()

    def draw(self) -> None:
        """Draw the page."""
        with ui.element("div").classes("editing"):
            with ui.element("aside").props('aria-label="State of the study"').classes("side"):
                self.side = SideCard(self)
            with kit.column():
                self.form = kit.column()
                self.redraw()
        self._check()

    def redraw(self) -> None:
        """Draw the whole form anew."""
        self.form.clear()
        with self.form:
            cards.about(self)
            cards.trials(self)
            if cards.has_words(self):
                part(partial(cards.words, self))
            part(partial(stimuli, self))
            cards.playing(self)
            for title, draw in (
                ("Questions before the trials", partial(questions, self, "before")),
                ("Questions after the trials", partial(questions, self, "after")),
                ("Practice", partial(cards.practice, self)),
                ("Analysis", partial(cards.analysis, self)),
                ("The file (TOML)", self._file),
            ):
                with kit.card(), ui.expansion(title).classes("w-full"):
                    part(draw)

    def put(self, place: Place, value: Any) -> None:
        """Change the draft at a place, where None removes, and check it."""
        self.draft.set(place, value)
        self.changed()

    def changed(self) -> None:
        """Keep the draft and check it."""
        self.drafts[self.name] = self.draft.to_store()
        self._check()

    def saved(self) -> None:
        """Forget the kept draft: it is the file now."""
        self.drafts.pop(self.name, None)
        self._check()

    def revert(self) -> None:
        """Replace the draft by the file."""
        self.drafts.pop(self.name, None)
        self.draft = StudyDraft.open(self.draft.path)
        self.redraw()
        self._check()

    def _check(self) -> None:
        self.version += 1
        background_tasks.create(self._show_check(self.version))

    async def _show_check(self, version: int) -> None:
        """Check the draft and show the result, unless it was changed in the meantime."""
        async with self.checking:
            if version != self.version:
                return
            snapshot = copy.deepcopy(self.draft)
            try:
                found = await kit.in_background(check_draft, snapshot)
                changed, overtaken = snapshot.changed, snapshot.overtaken
            except TactogramError as error:  # the file is gone, or a text editor broke it
                found, changed, overtaken = DraftCheck((Fault((), str(error)),)), True, True
            if version == self.version and not self.form.is_deleted:
                self.faults.show(found.faults)
                self.side.show(found, changed=changed, overtaken=overtaken)

    def _file(self, redraw: Any) -> None:
        ui.label("What is saved; to be changed with the form above.").classes("small quiet")
        with ui.element("div").classes("power").props(SCROLLED):
            ui.element("pre")._text = self.draft.toml
        ui.button("Show it as it is now", on_click=redraw).props("outline dense")
