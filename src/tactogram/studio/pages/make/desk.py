"""State of the page Make: the form as filled in, its history, and the results shown."""

from __future__ import annotations

import hashlib
from collections.abc import MutableMapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from tactogram.errors import ParameterError, TactogramError
from tactogram.signal import Image, Signal
from tactogram.signal.io import write_image
from tactogram.studio.pages.make.form import FormHistory, GenerationForm, GenerationRequest, command, suited
from tactogram.studio.pages.make.runs import FinishedRun, RunCatalogue
from tactogram.studio.workspace.folder import Workspace
from tactogram.studio.workspace.shelf import KeptResult, ResultArchive

MOST_BESIDE = 6
MOST_LISTED = 12
"""Earlier results that are offered."""
MOST_HELD = 60
"""Results that are held until they are kept; the oldest go first."""


@dataclass
class MakePageState:
    """The state of one browser's page, in a mapping that outlives the page.

    Parameters
    ----------
    workspace : Workspace
    shelf : Shelf
        Kept results.
    runs : Runs
    held : mutable mapping
        JSON values; what is written into it is there after a reload.
    """

    workspace: Workspace
    shelf: ResultArchive
    runs: RunCatalogue
    held: MutableMapping[str, Any]
    asked: GenerationRequest = field(default_factory=GenerationRequest)
    committed: GenerationRequest = field(default_factory=GenerationRequest)
    history: FormHistory = field(default_factory=FormHistory)
    choice: FinishedRun | None = None

    def __post_init__(self) -> None:
        self.made = ResultArchive(self.workspace.studio_folder / "made")
        self.asked = GenerationRequest.of(self.held.get("asked") or {})
        past, future = self.held.get("past") or (), self.held.get("future") or ()
        self.history = FormHistory(tuple(past), tuple(future))
        self._find(self.asked.run)
        self.committed = self.asked

    @property
    def form(self) -> GenerationForm | None:
        """The form of the chosen run; None where there is no run at all."""
        return None if self.choice is None else self.choice.form

    # -- the form ----------------------------------------------------------------------------------------

    def choose(self, run: str) -> None:
        """Choose another run; what its form does not have is left out, and undone together."""
        self._find(run)
        self.commit()

    def _find(self, run: str) -> None:
        choice = None
        if run:
            try:
                choice = self.runs.choice(run)
                form = choice.form
            except TactogramError:  # deleted since, or another kind
                choice = None
        if choice is None:
            choice = next(iter(self.runs.choices()), None)
        if choice is not None:
            form = choice.form
            self.asked = suited(self.asked.with_changes(run=choice.name), form)
        self.choice = choice

    def set(self, **changes: Any) -> None:
        """Change the form without making it a step that is undone, as while a slider is moved."""
        self.asked = self.asked.with_changes(**changes)

    def commit(self) -> bool:
        """Make what was changed a step that can be undone, and keep it; tell whether there was any."""
        changed = self.asked != self.committed
        if changed and self.committed.run:
            self.history = self.history.after(self.committed.as_dict())
        self.committed = self.asked
        self._keep()
        return changed

    def undo(self) -> None:
        """Go a step back."""
        self.commit()
        self.history, state = self.history.undone(self.asked.as_dict())
        self._go_to(state)

    def redo(self) -> None:
        """Go a step forth."""
        self.history, state = self.history.redone(self.asked.as_dict())
        self._go_to(state)

    def _go_to(self, state: Any) -> None:
        self.asked = GenerationRequest.of(state)
        self._find(self.asked.run)
        self.committed = self.asked
        self._keep()

    def _keep(self) -> None:
        self.held["asked"] = self.asked.as_dict()
        self.held["past"], self.held["future"] = list(self.history.past), list(self.history.future)

    def photo_file(self, asked: GenerationRequest) -> str:
        """Return the file of the chosen part of the photograph, relative to the workspace; it is made."""
        if not asked.photo or asked.crop is None:
            return asked.photo
        of = hashlib.sha256(f"{asked.photo} {asked.crop}".encode()).hexdigest()[:8]
        whole = self.workspace.inside(asked.photo)
        file = whole.with_name(f"{whole.stem}-part-{of}.png")
        if not file.is_file():
            write_image(file, self.runs.photograph(asked))
        return self.workspace.name_of(file)

    def command(self) -> str:
        """Return the command line that makes the same, run in the workspace."""
        if self.form is None:
            return ""
        return command(self.asked, self.form, photo=self.photo_file(self.asked))

    # -- results -----------------------------------------------------------------------------------------

    def put(
        self, asked: GenerationRequest, choice: FinishedRun, number: int, made: Signal | Image
    ) -> KeptResult:
        """Hold a result so that it outlives the page, and return it."""
        title = f"{asked.text}, seed {asked.seed}" + (f" ({number})" if asked.count > 1 else "")
        facts = {
            "what": "made",
            "run": choice.name,
            "run_id": choice.data.get("run_id"),
            "model": choice.facts.name,
            "condition": asked.as_dict(),
            "seed": asked.seed,
            "number": number,
            "simulated": choice.kind.simulated,
            "command": command(asked, choice.form, photo=self.photo_file(asked)),
        }
        held = self.made.keep(made, title=title, facts=facts)
        for old in self.made.all()[MOST_HELD:]:
            self.made.remove(old.id)
        return held

    def show(self, results: list[KeptResult]) -> None:
        """Show new results: the first as the present one, all in the list of earlier ones."""
        ids = [made.id for made in results]
        self.held["listed"] = [*ids, *self.held.get("listed", [])][:MOST_LISTED]
        if ids:
            self.held["present"] = f"made:{ids[0]}"

    def current_result(self) -> KeptResult | None:
        """Return the result that is shown large; None where there is none."""
        return self.find(str(self.held.get("present") or ""))

    def select_result(self, name: str) -> None:
        """Show an earlier result as the present one."""
        self.held["present"] = name

    def results(self) -> list[KeptResult]:
        """Return the results of this page, newest first."""
        found = (self.find(f"made:{id}") for id in self.held.get("listed", []))
        return [made for made in found if made is not None]

    def compared(self) -> list[tuple[str, KeptResult]]:
        """Return what the present result is compared with, by name."""
        found = [(name, self.find(name)) for name in self.held.get("beside", [])]
        return [(name, made) for name, made in found if made is not None]

    def add_comparison(self, name: str) -> None:
        """Put a result beside the present one.

        Raises
        ------
        ParameterError
            If there are too many.
        """
        held = [other for other, _ in self.compared()]
        if name in held:
            return
        if len(held) >= MOST_BESIDE:
            raise ParameterError(f"At most {MOST_BESIDE} stand beside: take one away first.")
        self.held["beside"] = [*held, name]

    def remove_comparison(self, name: str) -> None:
        """Take a result away from beside."""
        self.held["beside"] = [other for other in self.held.get("beside", []) if other != name]

    def find(self, name: str) -> KeptResult | None:
        """Return a result by its name: ``made:ID`` or ``kept:ID``; None if it is gone."""
        where, _, id = name.partition(":")
        try:
            return {"made": self.made, "kept": self.shelf}[where].get(id)
        except (KeyError, TactogramError):
            return None

    def record_kept(self, name: str, kept: KeptResult) -> None:
        """Note as what a result lies on the shelf."""
        self.held["kept"] = {**self.held.get("kept", {}), name: kept.id}

    def rename(self, name: str, title: str) -> None:
        """Give a result another title, where it lies on the shelf and here.

        Raises
        ------
        ParameterError
            If the title is empty.
        """
        for each in (name, f"kept:{self.kept_id(name)}"):
            where, _, id = each.partition(":")
            if self.find(each) is not None:
                (self.made if where == "made" else self.shelf).rename(id, title)

    def kept_id(self, name: str) -> str:
        """Return the id under which a result was kept; empty if it was not, or no longer is."""
        id = str(self.held.get("kept", {}).get(name, ""))
        return id if id and self.find(f"kept:{id}") is not None else ""

    def photographs(self) -> Path:
        """Return where chosen photographs are put."""
        return self.workspace.studio_folder / "photos"

    def vibrations(self) -> Path:
        """Return where chosen vibrations are put."""
        return self.workspace.studio_folder / "vibrations"
