"""The page Reports: reports of runs and studies, published figures beside ours, experiments and their results."""

from __future__ import annotations

import html
from itertools import groupby
from typing import Any
from urllib.parse import quote

from fastapi.responses import FileResponse, JSONResponse
from nicegui import app, ui

from tactogram.errors import TactogramError
from tactogram.studio.context import Studio
from tactogram.studio.layout import page, report_errors
from tactogram.studio.pages.reports.catalogue import (
    ReportFile,
    experiments_with_results,
    matching,
    numbers_html,
    published_html,
    readable_file,
    readables,
    result_of,
    says_simulated,
)
from tactogram.studio.server.guard import REPORT
from tactogram.workflows.table import table

TABS = {"reports": "Reports", "published": "Published and ours", "experiments": "Experiments"}


def add(studio: Studio) -> None:
    """Register the page, and where files are shown from: confined, and never run."""

    @app.get("/reports/file/{name:path}")
    def file(name: str) -> Any:
        try:
            path, kind = readable_file(studio.workspace, name)
        except TactogramError as error:
            return JSONResponse({"error": str(error)}, status_code=404)
        return FileResponse(path, media_type=kind, headers={"Content-Security-Policy": REPORT})

    @ui.page("/reports")
    def show(of: str = "", tab: str = "reports") -> None:
        ui.add_head_html('<link rel="stylesheet" href="/static/send.css">')
        ui.add_head_html('<link rel="stylesheet" href="/static/reports.css">')
        with page("Reports", wide=True):
            with ui.tabs().classes("w-full") as tabs:
                places = {name: ui.tab(name, label=label) for name, label in TABS.items()}
            first = places.get(tab, places["reports"])
            with ui.tab_panels(tabs, value=first).classes("w-full bg-transparent"):
                with ui.tab_panel(places["reports"]).classes("p-0"):
                    ReportsPanel(studio, of)
                with ui.tab_panel(places["published"]).classes("p-0"):
                    PublishedPanel()
                with ui.tab_panel(places["experiments"]).classes("p-0"):
                    ExperimentsPanel(studio)


class ReportsPanel:
    """Files of runs and studies on the left, the one that is read on the right."""

    def __init__(self, studio: Studio, of: str) -> None:
        self.studio = studio
        self.found = readables(studio.workspace)
        self.read = next((item for item in self.found if item.path == of), None)
        if self.read is None and self.found and not of:
            self.read = self.found[0]
        with ui.element("div").classes("reader mt-4"):
            with ui.element("section").classes("card").props('aria-label="What there is to read"'):
                self._words = ui.input("Search", on_change=self._searched).classes("w-full")
                self._words.props('clearable type="search"')
                self._list()
            with ui.element("section").classes("card").props('aria-label="Reader"'):
                self._reader(of)

    def _searched(self) -> None:
        self._list.refresh()

    @ui.refreshable_method
    def _list(self) -> None:
        words = str(self._words.value or "")
        shown = [item for item in self.found if matching(words, (item.path, _marks(item)))]
        if not self.found:
            ui.label("No reports yet: `tactogram evaluate RUN`, or the page Train, writes one.").classes(
                "quiet"
            )
        elif not shown:
            ui.label("Nothing holds these words.").classes("quiet")
        for folder, group in groupby(shown, key=lambda item: item.folder):
            items = list(group)
            with ui.element("div").classes("mt-3"):
                with ui.row().classes("items-center gap-2"):
                    ui.label("this folder" if folder == "." else folder).classes("font-bold")
                    if items[0].simulated:
                        ui.label("simulated").classes("simulated")
                with ui.column().classes("gap-0 items-start"):
                    for item in items:
                        name = item.path.removeprefix(f"{folder}/")
                        button = ui.button(name, on_click=lambda i=item: self._open(i)).props(
                            "flat dense no-caps"
                        )
                        if item == self.read:
                            button.props('aria-current="true"').classes("reading")

    def _open(self, item: ReportFile) -> None:
        self.read = item
        self._list.refresh()
        self._reader.refresh("")

    @ui.refreshable_method
    @report_errors
    def _reader(self, of: str) -> None:
        item = self.read
        if item is None:
            text = f"{of}: there is no such report in the workspace." if of else "What is read comes here."
            ui.label(text).classes("quiet")
            return
        address = f"/reports/file/{quote(item.path)}"
        with ui.row().classes("items-center justify-between w-full"):
            with ui.row().classes("items-center gap-2"):
                ui.label(item.path).classes("h2")
                if item.simulated:
                    ui.label("simulated data").classes("simulated")
            ui.link("Open alone", address, new_tab=True)
        title = html.escape(f"{item.kind} {item.path}", quote=True)
        if item.kind == "report":
            ui.html(
                f'<iframe class="report" sandbox src="{address}" title="{title}"></iframe>', sanitize=False
            ).classes("w-full")
        elif item.kind == "figure":
            ui.html(f'<img class="figure" src="{address}" alt="{title}">', sanitize=False).classes("w-full")
        else:
            path, _ = readable_file(self.studio.workspace, item.path)
            if item.kind == "text":
                ui.label(path.read_text(encoding="utf-8", errors="replace")[:200_000]).classes("told")
            else:
                ui.html(numbers_html(result_of(path)), sanitize=False).classes("w-full scrolled")


