"""Options of a kind of task, read from the task's file."""

from __future__ import annotations

from typing import TypeVar

from pydantic import BaseModel, ConfigDict

from tactogram.benchmark.task import BenchmarkTask
from tactogram.validation import validated


class TaskOptions(BaseModel):
    """Base of the options of a kind. Unknown keys are errors."""

    model_config = ConfigDict(frozen=True, extra="forbid")


Options = TypeVar("Options", bound=TaskOptions)


def options_of(task: BenchmarkTask, kind: type[Options]) -> Options:
    """Return the options of a task as those of its kind; a `ParameterError` names an unknown key."""
    return validated(kind, task.options, where=f"{task.file}: options")
