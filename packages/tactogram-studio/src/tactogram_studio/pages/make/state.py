"""State of the page Make in one browser: the form with its history, and the results shown."""

from __future__ import annotations

import hashlib
from collections.abc import Mapping, MutableMapping
from contextlib import suppress
from dataclasses import asdict, replace
from typing import Any

from tactogram.errors import ParameterError, TactogramError
from tactogram.signal import Image, Signal
from tactogram.signal.io import write_image
from tactogram_studio.pages.make.form import (
    FormHistory,
    GenerationForm,
    GenerationRequest,
    adapted,
    command,
)
from tactogram_studio.pages.make.runs import FinishedRun, RunCatalogue
from tactogram_studio.workspace.folder import Workspace
from tactogram_studio.workspace.shelf import KeptResult, ResultArchive

MOST_COMPARED = 6
MOST_LISTED = 12
"""Number of earlier results in the list."""
MOST_STORED = 60
"""Number of unkept results on disk; the oldest are deleted first."""


class MakePageState:
    """State of one browser's page.

    ``storage`` has JSON values that survive a reload, with results by name: ``made:ID`` in the archive ``made`` of
    unkept results, or ``kept:ID`` on the shelf. ``request`` is the form as shown, ``committed`` the last undoable one.
    """

    def __init__(
        self,
        workspace: Workspace,
        shelf: ResultArchive,
        runs: RunCatalogue,
        storage: MutableMapping[str, Any],
    ) -> None:
        self.workspace, self.shelf, self.runs, self.storage = workspace, shelf, runs, storage
        self.made = ResultArchive(workspace.studio_folder / "made")
        self.photographs = workspace.studio_folder / "photos"
        self.vibrations = workspace.studio_folder / "vibrations"
        self.motions = workspace.studio_folder / "motions"
        self.history = FormHistory(tuple(storage.get("past") or ()), tuple(storage.get("future") or ()))
        self.request = GenerationRequest.from_stored(storage.get("asked") or {})
        self.run: FinishedRun | None = None
        self._select_run(self.request.run)
        self.committed = self.request

    @property
    def form(self) -> GenerationForm | None:
        """The form of the chosen run, if any."""
        return None if self.run is None else self.run.form

    # -- the form ----------------------------------------------------------------------------------------

    def choose(self, run: str) -> None:
        """Choose another run, as one undoable step; values that its form lacks are dropped."""
        self._select_run(run)
        self.commit()

    def _select_run(self, name: str) -> None:
        """Choose a run, or the newest one if it is missing or generates nothing."""
        run = None
        if name:
            with suppress(TactogramError):
                candidate = self.runs.get(name)
                _ = candidate.form  # raises if it generates nothing
                run = candidate
        self.run = run or next(iter(self.runs.finished()), None)
        if self.run is not None:
            self.request = adapted(replace(self.request, run=self.run.name), self.run.form)

    def set(self, **changes: Any) -> None:
        """Change the form without an undoable step, as while a slider moves."""
        self.request = replace(self.request, **changes)

    def commit(self) -> bool:
        """Make the changes an undoable step and store them; return whether there were any."""
        changed = self.request != self.committed
        if changed and self.committed.run:
            self.history = self.history.after(asdict(self.committed))
        self.committed = self.request
        self._store_form()
        return changed

    def undo(self) -> None:
        """Undo the last step."""
        self.commit()
        self.history, form = self.history.undone(asdict(self.request))
        self._restore(form)

    def redo(self) -> None:
        """Redo the last undone step."""
        self.history, form = self.history.redone(asdict(self.request))
        self._restore(form)

    def _restore(self, form: Any) -> None:
        self.request = GenerationRequest.from_stored(form)
        self._select_run(self.request.run)
        self.committed = self.request
        self._store_form()

    def _store_form(self) -> None:
        self.storage["asked"] = asdict(self.request)
        self.storage["past"], self.storage["future"] = list(self.history.past), list(self.history.future)

    def photo_file(self, request: GenerationRequest) -> str:
        """Return the file of the cropped photograph, relative to the workspace; write it if it is missing."""
        if not request.photo or request.crop is None:
            return request.photo
        digest = hashlib.sha256(f"{request.photo} {request.crop}".encode()).hexdigest()[:8]
        whole = self.workspace.inside(request.photo)
        file = whole.with_name(f"{whole.stem}-part-{digest}.png")
        if not file.is_file():
            write_image(file, self.runs.photograph(request))
        return self.workspace.name_of(file)

    def command(self) -> str:
        """Return the equivalent command, to be run in the workspace."""
        if self.form is None:
            return ""
        return command(self.form.used(self.request), self.form, photo=self.photo_file(self.request))

    # -- results -----------------------------------------------------------------------------------------

    def store_result(
        self,
        request: GenerationRequest,
        run: FinishedRun,
        number: int,
        made: Signal | Image,
        said: Mapping[str, Any] | None = None,
    ) -> KeptResult:
        """Store and return a generated result with what is said of it; the oldest unkept are deleted.

        ``said`` is that of `RunCatalogue.said`.
        """
        request = run.form.used(request)
        title = f"{request.title}, seed {request.seed}" + (f" ({number})" if request.count > 1 else "")
        facts = {
            "what": "made",
            "run": run.name,
            "run_id": run.data.get("run_id"),
            "model": run.model.name,
            "condition": asdict(request),
            "seed": request.seed,
            "number": number,
            "simulated": run.kind.simulated,
            "command": command(request, run.form, photo=self.photo_file(request)),
            **(said or {}),
        }
        result = self.made.keep(made, title=title, facts=facts)
        for old in self.made.all()[MOST_STORED:]:
            self.made.remove(old.id)
        return result

    def show(self, results: list[KeptResult]) -> None:
        """Show the first of new results, and list all of them."""
        ids = [result.id for result in results]
        self.storage["listed"] = [*ids, *self.storage.get("listed", [])][:MOST_LISTED]
        if ids:
            self.select_result(f"made:{ids[0]}")

    def current_result(self) -> KeptResult | None:
        """Return the result that is shown first."""
        return self.find(str(self.storage.get("present") or ""))

    def select_result(self, name: str) -> None:
        """Show a result first."""
        self.storage["present"] = name

    def results(self) -> list[KeptResult]:
        """Return the listed results, newest first."""
        listed = (self.find(f"made:{id}") for id in self.storage.get("listed", []))
        return [result for result in listed if result is not None]

    def compared(self) -> list[tuple[str, KeptResult]]:
        """Return the results next to the first one, with their names."""
        named = [(name, self.find(name)) for name in self.storage.get("beside", [])]
        return [(name, result) for name, result in named if result is not None]

    def add_comparison(self, name: str) -> None:
        """Show a result next to the first one; raise `ParameterError` if there are too many."""
        names = [other for other, _ in self.compared()]
        if name in names:
            return
        if len(names) >= MOST_COMPARED:
            raise ParameterError(f"At most {MOST_COMPARED} results can be compared: remove one first.")
        self.storage["beside"] = [*names, name]

    def remove_comparison(self, name: str) -> None:
        """Show a result no longer next to the first one."""
        self.storage["beside"] = [other for other in self.storage.get("beside", []) if other != name]

    def find(self, name: str) -> KeptResult | None:
        """Return a result by name, or None if it no longer exists."""
        where, _, id = name.partition(":")
        try:
            return {"made": self.made, "kept": self.shelf}[where].get(id)
        except (KeyError, TactogramError):
            return None

    def record_kept(self, name: str, kept: KeptResult) -> None:
        """Note the copy of a result on the shelf."""
        self.storage["kept"] = {**self.storage.get("kept", {}), name: kept.id}

    def rename(self, name: str, title: str) -> None:
        """Rename a result and its copy on the shelf; raise `ParameterError` for an empty title."""
        for each in (name, f"kept:{self.kept_id(name)}"):
            where, _, id = each.partition(":")
            if self.find(each) is not None:
                (self.made if where == "made" else self.shelf).rename(id, title)

    def kept_id(self, name: str) -> str:
        """Return the id of a result's copy on the shelf; empty if there is none."""
        id = str(self.storage.get("kept", {}).get(name, ""))
        return id if id and self.find(f"kept:{id}") is not None else ""
