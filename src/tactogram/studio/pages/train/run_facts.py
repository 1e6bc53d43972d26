"""Run summaries for lists and comparisons, read without the networks."""

from __future__ import annotations

import json
import tomllib
from collections.abc import Mapping
from contextlib import suppress
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from tactogram.workflows.training.run_lock import is_training


@dataclass(frozen=True)
class RunSummary:
    """A run as a list shows it.

    Parameters
    ----------
    folder : Path
    model : str
    finished : bool
    at_work : bool
        Whether a process trains it at present, begun by a studio or elsewhere.
    data : mapping
        ``data.json``; empty where it cannot be read.
    recipe : mapping
        ``recipe.toml``; likewise.
    validation : mapping from str to float
    evaluation : mapping from str to float
        Figures of ``evaluation.json``, by name.
    """

    folder: Path
    model: str
    finished: bool
    at_work: bool = False
    data: Mapping[str, Any] = field(default_factory=dict)
    recipe: Mapping[str, Any] = field(default_factory=dict)
    validation: Mapping[str, float] = field(default_factory=dict)
    evaluation: Mapping[str, float] = field(default_factory=dict)

    @property
    def simulated(self) -> bool:
        """Whether any of its data was simulated."""
        return bool(self.data.get("simulated"))

    @property
    def has_report(self) -> bool:
        """Whether it was evaluated."""
        return (self.folder / "report.html").is_file()


def run_facts(folder: Path) -> RunSummary:
    """Return what a run folder says; what cannot be read is left empty."""
    recipe: Mapping[str, Any] = {}
    with suppress(OSError, ValueError):
        recipe = tomllib.loads((folder / "recipe.toml").read_text(encoding="utf-8"))
    done = _json(folder / "model.json")
    return RunSummary(
        folder,
        str(recipe.get("model", "unknown")),
        (folder / "model.json").is_file(),
        is_training(folder),
        _json(folder / "data.json"),
        recipe,
        _numbers(done.get("validation")),
        figures(_json(folder / "evaluation.json")),
    )


def figures(evaluation: Mapping[str, Any]) -> dict[str, float]:
    """Return the figures of an ``evaluation.json`` by name: of a generator's measures, the model's own column."""
    found = {name: value for name, value in _numbers(evaluation).items() if "accuracy" in name}
    for measure, row in (evaluation.get("measures") or {}).items():
        if isinstance(row, Mapping) and isinstance(row.get("model"), int | float):
            found[str(measure)] = float(row["model"])
    for table in ("spread", "following", "mean"):
        found |= {f"{table} {name}": value for name, value in _numbers(evaluation.get(table)).items()}
    return found


def _numbers(values: Any) -> dict[str, float]:
    if not isinstance(values, Mapping):
        return {}
    return {
        str(name): float(value)
        for name, value in values.items()
        if isinstance(value, int | float) and not isinstance(value, bool)
    }


def _json(path: Path) -> dict[str, Any]:
    try:
        values = json.loads(path.read_text(encoding="utf-8"))
    except (OSError, ValueError):
        return {}
    return values if isinstance(values, dict) else {}
