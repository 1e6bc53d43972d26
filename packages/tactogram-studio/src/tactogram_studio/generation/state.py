"""State of the page Make in one browser: the form with its history, and the results shown."""

from __future__ import annotations

from collections.abc import Callable, Mapping, MutableMapping
from contextlib import suppress
from dataclasses import asdict, replace
from typing import Any

from tactogram.errors import ParameterError, TactogramError
from tactogram.signal import Image, Signal
from tactogram_studio.generation.form import (
    GenerationForm,
    GenerationRequest,
    adapted,
    command,
    form_of_run,
)
from tactogram_studio.generation.runs import GeneratingRuns
from tactogram_studio.workspace.folder import Workspace
from tactogram_studio.workspace.runs import FinishedRun
from tactogram_studio.workspace.shelf import KeptResult, ResultArchive

PRESSED = "pressed"
"""Entry of the storage: a button of another page asked for a result, which the page Make generates once.

No address does that: a link of any site could then start work."""
MOST_COMPARED = 6
MOST_LISTED = 12
"""Number of earlier results in the list."""
MOST_STEPS = 50
"""Steps that can be undone."""
MOST_STORED = 60
"""Number of unkept results on disk; the oldest are deleted first."""


class MakePageState:
    """State of one browser's page.

    ``storage`` has JSON values that survive a reload: forms (``past``, ``asked``, ``future``), and results by name:
    ``made:ID`` in the archive ``made`` of unkept results, or ``kept:ID`` on the shelf. ``request`` is the form as
    shown, ``committed`` the last undoable one, and ``failure`` says why the last generation gave nothing. The
    page sets ``on_change``, which gets whether the form is to be drawn anew, and ``redraw_results``.
    """

    def __init__(
        self,
        workspace: Workspace,
        shelf: ResultArchive,
        runs: GeneratingRuns,
        storage: MutableMapping[str, Any],
    ) -> None:
        self.workspace, self.shelf, self.runs, self.storage = workspace, shelf, runs, storage
        self.made = ResultArchive(workspace.studio_folder / "made")
        self.photographs = workspace.studio_folder / "photos"
        self.vibrations = workspace.studio_folder / "vibrations"
        self.motions = workspace.studio_folder / "motions"
        self.run: FinishedRun | None = None
        self.request = self.committed = GenerationRequest()
        self.failure = ""
        self.on_change: Callable[[bool], object] = lambda redraw: None
        self.redraw_results: Callable[[], object] = lambda: None
        self._restore(storage.get("asked") or {})

    @property
    def form(self) -> GenerationForm:
        """The form of the chosen run; an empty one without a run."""
        return GenerationForm((), ()) if self.run is None else form_of_run(self.run)

    def choose(self, run: str) -> None:
        """Choose another run, as one undoable step; values that its form lacks are dropped."""
        self._select_run(run)
        self.commit()

    def _select_run(self, name: str) -> None:
        """Choose a run, or the newest one if it is missing or generates nothing."""
        self.run = None
        with suppress(TactogramError):
            candidate = self.runs.get(name) if name else None
            if candidate is not None and form_of_run(candidate):
                self.run = candidate
        self.run = self.run or next(iter(self.runs.finished()), None)
        if self.run is not None:
            self.request = adapted(replace(self.request, run=self.run.name), self.form)

    def set(self, **changes: Any) -> None:
        """Change the form without an undoable step, as while a slider moves."""
        self.request = self.request.changed(**changes)

    def change(self, *, redraw: bool = True, **changes: Any) -> None:
        """Change the form by an undoable step."""
        self.set(**changes)
        self.commit(redraw=redraw)

    def commit(self, *, redraw: bool = False) -> None:
        """Make the changes, if there are any, an undoable step, store them and tell the page."""
        changed = self.request != self.committed
        if changed and self.committed.run:
            self.storage["past"] = [*self.storage.get("past", ()), asdict(self.committed)][-MOST_STEPS:]
            self.storage["future"] = []
        self.committed = self.request
        self.storage["asked"] = asdict(self.request)
        if changed or redraw:
            self.on_change(redraw)

    def undo(self) -> None:
        """Undo the last step; raise `ParameterError` if there is none."""
        self.commit()
        self._step("past", "future", "Nothing to undo.")

    def redo(self) -> None:
        """Redo the last undone step; raise `ParameterError` if there is none."""
        self._step("future", "past", "Nothing to redo.")

    def _step(self, back: str, forth: str, refusal: str) -> None:
        if not self.storage.get(back):
            raise ParameterError(refusal)
        *self.storage[back], form = self.storage[back]
        self.storage[forth] = [*self.storage.get(forth, ()), asdict(self.request)]
        self._restore(form)
        self.commit(redraw=True)

    def _restore(self, form: Mapping[str, Any]) -> None:
        self.request = GenerationRequest.from_stored(form)
        self._select_run(self.request.run)
        self.committed = self.request

    def command(self) -> str:
        """Return the equivalent command, to be run in the workspace."""
        if self.run is None:
            return ""
        return command(self.form.used(self.request), self.form, image=self.runs.photo_file(self.request))

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

        ``said`` is that of `GeneratingRuns.said`.
        """
        form = form_of_run(run)
        request = form.used(request)
        title = f"{request.title}, seed {request.seed}" + (f" ({number})" if request.count > 1 else "")
        facts = {
            "what": "made",
            "run": run.name,
            "run_id": run.data.get("run_id"),
            "model": run.model.name,
            "condition": dict(request.values),
            "seed": request.seed,
            "number": number,
            "simulated": run.kind.simulated,
            "command": command(request, form, image=self.runs.photo_file(request)),
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

    def archive(self, where: str) -> ResultArchive:
        """Return the archive ``made`` or ``kept``; `ParameterError` for any other."""
        if where not in ("made", "kept"):
            raise ParameterError(f"no archive {where[:40]!r}")
        return self.made if where == "made" else self.shelf

    def find(self, name: str) -> KeptResult | None:
        """Return a result by name, or None if it no longer exists."""
        where, _, id = name.partition(":")
        with suppress(TactogramError):
            return self.archive(where).get(id)
        return None

    def record_kept(self, name: str, kept: KeptResult) -> None:
        """Note the copy of a result on the shelf."""
        self.storage["kept"] = {**self.storage.get("kept", {}), name: kept.id}

    def rename(self, name: str, title: str) -> None:
        """Rename a result and its copy on the shelf; raise `ParameterError` for an empty title."""
        for each in (name, f"kept:{self.kept_id(name)}"):
            where, _, id = each.partition(":")
            if self.find(each) is not None:
                self.archive(where).rename(id, title)

    def kept_id(self, name: str) -> str:
        """Return the id of a result's copy on the shelf; empty if there is none."""
        id = str(self.storage.get("kept", {}).get(name, ""))
        return id if id and self.find(f"kept:{id}") is not None else ""
