"""Run comparison: losses in one chart, and what `tactogram compare` prints."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Annotated, Any
from urllib.parse import quote

from fastapi import Query
from nicegui import ui

from tactogram.errors import ParameterError, TactogramError
from tactogram_studio.layout import heading, hint, in_background, page, route
from tactogram_studio.pages.train.log import loss_curves, read_metrics
from tactogram_studio.pages.train.widgets import TrainContext, loss_options

MOST_RUNS = 8
Curves = dict[str, list[tuple[int, float]]]


def add(context: TrainContext) -> None:
    """Register ``/train/compare``."""

    @route("/train/compare")
    async def show(run: Annotated[list[str], Query()] = []) -> None:  # noqa: B006 - read only
        with page("Train"):
            ui.link("All runs", "/train").classes("small")
            try:
                curves, compared = await in_background(_read, context, run)
            except TactogramError as error:
                ui.label(str(error)).props('role="alert"')
                return
            heading("Comparison of runs")
            _draw_losses(curves)
            for title, rows in (
                ("Results", "results"),
                ("Models and data", "facts"),
                ("Different settings", "settings"),
            ):
                _draw_table(title, compared[rows], list(curves))
            for note in compared["notes"]:
                hint(note)


def _read(context: TrainContext, names: Sequence[str]) -> tuple[dict[str, Curves], dict[str, Any]]:
    from tactogram.workflows import compare_runs  # brings torch

    workspace = context.studio.workspace
    folders = [workspace.inside(name) for name in dict.fromkeys(names)][:MOST_RUNS]
    for name, folder in zip(dict.fromkeys(names), folders, strict=False):
        if not (folder / "recipe.toml").is_file():
            raise ParameterError(f"{name[:200]}: no such run in this workspace; it may have been deleted")
    if len(folders) < 2:
        raise ParameterError("select at least two runs on the page Train")
    curves = {workspace.name_of(folder): loss_curves(read_metrics(folder)) for folder in folders}
    return curves, compare_runs(folders)


def _draw_losses(curves_by_run: Mapping[str, Curves]) -> None:
    names = list(dict.fromkeys(loss for curves in curves_by_run.values() for loss in curves))
    with ui.element("section").classes("card w-full"):
        if not names:
            ui.label(
                "None of these runs has loss curves: their models are computed from the recordings."
            ).classes("quiet")
            return
        chart = ui.echart(loss_options(loss_by_run(curves_by_run, names[0]))).classes("w-full")
        chart.style("height: 22rem").props('role="img" aria-label="Losses of the runs over steps"')

        def draw() -> None:
            chart.options.clear()
            shown = loss_by_run(curves_by_run, loss.value)
            chart.options.update(loss_options(shown, log_scale=log_scale.value))
            chart.update()

        with ui.row().classes("items-center"):
            loss = ui.select(names, label="Loss", value=names[0], on_change=draw).classes("w-64")
            log_scale = ui.switch("logarithmic", on_change=draw)


def loss_by_run(curves_by_run: Mapping[str, Curves], loss: str) -> Curves:
    """Return one loss of each run that has it, by run."""
    return {run: curves[loss] for run, curves in curves_by_run.items() if loss in curves}


def _draw_table(title: str, rows: Mapping[str, Sequence[Any]], runs: Sequence[str]) -> None:
    with ui.element("section").classes("card w-full").style("overflow-x: auto"):
        heading(title)
        if not rows:
            ui.label("None.").classes("quiet")
            return
        columns = [{"name": "key", "label": "", "field": "key", "align": "left"}]
        columns += [{"name": run, "label": run, "field": run, "align": "left"} for run in runs]
        table = [
            {"key": key, **dict(zip(runs, map(_text, values), strict=True))} for key, values in rows.items()
        ]
        ui.table(columns=columns, rows=table, row_key="key").props("flat dense wrap-cells").classes("w-full")
        with ui.row():
            for run in runs:
                ui.link(run, f"/train/watch?run={quote(run)}").classes("small")


def _text(value: Any) -> str:
    if isinstance(value, float):
        return f"{value:.4g}"
    return "" if value is None else str(value)
