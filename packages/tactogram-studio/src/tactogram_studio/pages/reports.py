"""The page Reports: reports of runs and studies, and published figures next to ours."""

from __future__ import annotations

import html
from collections.abc import Callable, Mapping
from itertools import groupby
from typing import Any, Literal
from urllib.parse import quote

from fastapi.responses import FileResponse, HTMLResponse
from nicegui import app, ui

from tactogram.workflows import table as published_rows
from tactogram_studio import kit
from tactogram_studio.context import Studio
from tactogram_studio.server.guard import REPORT_POLICY
from tactogram_studio.workspace.reports import (
    ReportFile,
    in_scheme,
    matching,
    published_cells,
    readable_file,
    report_files,
)

COLUMNS = (
    "Model",
    "Result",
    "Published",
    "Ours",
    "Difference",
    "Seeds",
    "Data and split",
    "Reason for the difference",
)
"""Of the published figures."""
TABS = {"reports": "Reports", "published": "Published and ours"}


def add(studio: Studio) -> None:
    """Register the page, and the route of its files, which a content policy keeps from running scripts."""

    @app.get("/reports/file/{name:path}")
    def file(name: str, scheme: Literal["light", "dark"] | None = None) -> Any:
        path = readable_file(studio.workspace, name)
        headers = {"Content-Security-Policy": REPORT_POLICY}
        if scheme and path.suffix == ".html":
            return HTMLResponse(in_scheme(path.read_bytes(), scheme), headers=headers)
        return FileResponse(path, headers=headers)

    @kit.route("/reports")
    def show(of: str = "", tab: str = "reports", q: str = "") -> None:
        with kit.page("Reports") as dark:
            with ui.tabs().classes("w-full") as tabs:
                panels = {name: ui.tab(name, label=label) for name, label in TABS.items()}
            first = panels.get(tab, panels["reports"])
            query = {"of": of, "tab": tab, "q": q}

            def keep(**changes: str) -> None:
                query.update(changes)
                kit.keep_address("/reports", **query)

            shown = ui.tab_panels(tabs, value=first, on_change=lambda event: keep(tab=event.value))
            with shown.classes("w-full bg-transparent"):
                with ui.tab_panel(panels["reports"]).classes("p-0"):
                    ReportsPanel(studio, query, keep, dark)
                with ui.tab_panel(panels["published"]).classes("p-0"):
                    PublishedPanel(query, keep)


class ReportsPanel:
    """List of report files on the left, the selected one on the right, light or ``dark`` as the page.

    ``query`` is that of the address, and ``keep`` changes it.
    """

    def __init__(
        self, studio: Studio, query: Mapping[str, str], keep: Callable[..., None], dark: ui.dark_mode
    ) -> None:
        self.studio, self.query, self.keep, self.dark, path = studio, query, keep, dark, query["of"]
        dark.on_value_change(lambda _: self._reader.refresh(""))
        self.files = report_files(studio.workspace)
        self.selected = next((file for file in self.files if file.path == path), None)
        if self.selected is None and self.files and not path:
            self.selected = self.files[0]
        with ui.element("div").classes("reader mt-4"):
            with kit.card(label="Reports", classes=""):
                self._words = ui.input("Search", value=query["q"], on_change=self._search).classes("w-full")
                self._words.props('clearable type="search"')
                self._list()
            with kit.card(label="Reader", classes=""):
                self._reader(path)

    @ui.refreshable_method
    def _list(self) -> None:
        words = str(self._words.value or "")
        shown = [file for file in self.files if matching(words, (file.path, _keywords(file)))]
        if not self.files:
            ui.label("No reports yet. To write one, evaluate a run on the page Train.").classes("quiet")
        elif not shown:
            ui.label("No report matches.").classes("quiet")
        for folder, group in groupby(shown, key=lambda file: file.folder):
            files = list(group)
            with ui.element("div").classes("mt-3"):
                with ui.row().classes("items-center gap-2"):
                    ui.label("this folder" if folder == "." else folder).classes("font-bold")
                    kit.mark_simulated(files[0].simulated)
                with ui.column().classes("gap-0 items-start"):
                    for file in files:
                        button = ui.button(
                            file.path.removeprefix(f"{folder}/"), on_click=lambda file=file: self._open(file)
                        ).props("flat dense")
                        if file == self.selected:
                            button.props('aria-current="true"').classes("reading")

    def _search(self) -> None:
        self.keep(q=self._words.value or "")
        self._list.refresh()

    def _open(self, file: ReportFile) -> None:
        ui.navigate.to(kit.address("/reports", of=file.path, q=self.query["q"]))

    @ui.refreshable_method
    def _reader(self, path: str) -> None:
        file = self.selected
        if file is None:
            text = (
                f"{path}: no such report in this workspace." if path else "Select a report to read it here."
            )
            ui.label(text).classes("quiet")
            return
        address = f"/reports/file/{quote(file.path)}"
        with ui.row().classes("items-center justify-between w-full"):
            kit.title_row(file.path, file.simulated, "simulated data").classes(remove="w-full")
            ui.link("Open in a new tab", address, new_tab=True)
        title = html.escape(f"{file.kind} {file.path}", quote=True)
        if file.kind == "report":
            # Browsers do not pass the page's choice on to a frame.
            scheme = {True: "?scheme=dark", False: "?scheme=light"}.get(self.dark.value, "")
            markup = f'<iframe class="report" sandbox src="{address}{scheme}" title="{title}"></iframe>'
            ui.html(markup, sanitize=False).classes("w-full")
        elif file.kind == "figure":
            ui.html(f'<img class="figure" src="{address}" alt="{title}">', sanitize=False).classes("w-full")
        else:
            with kit.refusals(kit.alert()):
                whole = readable_file(self.studio.workspace, file.path)
                ui.label(whole.read_text(encoding="utf-8", errors="replace")[:200_000]).classes("code")


def _keywords(file: ReportFile) -> str:
    return f"{file.kind} {'simulated' if file.simulated else ''}"


class PublishedPanel:
    """Published results of every model next to ours."""

    def __init__(self, query: Mapping[str, str], keep: Callable[..., None]) -> None:
        self.rows, self.keep = published_rows(), keep
        with kit.card("Published figures next to ours", label="Published and ours", classes="w-full mt-4"):
            kit.hint(
                "Unless stated otherwise, ours were measured on other data: before you compare, read the data, the "
                "split and the reason for the difference. The command tactogram table prints the same table."
            )
            self._words = ui.input("Search", value=query["q"], placeholder="model, measure, data …")
            self._words.classes("w-80").props('clearable type="search" debounce="200"')
            self._words.on_value_change(self._search)
            self._count = kit.hint("").props('role="status"')
            columns = [{"name": name, "label": name, "field": name, "align": "left"} for name in COLUMNS]
            self._table = ui.table(columns=columns, rows=[], row_key="id").classes("w-full published")
            self._table.props("flat wrap-cells")
        self._show()

    def _search(self) -> None:
        self.keep(q=self._words.value or "")
        self._show()

    def _show(self) -> None:
        self._table.rows = published_cells(self.rows, str(self._words.value or ""))
        self._count.text = f"{len(self._table.rows)} of {len(self.rows)} figures"
