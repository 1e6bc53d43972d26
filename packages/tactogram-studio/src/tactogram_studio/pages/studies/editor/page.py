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
from starlette.responses import RedirectResponse, Response

from tactogram.errors import DataError, TactogramError
from tactogram.validation import Fault
from tactogram_studio import kit
from tactogram_studio.context import Studio
from tactogram_studio.pages.studies.catalogue import begin_dialog
from tactogram_studio.pages.studies.editor import cards
from tactogram_studio.pages.studies.editor.cards import questions
from tactogram_studio.pages.studies.editor.stimuli_view import stimuli
from tactogram_studio.pages.studies.editor.widgets import Editor, part
from tactogram_studio.study_draft.draft import DraftCheck, StudyDraft, check_draft
from tactogram_study.study_file import Study
from tactogram_study.workflows.stimuli import limited_lines

MOST_SHOWN = 5
"""Faults that are listed; the others are beside their fields."""
SCROLLED = 'tabindex="0" role="group" aria-label="Content of the file"'
"""Lets keys scroll long lines."""


class SideCard:
    """State of the draft, and what can be done with it."""

    def __init__(self, editor: StudyEditor) -> None:
        self.editor = editor
        with kit.card(editor.name, classes="w-full stack"):
            self.state = ui.label("Checking …").classes("font-bold").props('role="status"')
            self.faults = ui.element("ul").classes("faults")
            self.size = ui.label()
            self.preview = ui.link("Preview a trial", f"/studies/preview/{editor.key}", new_tab=True)
            kit.hint("The participants' page with this form's content, in a new tab. Nothing is stored.")
            button = ui.button("Make and render every stimulus", on_click=self._render)
            self.render = button.props("outline dense")
            ui.separator()
            self.kept = ui.label().classes("small quiet").props('role="status"')
            self.comments = kit.hint("Saving from this page removes the comments and the layout of the file.")
            self.comments.set_visibility(editor.draft.has_comments)
            with ui.row().classes("gap-2"):
                self.save = ui.button("Save", on_click=self._save)
                self.discard = ui.button("Discard changes", on_click=self._discard)
                self.discard.props("outline")
            self.begin = ui.button("Begin a session", on_click=self._begin).props("outline")

    def show(self, check: DraftCheck, *, changed: bool, overtaken: bool) -> None:
        """Show the result of a check, and whether the draft differs from the file."""
        count, facts = len(check.faults), check.facts
        self.state.text = "Valid" if not count else f"{count} problem{'s' if count > 1 else ''}"
        self.state.classes(add="text-negative" if count else "", remove="" if count else "text-negative")
        self.faults.clear()
        with self.faults:
            for fault in check.faults[:MOST_SHOWN]:
                ui.element("li")._text = fault.sentence
            if count > MOST_SHOWN:
                ui.element("li")._text = f"and {count - MOST_SHOWN} more"
        practice = f", {facts['practice']} of practice" if facts and facts["practice"] else ""
        self.size.text = ""
        if facts:
            size = f"Up to {facts['trials']} trials{practice}, {facts['stimuli']} stimuli"
            self.size.text = f"{size}; about {facts['minutes']:.0f} minutes"
            if untranslated := facts["missing_texts"]:
                self.size.text += (
                    f". Buttons and instructions of the pages are partly English in {', '.join(untranslated)}"
                )
        self.preview.set_visibility(not count)
        for button in (self.save, self.begin, self.render):
            button.set_enabled(not count)
        self.discard.set_visibility(changed)
        self.begin.text = "Save and begin a session" if changed else "Begin a session"
        unsaved = "The file was changed elsewhere. " if overtaken else ""
        self.kept.text = unsaved + ("Not saved yet; kept for this browser." if changed else "Saved.")

    async def _save(self) -> bool:
        draft = self.editor.draft
        if draft.overtaken and not await kit.confirm(
            "The file was changed elsewhere since you opened it. Replace it by the content of this page?",
            "Replace it",
        ):
            return False
        draft.save()
        self.comments.set_visibility(False)
        self.editor.saved()
        return True

    async def _discard(self) -> None:
        if await kit.confirm("Discard all changes since the last save?", "Discard them"):
            self.editor.revert()

    async def _begin(self) -> None:
        draft = self.editor.draft
        if draft.changed and not await self._save():
            return
        begin_dialog(self.editor.studio, draft.path, title=self.editor.name, name=draft.values["name"])

    async def _render(self) -> None:
        with kit.busy("making and rendering every stimulus", button=self.render):
            check = await kit.in_background(check_draft, self.editor.draft, stimuli=True)
        if check.facts is None:
            self.editor.faults.show(check.faults)
            self.show(check, changed=self.editor.draft.changed, overtaken=False)
            return
        with self.faults:
            for line in limited_lines(check.facts["limited"]):
                ui.element("li")._text = line
        ui.notify(f"no problems; {len(check.facts['rendered'])} signals were made and rendered")


def add(studio: Studio) -> None:
    """Register the page and the way to its previews."""
    editors: WeakValueDictionary[str, StudyEditor] = WeakValueDictionary()

    @kit.route("/studies/edit")
    async def show(study: str = "") -> None:
        with kit.page("Studies"):
            ui.link("All studies", "/studies")
            path = studio.workspace.inside(study)
            if not path.is_file():
                raise DataError(
                    f"{study[:200]}: no such study in this workspace; copy one on the page Studies"
                )
            editor = StudyEditor(studio, path)
            editors[editor.key] = editor
            editor.draw()

    @app.get("/studies/preview/{key}")
    def preview(key: str) -> Response:
        editor = editors.get(key)
        if editor is None:
            raise DataError("The editor of this study was closed; open it again.")
        shown = Study.of(editor.draft.values)
        return RedirectResponse(studio.sessions.preview(shown, editor.draft.path), status_code=303)


class StudyEditor(Editor):
    """One tab."""

    def __init__(self, studio: Studio, path: Path) -> None:
        super().__init__(studio, path)
        self.key = secrets.token_urlsafe(12)
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
        self.check()

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

    def saved(self) -> None:
        """Forget the kept draft: it is the file now."""
        self.drafts.pop(self.name, None)
        self.check()

    def revert(self) -> None:
        """Replace the draft by the file."""
        self.drafts.pop(self.name, None)
        self.draft = StudyDraft.open(self.draft.path)
        self.redraw()
        self.check()

    def check(self) -> None:
        """Check the draft, and show the result."""
        self.version += 1
        background_tasks.create(self._show_check(self.version))

    async def _show_check(self, version: int) -> None:
        """Check the draft and show the result, unless it was changed in the meantime."""
        async with self.checking:
            if version != self.version:
                return
            snapshot = copy.deepcopy(self.draft)
            try:
                check = await kit.in_background(check_draft, snapshot)
                changed, overtaken = snapshot.changed, snapshot.overtaken
            except TactogramError as error:  # the file is gone, or a text editor broke it
                check, changed, overtaken = DraftCheck((Fault((), str(error)),)), True, True
            if version == self.version and not self.form.is_deleted:
                self.faults.show(check.faults)
                self.side.show(check, changed=changed, overtaken=overtaken)

    def _file(self, redraw: Any) -> None:
        ui.label("What is saved; to be changed with the form above.").classes("small quiet")
        with ui.element("div").classes("power").props(SCROLLED):
            ui.element("pre")._text = self.draft.toml
        ui.button("Show it as it is now", on_click=redraw).props("outline dense")
