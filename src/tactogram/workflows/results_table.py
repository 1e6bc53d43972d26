"""Published results and ours, from each model's results.toml, and the figures of evaluated runs."""

from __future__ import annotations

import tomllib
from collections.abc import Iterator, Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

from tactogram import models
from tactogram.errors import RunError
from tactogram.validation import FrozenModel, validated

if TYPE_CHECKING:
    from tactogram.training.run import Run


class PublishedResult(FrozenModel):
    """A line of a results.toml: one figure, published and ours."""

    what: str
    """Name of the figure, with its unit."""
    published: float | None = None
    """Value printed in the publication, if any."""
    where: str = ""
    """Table or section of the publication."""
    ours: float | None = None
    """Measured value, if any."""
    sd: float | None = None
    """Standard deviation of ours over seeds or folds."""
    data: str = ""
    """Data of our value, with "simulated" if it was."""
    split: str = ""
    seeds: int = 1
    recipe: str = ""
    note: str = ""
    """Reason for the difference, above all in data."""


def table(model_folders: Sequence[Path] = (), *, runs: Sequence[Path | str] = ()) -> list[dict[str, Any]]:
    """Return one row per figure of every model and of evaluated ``runs``: ``model`` and fields of `PublishedResult`.

    Raises `RunError` if one of ``runs`` is no run, or was not evaluated.
    """
    rows = [row for run in runs for row in _of_run(_opened(run))]
    for name, facts in models.available(model_folders).items():
        file = facts.folder / "results.toml"
        if file.exists():
            lines = tomllib.loads(file.read_text(encoding="utf-8")).get("result", [])
            results = [validated(PublishedResult, line, where=str(file)) for line in lines]
            rows += [{"model": name, **result.model_dump()} for result in results]
    return rows


def _opened(run: Path | str) -> Run:
    # Loads torch, which pages and a table without runs do not need.
    from tactogram.training.run import open_run

    return open_run(run)


def _of_run(run: Run) -> Iterator[dict[str, Any]]:
    evaluation = run.evaluation
    if not evaluation:
        raise RunError(f"{run.folder}: was not evaluated: tactogram evaluate {run.folder}")
    data: Mapping[str, Any] = evaluation.get("data", {})
    name = f"{data.get('name', '')}{' (simulated)' if data.get('simulated') else ''}"
    for what, value in evaluation_results(evaluation).items():
        result = PublishedResult(
            what=what, ours=value, data=name, split=str(data.get("split", "")), note=str(run.folder)
        )
        yield {"model": run.recipe.model, **result.model_dump()}


def evaluation_results(evaluation: Mapping[str, Any]) -> dict[str, float]:
    """Return the results in an ``evaluation.json`` by name; for a generator's measures, the model's column."""
    results = {name: value for name, value in numbers_of(evaluation).items() if "accuracy" in name}
    for measure, row in evaluation.get("measures", {}).items():
        if isinstance(row, Mapping) and isinstance(row.get("model"), int | float):
            results[str(measure)] = float(row["model"])
    for table in ("spread", "following", "mean"):
        results |= {f"{table} {name}": value for name, value in numbers_of(evaluation.get(table)).items()}
    return results


def numbers_of(values: Any) -> dict[str, float]:
    """Return the numbers of a JSON object by name; none of anything else."""
    if not isinstance(values, Mapping):
        return {}
    return {
        str(name): float(value)
        for name, value in values.items()
        if isinstance(value, int | float) and not isinstance(value, bool)
    }
