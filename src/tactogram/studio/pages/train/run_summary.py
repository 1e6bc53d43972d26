"""Run summaries for lists and comparisons, read without loading the model."""

from __future__ import annotations

from collections.abc import Mapping
from contextlib import suppress
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from tactogram.errors import DataError
from tactogram.text_files import read_json, read_toml
from tactogram.workflows.training.run_lock import is_training


@dataclass(frozen=True)
class RunSummary:
    """Summary of a run with its results by name; entries whose file is unreadable are empty.

    ``training`` is whether a process, of any origin, is training it.
    """

    folder: Path
    model: str
    finished: bool
    training: bool = False
    data: Mapping[str, Any] = field(default_factory=dict)
    recipe: Mapping[str, Any] = field(default_factory=dict)
    validation: Mapping[str, float] = field(default_factory=dict)
    evaluation: Mapping[str, float] = field(default_factory=dict)

    @property
    def simulated(self) -> bool:
        """Whether any of its data is simulated."""
        return bool(self.data.get("simulated"))

    @property
    def has_report(self) -> bool:
        """Whether it was evaluated."""
        return (self.folder / "report.html").is_file()


def run_summary(folder: Path) -> RunSummary:
    """Return the summary of a run folder."""
    recipe = _read(folder / "recipe.toml")
    return RunSummary(
        folder,
        str(recipe.get("model", "unknown")),
        (folder / "model.json").is_file(),
        is_training(folder),
        _read(folder / "data.json"),
        recipe,
        _numbers(_read(folder / "model.json").get("validation")),
        evaluation_results(_read(folder / "evaluation.json")),
    )


def evaluation_results(evaluation: Mapping[str, Any]) -> dict[str, float]:
    """Return the results in an ``evaluation.json`` by name; for a generator's measures, the model's column."""
    results = {name: value for name, value in _numbers(evaluation).items() if "accuracy" in name}
    for measure, row in (evaluation.get("measures") or {}).items():
        if isinstance(row, Mapping) and isinstance(row.get("model"), int | float):
            results[str(measure)] = float(row["model"])
    for table in ("spread", "following", "mean"):
        results |= {f"{table} {name}": value for name, value in _numbers(evaluation.get(table)).items()}
    return results


def _numbers(values: Any) -> dict[str, float]:
    if not isinstance(values, Mapping):
        return {}
    return {
        str(name): float(value)
        for name, value in values.items()
        if isinstance(value, int | float) and not isinstance(value, bool)
    }


def _read(path: Path) -> dict[str, Any]:
    with suppress(DataError):
        values = read_toml(path) if path.suffix == ".toml" else read_json(path)
        return values if isinstance(values, dict) else {}
    return {}