def _marks(item: ReportFile) -> str:
    return f"{item.kind} {'simulated' if item.simulated else ''}"


class PublishedPanel:
    """Every model's published results beside ours."""

    def __init__(self) -> None:
        self.rows = table()
        with ui.element("section").classes("card w-full mt-4").props('aria-label="Published and ours"'):
            ui.label("Published figures beside ours").classes("h2")
            ui.label(
                "Ours was measured on other data unless it says so: read data, split and why they differ before you "
                "compare. The same: tactogram table"
            ).classes("small quiet")
            with ui.row().classes("items-end gap-4"):
                self._words = ui.input(
                    "Search", placeholder="model, measure, data …", on_change=self._searched
                ).classes("w-80")
                self._words.props('clearable type="search" debounce="200"')
            self._table()

    def _searched(self) -> None:
        self._table.refresh()

    @ui.refreshable_method
    def _table(self) -> None:
        text, count = published_html(self.rows, str(self._words.value or ""))
        ui.label(f"{count} of {len(self.rows)} figures").classes("small quiet").props('role="status"')
        ui.html(text, sanitize=False).classes("w-full")


class ExperimentsPanel:
    """Experiments, and the results of them that lie at hand."""

    def __init__(self, studio: Studio) -> None:
        found = experiments_with_results(studio.workspace)
        with ui.column().classes("w-full gap-4 mt-4"):
            for one in sorted(found, key=lambda one: not one.results):
                with ui.element("section").classes("card w-full").props(f'aria-label="{one.name}"'):
                    ui.label(one.name).classes("h2")
                    ui.label(one.title)
                    ui.label(one.command).classes("told")
                    for path in one.results:
                        self._result(path)
                    if not one.results:
                        ui.label("No result of it lies here.").classes("small quiet")

    def _result(self, path: Any) -> None:
        try:
            values = result_of(path)
        except TactogramError as error:
            ui.label(str(error)).classes("text-negative")
            return
        with ui.row().classes("items-center gap-2"):
            kept = "as kept beside the source" if path.name != "result.json" else "of this workspace"
            ui.label(f"Result, {kept}").classes("font-bold")
            if says_simulated(values):
                ui.label("simulated").classes("simulated")
        text = str(values.pop("text", ""))
        if text:
            ui.html(f'<pre class="told table">{html.escape(text)}</pre>', sanitize=False).classes("w-full")
        expansion = ui.expansion("All of its numbers").classes("w-full")
        with expansion:
            place = ui.column().classes("w-full scrolled")

        def fill() -> None:
            if expansion.value and not place.default_slot.children:
                with place:
                    ui.html(numbers_html(values), sanitize=False)

        expansion.on_value_change(fill)
