"""The page Make: a form for a run, and its results to see, play, keep and compare."""

from __future__ import annotations

import asyncio
import secrets
import threading
import time
from typing import Any

from fastapi import Response
from fastapi.responses import FileResponse
from nicegui import app, ui

from tactogram.errors import DataError, FailedTrainingError, TactogramError
from tactogram_studio import kit
from tactogram_studio.context import Studio
from tactogram_studio.generation.form import GenerationRequest
from tactogram_studio.generation.runs import GeneratingRuns
from tactogram_studio.generation.state import PRESSED, MakePageState
from tactogram_studio.kit.tasks import draw_progress
from tactogram_studio.pages.make.form_view import draw_form
from tactogram_studio.pages.make.results_view import draw_results
from tactogram_studio.signals import view as signal_view
from tactogram_studio.workspace.shelf import KeptResult

HEAD = '<link rel="stylesheet" href="/static/make.css"><script type="module" src="/static/make.js"></script>'


def add(studio: Studio) -> None:
    """Register the page, and the routes of its images."""
    runs = GeneratingRuns(studio.workspace)
    signal_view.add_routes()
    _add_routes(studio, runs)

    @kit.route("/make")
    def show(run: str = "", key: str = "") -> None:
        storage = kit.TabSettings(app.storage.user.setdefault("make", {}), key, shared=("listed", "kept"))
        state = MakePageState(studio.workspace, studio.shelf, runs, storage)
        if run and run != state.request.run:
            state.choose(run)
        with kit.page("Make"):
            kit.keep_address("/make", key=storage.key)
            ui.add_head_html(HEAD)
            signal_view.load_player()
            if state.run is None:
                studio.starter.make()
                draw_progress(studio.starter, ready=ui.navigate.reload)
                return
            drawn = MakePage(studio, state)
            drawn.draw()
            if storage.pop(PRESSED, False):
                ui.timer(0.05, drawn.generate, once=True)


