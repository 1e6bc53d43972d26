"""The page Make: a form built from what a run's model needs, and results to see, hear, keep and compare."""

from __future__ import annotations

import asyncio
import threading
import time
from typing import Any

from nicegui import app, ui

from tactogram.errors import DataError, FailedTrainingError, TactogramError
from tactogram.studio.context import Studio
from tactogram.studio.layout import page, report_errors, show_error
from tactogram.studio.pages.make.desk import MakePageState
from tactogram.studio.pages.make.form import GenerationRequest
from tactogram.studio.pages.make.form_view import draw_form
from tactogram.studio.pages.make.results_view import draw_results
from tactogram.studio.pages.make.runs import RunCatalogue
from tactogram.studio.signals import view as signal_view
from tactogram.studio.workspace.shelf import KeptResult, ResultArchive

HEAD = '<link rel="stylesheet" href="/static/make.css"><script type="module" src="/static/make.js"></script>'


def add(studio: Studio) -> None:
    """Register the page, and where its pictures are fetched."""
    runs = RunCatalogue(studio.workspace)
    signal_view.add_routes()
    _add_routes(studio)

    @ui.page("/make")
    def show(run: str = "") -> None:
        held = app.storage.user.setdefault("make", {})
        desk = MakePageState(studio.workspace, studio.shelf, runs, held)
        if run and run != desk.asked.run:
            desk.choose(run)
        with page("Make", wide=True):
            ui.add_head_html(HEAD)
            signal_view.load_player()
            MakePage(studio, desk).draw()


