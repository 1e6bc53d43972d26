"""Benchmark task: a TOML file that fixes the data, the split, what is given and what is asked."""

from __future__ import annotations

import hashlib
import json
from collections.abc import Sequence
from functools import cached_property
from pathlib import Path
from typing import Any, Literal, TypeVar

from pydantic import Field

from tactogram.datasets import Split
from tactogram.errors import DataError, ParameterError
from tactogram.plugins import further_folders
from tactogram.recipe import Preparation
from tactogram.text_files import read_toml
from tactogram.validation import FrozenModel, validated

TASKS = Path(__file__).parent / "tasks"
FOLDERS_VARIABLE = "TACTOGRAM_TASKS"
"""Environment variable with further folders of tasks, separated as in PATH."""


class TaskOptions(FrozenModel):
    """Base of the options of a kind, and of other parts of a task. Unknown keys are errors."""


class TaskData(TaskOptions):
    """The store of a task. Unknown keys are errors."""

    name: str
    """Name in the store's ``dataset.json``."""
    sha256: str = Field(pattern="^[0-9a-f]{64}$")
    """Hash of the store: another version of the data is another task."""
    what: str
    """What was recorded, for tables."""
    simulate: dict[str, Any] = Field(default_factory=dict)
    """Arguments of `tactogram data simulate` that make it again, ``set_name`` among them; empty if it was recorded."""
    importer: str = ""
    """Name for `tactogram data import`, of recorded data."""

    @property
    def simulated(self) -> bool:
        """Whether it is simulated."""
        return bool(self.simulate)


class TaskRecipe(TaskOptions):
    """The recipe by which one model is trained for a task, where it is not its ``quick`` one."""

    recipe: str = "quick"
    changes: dict[str, Any] = Field(default_factory=dict)
    """Values by dotted key."""


class TaskDescription(TaskOptions):
    """Content of a task's file. Unknown keys are errors."""

    title: str = Field(min_length=1)
    kind: str
    """Module of `tactogram_benchmark.kinds`."""
    data: TaskData
    split: str
    """File of the split, beside the task's."""
    split_sha256: str = Field(pattern="^[0-9a-f]{64}$")
    prepare: Preparation = Preparation()
    """How recordings are prepared before any model is given them."""
    label: Literal["material", "material+contactor", "item"] = "material"
    options: dict[str, Any] = Field(default_factory=dict)
    """Of the kind of task."""
    recipes: dict[str, TaskRecipe] = Field(default_factory=dict)
    """By model."""
    seeds: tuple[int, ...] = (0, 1, 2)
    aggregate_only: bool = False
    """Whether results keep no value of an item, sound or picture: for data that may not be passed on."""
    choose_on: str = "the validation part"
    """What may be used to choose among models or their settings."""


class BenchmarkTask(TaskDescription):
    """A task, its name and its file."""

    name: str
    file: Path

    @cached_property
    def sha256(self) -> str:
        """Hash of everything that decides a result: a result is of one hash."""
        unhashed = {"title", "file", "seeds", "recipes", "choose_on", "aggregate_only"}
        facts = self.model_dump(mode="json", exclude=unhashed)
        del facts["data"]["what"]
        return hashlib.sha256(json.dumps(facts, sort_keys=True).encode()).hexdigest()

    def load_split(self) -> Split:
        """Return the split.

        Raises
        ------
        DataError
            If the file is missing, or is not the one that the task was written for.
        LeakError
            If it leaks.
        """
        path = self.file.parent / self.split
        try:
            content = path.read_bytes()
        except OSError as error:
            raise DataError(path, f"expected the split of {self.name}, got {error.strerror}") from error
        digest = hashlib.sha256(content).hexdigest()
        if digest != self.split_sha256:
            raise DataError(
                path,
                f"SHA-256 must be {self.split_sha256[:12]}… as {self.file.name} states, got {digest[:12]}…; "
                "restore the file, or give the changed task another name",
            )
        return Split.load(path)


def available_tasks(folders: Sequence[Path | str] = ()) -> dict[str, BenchmarkTask]:
    """Return every task by name: those of the package and of further folders.

    Raises
    ------
    DataError
        If a file is not TOML.
    ParameterError
        If a task is invalid, a folder has none, or two tasks have one name.
    """
    tasks: dict[str, BenchmarkTask] = {}
    for folder in (TASKS, *further_folders(FOLDERS_VARIABLE, folders)):
        files = sorted(folder.glob("*.toml"))
        if not files:
            raise ParameterError(f"{folder}: expected a folder of tasks, found no .toml file in it")
        for file in files:
            if file.stem in tasks:
                if tasks[file.stem].file.resolve() == file.resolve():
                    continue
                raise ParameterError(f"two tasks are called {file.stem!r}: {tasks[file.stem].file}, {file}")
            described = validated(TaskDescription, read_toml(file), where=str(file))
            tasks[file.stem] = BenchmarkTask(**dict(described), name=file.stem, file=file)
    return tasks


def find_task(name: str, folders: Sequence[Path | str] = ()) -> BenchmarkTask:
    """Return the task called ``name``; `ParameterError` if there is none."""
    tasks = available_tasks(folders)
    if name not in tasks:
        raise ParameterError.one_of("task", tasks, name)
    return tasks[name]


Options = TypeVar("Options", bound=TaskOptions)


def options_of(task: BenchmarkTask, kind: type[Options]) -> Options:
    """Return the options of a task as those of its kind; a `ParameterError` names an unknown key."""
    return validated(kind, task.options, where=f"{task.file}: options")
