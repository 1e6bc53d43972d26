"""Run comparison: losses in one chart, differences of recipes, figures."""

from __future__ import annotations

import json
from collections.abc import Mapping, Sequence
from typing import Annotated, Any
from urllib.parse import quote

from fastapi import Query
from nicegui import ui

from tactogram.errors import ParameterError
from tactogram.studio.layout import in_background, page
from tactogram.studio.pages.train.log import curves, metrics
from tactogram.studio.pages.train.run_facts import RunSummary, run_facts
from tactogram.studio.pages.train.widgets import TrainContext, loss_options

MOST = 8
Curves = dict[str, list[tuple[int, float]]]


def add(desk: TrainContext) -> None:
    """Register ``/train/compare``."""

    @ui.page("/train/compare")
    async def show(run: Annotated[list[str], Query()] = []) -> None:  # noqa: B006 - read only
        with page("Train"):
            ui.link("All runs", "/train").classes("small")
            try:
                found = await in_background(_read, desk, run)
            except ParameterError as error:
                ui.label(str(error)).props('role="alert"')
                return
            ui.label("Runs compared").classes("h2").props('role="heading" aria-level="2"')
            _losses({name: held for name, (_, held) in found.items()})
            _table(
                "Figures", rows_of_figures({name: facts for name, (facts, _) in found.items()}), list(found)
            )
            _table(
                "What differs in their recipes and data",
                differences({name: _flat_facts(facts) for name, (facts, _) in found.items()}),
                list(found),
            )


def _read(desk: TrainContext, names: Sequence[str]) -> dict[str, tuple[RunSummary, Curves]]:
    names = list(dict.fromkeys(names))[:MOST]
    found = {}
    for name in names:
        folder = desk.studio.workspace.inside(name)
        if not (folder / "recipe.toml").is_file():
            raise ParameterError(f"{name[:200]}: no run of this workspace; it was deleted, or never there")
        found[desk.studio.workspace.name_of(folder)] = (run_facts(folder), curves(metrics(folder)))
    if len(found) < 2:
        raise ParameterError("choose at least two runs on the page Train")
    return found


def _losses(held: Mapping[str, Curves]) -> None:
    names = list(dict.fromkeys(loss for curve in held.values() for loss in curve))
    with ui.element("section").classes("card w-full"):
        if not names:
            ui.label("None of them has curves: they are fitted in one step.").classes("quiet")
            return
        chart = ui.echart(loss_options(overlaid(held, names[0]))).classes("w-full").style("height: 22rem")
        chart.props('role="img" aria-label="Losses of the runs over steps"')

        def draw() -> None:
            chart.options.clear()
            chart.options.update(loss_options(overlaid(held, loss.value), log_scale=log_scale.value))
            chart.update()

        with ui.row().classes("items-center"):
            loss = ui.select(names, label="Loss", value=names[0], on_change=draw).classes("w-64")
            log_scale = ui.switch("logarithmic", on_change=draw)


def overlaid(held: Mapping[str, Curves], loss: str) -> Curves:
    """Return one loss of each run that has it, by run."""
    return {run: curve[loss] for run, curve in held.items() if loss in curve}


def rows_of_figures(facts: Mapping[str, RunSummary]) -> dict[str, dict[str, str]]:
    """Return figures by name and run, as text; empty where a run has none."""
    rows: dict[str, dict[str, str]] = {}
    for run, each in facts.items():
        for of, figures in (("validation", each.validation), ("evaluation", each.evaluation)):
            for name, value in figures.items():
                rows.setdefault(f"{name} ({of})", {})[run] = f"{value:.4g}"
    return rows


def differences(values: Mapping[str, Mapping[str, str]]) -> dict[str, dict[str, str]]:
    """Return the keys whose values are not the same in all runs, with each run's value."""
    keys = list(dict.fromkeys(key for held in values.values() for key in held))
    found = {key: {run: held.get(key, "") for run, held in values.items()} for key in keys}
    return {key: row for key, row in found.items() if len(set(row.values())) > 1}


def _flat_facts(facts: RunSummary) -> dict[str, str]:
    data = {name: facts.data.get(name) for name in ("name", "label", "split", "simulated")}
    data["sha256"] = str(facts.data.get("sha256", ""))[:12]
    return flat(
        {"model": facts.model, "data": data, **{k: v for k, v in facts.recipe.items() if k != "model"}}
    )


def flat(values: Mapping[str, Any], prefix: str = "") -> dict[str, str]:
    """Return nested values by dotted key, as JSON."""
    found: dict[str, str] = {}
    for key, value in values.items():
        if isinstance(value, Mapping):
            found |= flat(value, f"{prefix}{key}.")
        else:
            found[f"{prefix}{key}"] = json.dumps(value, ensure_ascii=False)
    return found


def _table(title: str, rows: Mapping[str, Mapping[str, str]], runs: Sequence[str]) -> None:
    with ui.element("section").classes("card w-full").style("overflow-x: auto"):
        ui.label(title).classes("h2").props('role="heading" aria-level="2"')
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