class MakePage:
    """One browser's page.

    Parameters
    ----------
    studio : Studio
    desk : Desk
    """

    def __init__(self, studio: Studio, desk: MakePageState) -> None:
        self.studio, self.desk = studio, desk
        self.failed = ""
        self._cancelled, self._ended = threading.Event(), asyncio.Event()
        self._begun: float | None = None
        self._piece = 0

    def draw(self) -> None:
        """Draw the page, or how far the first voices are where no run is."""
        if self.desk.choice is None:
            self._wait_for_first()
            return
        with ui.element("div").classes("grid-2 make"):
            with ui.element("div").classes("make-form"):
                self.form()
                self._buttons()
                self.command()
            with ui.element("div").classes("make-results").props('aria-live="polite"'):
                self.results()
        ui.keyboard(self._key, ignore=["input", "select", "textarea"])

    @ui.refreshable_method
    def form(self) -> None:
        """Draw the form."""
        draw_form(self)

    @ui.refreshable_method
    def results(self) -> None:
        """Draw the results."""
        draw_results(self)

    @ui.refreshable_method
    def command(self) -> None:
        """Draw the command line that makes the same."""
        try:
            text = self.desk.command()
        except TactogramError as error:
            text = f"({error})"
        with ui.element("details").classes("command"):
            with ui.element("summary"):
                ui.label("The same on the command line").classes("in-line small")
            ui.label("Run it in the workspace's folder:").classes("small quiet")
            with ui.row().classes("w-full items-start no-wrap gap-2"):
                ui.element("pre").classes("grow").props('tabindex="0"')._text = text
                ui.button("Copy", on_click=lambda: _copy(text)).props("flat dense no-caps")

    # -- the form's state --------------------------------------------------------------------------------

    def committed(self, *, redraw: bool = False) -> None:
        """Note a change of the form as a step; draw what depends on it."""
        if self.desk.commit() or redraw:
            self.command.refresh()
            self._undo_states()
        if redraw:
            self.form.refresh()

    def _undo_states(self) -> None:
        self.undo_button.set_enabled(bool(self.desk.history.past))
        self.redo_button.set_enabled(bool(self.desk.history.future))

    def undo(self) -> None:
        """Take the last change back."""
        self.desk.undo()
        self.committed(redraw=True)

    def redo(self) -> None:
        """Do what was taken back."""
        self.desk.redo()
        self.committed(redraw=True)

    def _key(self, event: Any) -> None:
        if not (event.action.keydown and event.modifiers.ctrl):
            return
        name = str(event.key.name).lower()
        try:
            if name == "z" and not event.modifiers.shift:
                self.undo()
            elif name == "y" or name == "z":
                self.redo()
        except TactogramError as error:
            ui.notify(str(error))

    # -- making ------------------------------------------------------------------------------------------

    def _buttons(self) -> None:
        with ui.row().classes("w-full items-center gap-2 make-buttons"):
            self.make_button = ui.button("Make", on_click=report_errors(self.make)).props(
                "no-caps unelevated"
            )
            another = ui.button("Another seed", on_click=report_errors(self.another)).props("no-caps outline")
            another.tooltip("Draw another seed and make")
            self.undo_button = ui.button(icon="undo", on_click=report_errors(self.undo)).props("flat dense")
            self.undo_button.props(
                'aria-label="Undo the last change of the form" aria-keyshortcuts="Control+Z"'
            )
            self.redo_button = ui.button(icon="redo", on_click=report_errors(self.redo)).props("flat dense")
            self.redo_button.props('aria-label="Redo" aria-keyshortcuts="Control+Y"')
        self._undo_states()
        with ui.row().classes("w-full items-center gap-2") as self.progress:
            ui.spinner()
            self.progress_text = ui.label("").props('role="status"')
            ui.button("Cancel", on_click=self.cancel).props("no-caps flat dense")
        self.progress.set_visibility(False)
        ui.timer(0.2, self._progress)

    def _progress(self) -> None:
        if self._begun is None:
            return
        seconds = time.monotonic() - self._begun
        self.progress.set_visibility(seconds > 0.3)
        several = f"piece {self._piece} of {self.desk.asked.count}, " if self.desk.asked.count > 1 else ""
        self.progress_text.text = f"Making: {several}{seconds:.0f} s"

    async def another(self) -> None:
        """Draw another seed and make."""
        import secrets

        self.desk.set(seed=secrets.randbelow(10_000))
        self.committed(redraw=True)
        await self.make()

    async def make(self) -> None:
        """Make what the form asks for, in a thread, and show it."""
        if self._begun is not None:
            return
        self.committed()
        self._begun, self._piece, self.failed = time.monotonic(), 1, ""
        self.make_button.disable()
        # Of this one: its thread may outlast it.
        self._cancelled, self._ended = threading.Event(), asyncio.Event()
        work = asyncio.create_task(asyncio.to_thread(self._made, self.desk.asked, self._cancelled))
        stop = asyncio.create_task(self._ended.wait())
        try:
            await asyncio.wait({work, stop}, return_when=asyncio.FIRST_COMPLETED)
            if not work.done():  # it ends after the piece that it is at, and nothing of it is held
                work.add_done_callback(lambda task: task.cancelled() or task.exception())
                ui.notify("Cancelled: nothing of it was kept.")
                return
            self.desk.show(work.result())
        except FailedTrainingError as error:
            self.failed = f"{error}"
        finally:
            stop.cancel()
            self._begun = None
            self.make_button.enable()
            self.progress.set_visibility(False)
        self.results.refresh()

    def cancel(self) -> None:
        """End what is being made; nothing of it is held."""
        self._cancelled.set()
        self._ended.set()

    def _made(self, asked: GenerationRequest, cancelled: threading.Event) -> list[KeptResult]:
        """Make, in a thread; nothing is held before all of it is there."""
        choice = self.desk.choice
        if choice is None:
            raise DataError("There is no run to make something with.")

        def go_on(number: int) -> bool:
            if not cancelled.is_set():
                self._piece = number
            return not cancelled.is_set()

        pieces = self.desk.runs.make(asked, go_on=go_on)
        if cancelled.is_set():
            return []
        return [self.desk.put(asked, choice, number, made) for number, made in pieces]

    def tell(self, error: BaseException) -> None:
        """Show an error as a sentence."""
        show_error(error)

    def _wait_for_first(self) -> None:
        """Say that there is nothing yet, and reload as soon as there is."""
        self.studio.starter.make()
        with ui.element("section").classes("card").props('aria-live="polite"'):
            ui.label("There is no finished run in this workspace yet.").classes("h2")
            said = ui.label("")

        def look() -> None:
            first = self.studio.starter
            if first.state == "ready":
                ui.navigate.reload()
            else:
                said.text = (
                    first.line + "." if first.state == "failed" else f"Making the first voices: {first.line}"
                )

        ui.timer(0.5, look)


def _copy(text: str) -> None:
    ui.clipboard.write(text)
    ui.notify("Copied.")


def _add_routes(studio: Studio) -> None:
    """Register where images of results and photographs are fetched."""
    from fastapi import Response
    from fastapi.responses import FileResponse

    shelves = {"made": ResultArchive(studio.workspace.studio_folder / "made"), "kept": studio.shelf}

    @app.get("/make/image/{where}/{id}")
    def image(where: str, id: str) -> Response:
        try:
            made = shelves[where].get(id)
        except (KeyError, TactogramError):
            return Response("no such image", status_code=404, media_type="text/plain")
        if not made.is_image:
            return Response("a signal, not an image", status_code=404, media_type="text/plain")
        return FileResponse(made.file, media_type="image/png")

    @app.get("/make/photo/{name}")
    def photograph(name: str) -> Response:
        folder = (studio.workspace.studio_folder / "photos").resolve()
        path = (folder / name).resolve()
        if path.parent != folder or path.suffix != ".png" or not path.is_file():
            return Response("no such photograph", status_code=404, media_type="text/plain")
        return FileResponse(path, media_type="image/png")
