"""Card beside the editor's form: check, length, preview, saving, and the way to a session."""

from __future__ import annotations

from typing import TYPE_CHECKING

from nicegui import ui

from tactogram_studio import kit
from tactogram_studio.pages.studies.editor.check import DraftCheck, check_draft
from tactogram_studio.pages.studies.panels import begin_dialog
from tactogram_study.workflows.stimuli import limited_lines

if TYPE_CHECKING:
    from tactogram_studio.pages.studies.editor.page import StudyEditor

MOST_SHOWN = 5
"""Faults that are listed; the others are beside their fields."""


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
            found = await kit.in_background(check_draft, self.editor.draft, stimuli=True)
        if found.facts is None:
            self.editor.faults.show(found.faults)
            self.show(found, changed=self.editor.draft.changed, overtaken=False)
            return
        with self.faults:
            for line in limited_lines(found.facts["limited"]):
                ui.element("li")._text = line
        ui.notify(f"no problems; {len(found.facts['rendered'])} signals were made and rendered")
