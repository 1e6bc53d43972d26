"""Comparison of runs: their data, the settings in which they differ, and their results."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

from tactogram.errors import ParameterError
from tactogram.parameters import checked

if TYPE_CHECKING:
    from tactogram.training.run import Run

OMITTED = ("model", "seed")
"""Settings with a row of their own."""


@checked
def compare_runs(runs: Sequence[Path | str] = ()) -> dict[str, Any]:
    """Compare runs: their data, the settings in which they differ, and their results.

    Parameters
    ----------
    runs : sequence of path
        Folders of runs, two or more, finished or not.

    Returns
    -------
    dict
        ``runs``, ``facts``, ``settings`` and ``results``: of the last three a list of values by name, one for each
        run, None where a run has none. ``settings`` are those that all runs have and that differ; ``results`` the
        validation at the end of training, and the figures of ``evaluate``. ``notes`` says why results do not compare.

    Raises
    ------
    ParameterError
        If there are fewer than two runs.
    RunError
        If a folder is no run, or its files are broken.
    """
    from tactogram.recipe import dotted
    from tactogram.training.run import open_run

    if len(runs) < 2:
        raise ParameterError(f"comparing needs two runs or more, got {len(runs)}")
    opened = [open_run(run) for run in runs]
    settings = [dotted(run.recipe.model_dump(mode="json")) for run in opened]
    shared = [key for key in settings[0] if all(key in other for other in settings) and key not in OMITTED]
    evaluations = [run.evaluation for run in opened]
    results = [_results(run, evaluation) for run, evaluation in zip(opened, evaluations, strict=True)]
    names = dict.fromkeys(name for figures in results for name in figures)
    return {
        "runs": [str(run.folder) for run in opened],
        "facts": _facts(opened, evaluations),
        "settings": {
            key: [values[key] for values in settings]
            for key in shared
            if any(values[key] != settings[0][key] for values in settings)
        },
        "results": {name: [figures.get(name) for figures in results] for name in names},
        "notes": _notes(evaluations),
    }


def _facts(runs: Sequence[Run], evaluations: Sequence[Mapping[str, Any]]) -> dict[str, list[Any]]:
    """Return what a run is and what it was trained and evaluated on."""
    return {
        "model": [run.recipe.model for run in runs],
        "seed": [run.recipe.seed for run in runs],
        "trained on": [run.data["name"] for run in runs],
        "finished": [run.finished for run in runs],
        "evaluated on": [evaluation.get("data", {}).get("split") for evaluation in evaluations],
    }


def _notes(evaluations: Sequence[Mapping[str, Any]]) -> list[str]:
    tested = {
        (evaluation["data"]["sha256"], evaluation["data"]["split"])
        for evaluation in evaluations
        if evaluation.get("data")
    }
    if not all(evaluations):
        return ["a run without figures was not evaluated: tactogram evaluate RUN"]
    return ["the runs were evaluated on different recordings: their figures do not compare"] * (
        len(tested) > 1
    )


def _results(run: Run, evaluation: Mapping[str, Any]) -> dict[str, float]:
    from tactogram.workflows.results_table import evaluation_results, numbers_of

    validation = numbers_of(run.facts().get("validation")) if run.finished else {}
    return {f"validation {name}": value for name, value in validation.items()} | evaluation_results(
        evaluation
    )
