"""Preview of an import on its page: the layouts with their pictures, and the files that would be skipped."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from functools import partial
from typing import Any

from nicegui import ui

from tactogram.datasets import (
    Recording,
    in_one_line,
    layouts_by_columns,
    preview_dataset,
    preview_file,
)
from tactogram.errors import TactogramError
from tactogram.signal.io import TableLayout
from tactogram_studio import kit
from tactogram_studio.pages.materials.layout_card import LayoutCard
from tactogram_studio.workspace.imports import ImportSettings, by_key, headings_of

MOST_LAYOUTS = 30
MOST_SHOWN = 200
"""Kinds of skipped files, and materials, that the page lists."""


class _SupersededError(Exception):
    """Raised within a preview whose result is no longer wanted."""


class PreviewView:
    """Preview of a folder, read again whenever its settings change; ``answer`` takes a pattern of its paths."""

    def __init__(self, settings: ImportSettings, answer: Callable[[str], None]) -> None:
        self.settings, self._answer = settings, answer
        self.facts: dict[str, Any] = {}
        self._generation = 0
        self._cards: list[LayoutCard] = []
        self._progress = (0, 1)

    def draw_summary(self) -> None:
        """Draw the place of progress, summary and errors."""
        self._bar = ui.linear_progress(value=0, show_value=False, size="6px")
        self._bar.props('aria-label="Progress of the preview"')
        self._summary = ui.column().classes("gap-1").props('role="status"')
        self.problem = kit.alert()

    def draw(self) -> None:
        """Draw the places of layouts and skipped files, and begin to read."""
        self._place = kit.column()
        self._skipped = kit.column()
        ui.timer(0.3, self._show_progress)
        ui.timer(0, self.refresh, once=True)

    async def refresh(self, first: LayoutCard | None = None) -> None:
        """Read the files, and show how, with the picture of one card before; a later call supersedes this one."""
        self._generation += 1
        mine, settings = self._generation, self.settings
        self.problem.text = ""

        def report(done: int, total: int) -> None:
            if mine != self._generation:
                raise _SupersededError
            self._progress = (done, total)

        try:
            path, options, kind = settings.path, settings.options(), settings.values["set"]
            self._bar.visible = True
            if first is not None:
                first.show(await kit.in_background(self._example, first.example, options))
            facts = await kit.in_background(
                preview_dataset, kind, path, options=options, workers=1, progress=report
            )
            names = [layout["example"] for layout in facts["layouts"][:MOST_LAYOUTS]]
            examples = await kit.in_background(lambda: {name: self._example(name, options) for name in names})
        except _SupersededError:
            return
        except (TactogramError, OSError, ValueError) as error:
            if mine == self._generation:
                self._bar.visible = False
                self.problem.text = self._short(str(error))
            return
        if mine == self._generation and not self._place.is_deleted:
            self._bar.visible = False
            self.facts = facts
            self._show(examples)

    def _example(self, name: str, options: Mapping[str, Any]) -> Recording | str:
        """Return a file as it would be imported, or why it cannot be."""
        try:
            return preview_file(self.settings.values["set"], self.settings.path, name, options=options)
        except TactogramError as error:
            return self._short(str(error))

    def _short(self, text: str) -> str:
        """Return a message with file names relative to the folder."""
        return text.replace(f"{self.settings.path}/", "")

    async def _map(self, number: int, layouts: Sequence[TableLayout]) -> None:
        self.settings.map_columns(layouts)
        await self.refresh(self._cards[number])

    def _show_progress(self) -> None:
        done, total = self._progress
        self._bar.value = done / max(1, total)

    def _show(self, examples: Mapping[str, Recording | str]) -> None:
        """Show the preview; cards whose files are still there stay, so that the keyboard's focus stays."""
        facts, mapped = self.facts, layouts_by_columns(self.settings.layouts)
        self._show_summary()
        drawn = [card.key for card in self._cards]
        layouts = by_key(facts["layouts"][:MOST_LAYOUTS])
        if {*drawn} != {*layouts}:
            self._place.clear()
            self._cards = [
                LayoutCard(
                    number + 1,
                    key,
                    each,
                    mapped.get(headings_of(each), []),
                    partial(self._map, number) if self.settings.is_folder else None,
                )
                for number, (key, each) in enumerate(layouts.items())
            ]
            with self._place:
                for card in self._cards:
                    card.draw()
                if (more := len(facts["layouts"]) - len(layouts)) > 0:
                    kit.hint(f"… and {more} more layouts, of fewer files; a mapping can describe them, too")
        for card in self._cards:
            card.update(layouts[card.key])
            card.show(examples[card.example])
        self._show_skipped()

    def _show_summary(self) -> None:
        facts = self.facts
        materials: dict[str, int] = {}
        for layout in facts["layouts"]:
            for name, count in layout["materials"].items():
                materials[name] = materials.get(name, 0) + count
        counted = f"{sum(materials.values())} recordings of {len(materials)} materials would be imported"
        counted += f" from {facts['files']} files; {facts['skipped_files']} would be skipped"
        counted += f"; {facts['photographs']} photographs" if facts["photographs"] else ""
        counted += f"; {facts['duplicates']} files repeat another" if facts["duplicates"] else ""
        self._summary.clear()
        with self._summary:
            ui.label(f"{counted}.")
            listed = [f"{name} ({count})" for name, count in [*materials.items()][:MOST_SHOWN]]
            kit.hint(", ".join(listed)).style("overflow-wrap: anywhere")
            patterns = [facts["proposed_path"]]
            if facts["question"]:
                ui.label(self._short(facts["question"])).classes("text-negative")
                patterns = [remedy.value for remedy in facts["question"].remedies]
            elif facts["proposed_path"]:
                kit.hint("The paths may also name:")
            with ui.row().classes("gap-2"):
                for pattern in filter(None, patterns):
                    button = ui.button(pattern, on_click=partial(self._answer, pattern))
                    button.props("outline dense")
            for note in facts["notes"]:
                kit.hint(self._short(in_one_line(note)))
            for stream, rates in facts["several_rates_hz"].items():
                rates_text = ", ".join(f"{rate:.7g}" for rate in rates)
                kit.hint(
                    f"{stream}: {rates_text} Hz; a training needs one rate: enter it for each layout, or there."
                )

    def _show_skipped(self) -> None:
        problems = self.facts["problems"]
        self._skipped.clear()
        if not problems:
            return
        with self._skipped, ui.element("section").classes("card w-full").props('aria-label="Skipped files"'):
            kit.heading(f"Skipped ({len(self.facts['skipped'])})")
            with ui.element("ul").classes("skipped"):
                for kind in problems[:MOST_SHOWN]:
                    ui.element("li")._text = self._short(in_one_line(kind))
            if len(problems) > MOST_SHOWN:
                kit.hint(f"… and {len(problems) - MOST_SHOWN} more kinds")
