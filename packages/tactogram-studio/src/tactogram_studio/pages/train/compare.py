"""Run comparison: losses in one chart, and what `tactogram compare` prints."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Annotated, Any
from urllib.parse import quote

from fastapi import Query
from nicegui import ui

from tactogram.errors import ParameterError, TactogramError
from tactogram_studio import kit
from tactogram_studio.context import Studio
from tactogram_studio.tasks.log import loss_curves, read_metrics, thinned

MOST_RUNS = 8
INKS = ("#0b5d66", "#b3541e", "#5b4a9e", "#1e6b34", "#a4262c", "#5a6470", "#8a5a00", "#1f5fa8")
"""Colours of curves; each has a contrast of at least 4.5:1 on white."""
Curves = dict[str, list[tuple[int, float]]]


def add(studio: Studio) -> None:
    """Register ``/train/compare``."""

    @kit.route("/train/compare")
    async def show(run: Annotated[list[str], Query()] = []) -> None:  # noqa: B006 - read only
        with kit.page("Train"):
            ui.link("All runs", "/train").classes("small")
            try:
                curves, compared = await kit.in_background(_read, studio, run)
            except TactogramError as error:
                kit.alert(str(error))
                return
            kit.heading("Comparison of runs")
            _draw_losses(curves)
            _draw_table("Results", "Measure", compared["results"], list(curves))
            _draw_table("Models and data", "Fact", compared["facts"], list(curves))
            _draw_table("Different settings", "Setting", compared["settings"], list(curves))
            for note in compared["notes"]:
                kit.hint(note)


def _read(studio: Studio, names: Sequence[str]) -> tuple[dict[str, Curves], dict[str, Any]]:
    from tactogram.workflows import compare_runs  # brings torch

    workspace = studio.workspace
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
    with kit.card():
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


def loss_options(
    curves: Mapping[str, Sequence[tuple[int, float]]], *, log_scale: bool = False
) -> dict[str, Any]:
    """Return the chart of losses, given as (step, value); ``log_scale`` applies only if all values are positive."""
    positive = all(value > 0 for points in curves.values() for _, value in points)
    return {
        "animation": False,
        "color": list(INKS),
        "aria": {"enabled": True},
        "grid": {"left": 60, "right": 20, "top": 40, "bottom": 45},
        "legend": {"show": True, "top": 0, "type": "scroll"},
        "tooltip": {"trigger": "axis"},
        "xAxis": {"type": "value", "name": "step", "nameLocation": "middle", "nameGap": 28, "min": 0},
        "yAxis": {"type": "log" if log_scale and positive else "value", "scale": True},
        "series": [
            {
                "type": "line",
                "name": name,
                "showSymbol": len(points) < 3,
                "lineStyle": {"width": 1.5},
                "data": [list(point) for point in thinned(points)],
            }
            for name, points in curves.items()
        ],
    }


def _draw_table(title: str, key: str, rows: Mapping[str, Sequence[Any]], runs: Sequence[str]) -> None:
    with kit.card(title):
        if not rows:
            ui.label("None.").classes("quiet")
            return
        kit.table([key, *runs], [[name, *map(_text, values)] for name, values in rows.items()])
        with ui.row():
            for run in runs:
                ui.link(run, f"/train/watch?run={quote(run)}").classes("small")


def _text(value: Any) -> str:
    if isinstance(value, float):
        return f"{value:.4g}"
    return "" if value is None else str(value)
