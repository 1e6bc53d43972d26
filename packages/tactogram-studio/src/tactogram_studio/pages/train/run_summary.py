"""Run summaries for lists and comparisons, read without loading the model."""

from __future__ import annotations

from collections.abc import Mapping
from contextlib import suppress
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from tactogram.errors import DataError
from tactogram.text_files import read_json, read_toml
from tactogram.workflows import evaluation_results, is_training, numbers_of
from tactogram_studio.tasks.queue import TaskStatus


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
        numbers_of(_read(folder / "model.json").get("validation")),
        evaluation_results(_read(folder / "evaluation.json")),
    )


def state_of(summary: RunSummary | None, status: TaskStatus | None) -> str:
    """Return the state of a run: of its active task, else according to its folder."""
    if status is not None and status.active:
        return status.state
    if summary is not None and summary.finished:
        return "finished"
    if summary is not None and summary.training:
        return "running"
    return status.state if status is not None else "unfinished"


def _read(path: Path) -> dict[str, Any]:
    with suppress(DataError):
        values = read_toml(path) if path.suffix == ".toml" else read_json(path)
        return values if isinstance(values, dict) else {}
    return {}
