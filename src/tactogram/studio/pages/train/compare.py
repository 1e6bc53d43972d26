"""Run comparison: losses in one chart, results, and differences of recipe and data."""

from __future__ import annotations

import json
from collections.abc import Mapping, Sequence
from typing import Annotated
from urllib.parse import quote

from fastapi import Query
from nicegui import ui

from tactogram.errors import ParameterError
from tactogram.recipe import dotted
from tactogram.studio.layout import heading, in_background, page, route
from tactogram.studio.pages.train.log import loss_curves, read_metrics
from tactogram.studio.pages.train.run_summary import RunSummary, run_summary
from tactogram.studio.pages.train.widgets import TrainContext, loss_options

MOST_RUNS = 8
Curves = dict[str, list[tuple[int, float]]]


def add(context: TrainContext) -> None:
    """Register ``/train/compare``."""

    @route("/train/compare")
    async def show(run: Annotated[list[str], Query()] = []) -> None:  # noqa: B006 - read only
        with page("Train"):
            ui.link("All runs", "/train").classes("small")
            try:
                runs = await in_background(_read, context, run)
            except ParameterError as error:
                ui.label(str(error)).props('role="alert"')
                return
            heading("Comparison of runs")
            _draw_losses({name: curves for name, (_, curves) in runs.items()})
            summaries = {name: summary for name, (summary, _) in runs.items()}
            _draw_table("Results", result_rows(summaries), list(runs))
            settings = {name: _flat_settings(summary) for name, summary in summaries.items()}
            _draw_table("Differences in recipe and data", differences(settings), list(runs))


def _read(context: TrainContext, names: Sequence[str]) -> dict[str, tuple[RunSummary, Curves]]:
    workspace = context.studio.workspace
    runs = {}
    for name in list(dict.fromkeys(names))[:MOST_RUNS]:
        folder = workspace.inside(name)
        if not (folder / "recipe.toml").is_file():
            raise ParameterError(f"{name[:200]}: no such run in this workspace; it may have been deleted")
        runs[workspace.name_of(folder)] = (run_summary(folder), loss_curves(read_metrics(folder)))
    if len(runs) < 2:
        raise ParameterError("select at least two runs on the page Train")
    return runs


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


def result_rows(summaries: Mapping[str, RunSummary]) -> dict[str, dict[str, str]]:
    """Return results as text by name and run, without entries for runs that lack one."""
    rows: dict[str, dict[str, str]] = {}
    for run, summary in summaries.items():
        for origin, results in (("validation", summary.validation), ("evaluation", summary.evaluation)):
            for name, value in results.items():
                rows.setdefault(f"{name} ({origin})", {})[run] = f"{value:.4g}"
    return rows


def differences(settings: Mapping[str, Mapping[str, str]]) -> dict[str, dict[str, str]]:
    """Return the settings whose values differ between runs, as values by key and run."""
    keys = dict.fromkeys(key for values in settings.values() for key in values)
    rows = {key: {run: values.get(key, "") for run, values in settings.items()} for key in keys}
    return {key: row for key, row in rows.items() if len(set(row.values())) > 1}


def _flat_settings(summary: RunSummary) -> dict[str, str]:
    data = {name: summary.data.get(name) for name in ("name", "label", "split", "simulated")}
    data["sha256"] = str(summary.data.get("sha256", ""))[:12]
    recipe = {key: value for key, value in summary.recipe.items() if key != "model"}
    found = dotted({"model": summary.model, "data": data, **recipe})
    return {key: json.dumps(value, ensure_ascii=False) for key, value in found.items()}


def _draw_table(title: str, rows: Mapping[str, Mapping[str, str]], runs: Sequence[str]) -> None:
    with ui.element("section").classes("card w-full").style("overflow-x: auto"):
        heading(title)
        if not rows:
            ui.label("None.").classes("quiet")
            return
        columns = [{"name": "key", "label": "", "field": "key", "align": "left"}]
        columns += [{"name": run, "label": run, "field": run, "align": "left"} for run in runs]
        table = [{"key": key, **{run: row.get(run, "") for run in runs}} for key, row in rows.items()]
        ui.table(columns=columns, rows=table, row_key="key").props("flat dense wrap-cells").classes("w-full")
        with ui.row():
            for run in runs:
                ui.link(run, f"/train/watch?run={quote(run)}").classes("small")