class MakePage:
    """One browser's page."""

    def __init__(self, studio: Studio, state: MakePageState) -> None:
        self.studio, self.state = studio, state
        state.on_change, state.redraw_results = self._changed, self.results.refresh
        self._cancelled, self._ended = threading.Event(), asyncio.Event()
        self._started: float | None = None
        self._number = 0

    def draw(self) -> None:
        """Draw the page."""
        with ui.element("div").classes("grid-2 make"):
            with ui.element("div").classes("make-form"):
                self._draw_buttons()
                self.form()
                self.command()
            with ui.element("div").classes("make-results"):
                self.results()
        self.announcement = ui.label().classes("sr-only").props('role="status"')
        ui.keyboard(self._key, ignore=["input", "select", "textarea"])

    @ui.refreshable_method
    def form(self) -> None:
        """Draw the form."""
        draw_form(self.state)

    @ui.refreshable_method
    def results(self) -> None:
        """Draw the results."""
        draw_results(self.state)

    @ui.refreshable_method
    def command(self) -> None:
        """Draw the equivalent command."""
        try:
            text = self.state.command()
        except TactogramError as error:
            text = f"({error})"
        kit.command_lines([text])

    # -- the form's state --------------------------------------------------------------------------------

    def _changed(self, redraw: bool) -> None:
        self.command.refresh()
        self._enable_undo()
        if redraw:
            self.form.refresh()

    def _enable_undo(self) -> None:
        self.undo_button.set_enabled(bool(self.state.storage.get("past")))
        self.redo_button.set_enabled(bool(self.state.storage.get("future")))

    def _key(self, event: Any) -> None:
        if not (event.action.keydown and event.modifiers.ctrl):
            return
        name = str(event.key.name).lower()
        if name == "z" and not event.modifiers.shift:
            self.state.undo()
        elif name in ("y", "z"):
            self.state.redo()

    # -- generating --------------------------------------------------------------------------------------

    def _draw_buttons(self) -> None:
        with ui.row().classes("w-full items-center gap-2 make-buttons"):
            self.button = ui.button("Generate", on_click=self.generate)
            seed = ui.button("New seed", on_click=self.generate_with_new_seed).props("outline")
            seed.tooltip("Choose another random seed, and generate")
            self.undo_button = ui.button(icon="undo", on_click=self.state.undo).props("flat dense")
            self.undo_button.props(
                'aria-label="Undo the last change of the form" aria-keyshortcuts="Control+Z"'
            )
            self.redo_button = ui.button(icon="redo", on_click=self.state.redo).props("flat dense")
            self.redo_button.props('aria-label="Redo" aria-keyshortcuts="Control+Y"')
        self._enable_undo()
        with ui.row().classes("w-full items-center gap-2") as self.progress:
            ui.spinner()
            self.progress_text = ui.label("").props('role="status"')
            ui.button("Cancel", on_click=self.cancel).props("flat dense")
        self.progress.set_visibility(False)
        ui.timer(0.2, self._show_progress)

    def _show_progress(self) -> None:
        if self._started is None:
            return
        seconds, count = time.monotonic() - self._started, self.state.request.count
        self.progress.set_visibility(seconds > 0.3)
        part = f"{self._number} of {count}, " if count > 1 else ""
        self.progress_text.text = f"Generating: {part}{seconds:.0f} s"

    async def generate_with_new_seed(self) -> None:
        """Choose a random seed, and generate."""
        self.state.change(seed=secrets.randbelow(10_000))
        await self.generate()

    async def generate(self) -> None:
        """Generate what the form requests in a thread, and show it."""
        if self._started is not None:
            return
        self.state.commit()
        self._started, self._number, self.state.failure = time.monotonic(), 1, ""
        self.button.disable()
        # New events for each generation: the thread of a cancelled one may still be running.
        self._cancelled, self._ended = threading.Event(), asyncio.Event()
        work = asyncio.create_task(asyncio.to_thread(self._generate, self.state.request, self._cancelled))
        stop = asyncio.create_task(self._ended.wait())
        try:
            await asyncio.wait({work, stop}, return_when=asyncio.FIRST_COMPLETED)
            if not work.done():  # the thread ends after its current result, and stores nothing
                work.add_done_callback(lambda task: task.cancelled() or task.exception())
                ui.notify("Cancelled; nothing was saved.")
                return
            self.state.show(work.result())
        except FailedTrainingError as error:
            self.state.failure = f"{error}"
        finally:
            stop.cancel()
            self._started = None
            self.button.enable()
            self.progress.set_visibility(False)
        self.results.refresh()
        result = self.state.current_result()
        self.announcement.text = f"{result.title} is generated." if result and not self.state.failure else ""
        ui.run_javascript("window.tactogramMake.showResults()")

    def cancel(self) -> None:
        """End the generation without storing its results."""
        self._cancelled.set()
        self._ended.set()

    def _generate(self, request: GenerationRequest, cancelled: threading.Event) -> list[KeptResult]:
        """Generate and store all results; store none if cancelled."""
        run = self.state.run
        if run is None:
            raise DataError("There is no run to generate from.")

        def proceed(number: int) -> bool:
            if not cancelled.is_set():
                self._number = number
            return not cancelled.is_set()

        results = self.state.runs.generate(request, proceed=proceed)
        if cancelled.is_set():
            return []
        said = self.state.runs.said(request)
        return [self.state.store_result(request, run, number, made, said) for number, made in results]


def _add_routes(studio: Studio, runs: GeneratingRuns) -> None:
    """Register the routes of photographs and of results that are images."""
    state = MakePageState(studio.workspace, studio.shelf, runs, {})

    @app.get("/make/image/{where}/{id}")
    def image(where: str, id: str) -> Response:
        result = state.archive(where).get(id)
        if not result.is_image:
            raise DataError("no such image")
        return FileResponse(result.file, media_type="image/png")

    @app.get("/make/photo/{name}")
    def photograph(name: str) -> Response:
        folder = state.photographs.resolve()
        path = (folder / name).resolve()
        if path.parent != folder or path.suffix != ".png" or not path.is_file():
            raise DataError("no such photograph")
        return FileResponse(path, media_type="image/png")
