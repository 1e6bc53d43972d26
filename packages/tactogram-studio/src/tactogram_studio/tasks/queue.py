"""Task queue of the studio: trainings and other long tasks, as command line processes that outlive the server.

Each task has a record ``studio/trainings/ID.json`` and a log ``ID.log``. Its state follows from the record, the process
and the contents of its output folder, so a restarted server finds every task again.
"""

from __future__ import annotations

import json
import os
import re
import secrets
import shutil
import threading
import time
from collections import deque
from collections.abc import Sequence
from contextlib import suppress
from dataclasses import asdict, dataclass, field, replace
from datetime import UTC, datetime
from pathlib import Path
from typing import Any, Literal

from tactogram.datasets import clear_stale_parts
from tactogram.errors import DataError, ParameterError
from tactogram.signal.io import write_text
from tactogram.workflows import is_training
from tactogram_studio.tasks.log import (
    DetachedProcess,
    TaskProgress,
    last_message,
    progress_of,
    reports_stop,
    start,
)
from tactogram_studio.workspace.commands import command_line
from tactogram_studio.workspace.folder import Workspace

Kind = Literal["train", "evaluate", "simulate", "import"]
State = Literal["waiting", "running", "stopping", "stopped", "finished", "failed"]
NAME = re.compile(r"[A-Za-z0-9_][A-Za-z0-9_.-]{0,79}")
ID = re.compile(r"\d{8}-\d{6}-[0-9a-f]{6}")
OUTPUTS = {
    "train": "model.json",
    "evaluate": "evaluation.json",
    "simulate": "dataset.json",
    "import": "dataset.json",
}
"""File in the output folder that marks a finished task."""
NOUNS = {
    "train": "a training",
    "evaluate": "an evaluation",
    "simulate": "a simulation",
    "import": "an import",
}
LOG_BYTES = 64 * 1024
"""Length of the end of a log that is read."""
KILLED = "it ended without a message: it was killed, or the machine was switched off"
STOPPED_NOW = "stopped immediately on request"
CONTINUED = "another process, started outside the studio, continued this run and ended before it was finished"


@dataclass(frozen=True)
class StudioTask:
    """Record of a task; ``process`` is None while it waits.

    ``arguments`` are those of ``tactogram``, and ``about`` is the output folder, with paths relative to the workspace.
    ``asked_at`` is in ISO 8601, UTC; ``began_at``, of the last start, in s since 1970.
    """

    id: str
    kind: Kind
    arguments: tuple[str, ...]
    about: str
    asked_at: str
    process: DetachedProcess | None = None
    stop_asked: bool = False
    began_at: float = 0.0

    @property
    def command(self) -> str:
        """The equivalent shell command."""
        return command_line(self.arguments)


@dataclass(frozen=True)
class TaskStatus:
    """Status of a task; ``message`` says why it failed or stopped."""

    state: State
    message: str = ""
    progress: TaskProgress | None = None

    @property
    def active(self) -> bool:
        """Whether it is running or waiting to run."""
        return self.state in ("waiting", "running", "stopping")


@dataclass
class TaskQueue:
    """The tasks of a workspace; at most ``max_running`` run at once, the others wait.

    ``readings`` are each task's progress over time, s, as pages have shown it.
    """

    workspace: Workspace
    max_running: int = field(default_factory=lambda: max(1, (os.cpu_count() or 2) // 2))
    readings: dict[str, deque[tuple[float, TaskProgress]]] = field(default_factory=dict, repr=False)
    _lock: threading.RLock = field(default_factory=threading.RLock, repr=False)
    _advancing: bool = False

    @property
    def folder(self) -> Path:
        """Folder of records and logs."""
        return self.workspace.studio_folder / "trainings"

    def begin_new(self, kind: Kind, arguments: Sequence[str], about: Path | str) -> StudioTask:
        """Start a task as by `begin`; refuse an output folder that exists."""
        output = self.new_output(about)
        output.parent.mkdir(parents=True, exist_ok=True)
        return self.begin(kind, arguments, output)

    def new_output(self, about: Path | str) -> Path:
        """Return an output folder; raise `ParameterError` if it exists."""
        output = self.workspace.inside(about)
        if output.exists():
            raise ParameterError(f"{about}: already exists; choose another name")
        return output

    def begin(self, kind: Kind, arguments: Sequence[str], about: Path | str) -> StudioTask:
        """Start a task, or queue it; refuse a folder that another task uses, or outside the workspace."""
        name = self.workspace.name_of(self.workspace.inside(about))
        with self._lock:
            self._refuse_if_used(name)
            identifier = f"{datetime.now(UTC):%Y%m%d-%H%M%S}-{secrets.token_hex(3)}"
            now = datetime.now(UTC).isoformat(timespec="seconds")
            self._write(StudioTask(identifier, kind, tuple(arguments), name, now))
            self.advance()
            return self.get(identifier)

    def resume(self, identifier: str) -> StudioTask:
        """Restart a stopped or failed task; a training with a run folder continues from its checkpoint."""
        with self._lock:
            task = self.get(identifier)
            state = self.status(task).state
            if state not in ("stopped", "failed"):
                raise ParameterError(f"{task.about}: {state}; only stopped or failed tasks can be resumed")
            self._refuse_if_used(task.about)
            self._refuse_if_trained(self.output(task), "wait for it")
            arguments = task.arguments
            if task.kind == "train" and (self.output(task) / "recipe.toml").is_file():
                arguments = _resume_arguments(task.about)
            self._write(replace(task, arguments=arguments, process=None, stop_asked=False))
            self.readings.pop(identifier, None)
            self.advance()
            return self.get(identifier)

    def resume_run(self, run: Path | str) -> StudioTask:
        """Continue an unfinished run with its original settings, wherever it was started."""
        folder = self.workspace.inside(run)
        name = self.workspace.name_of(folder)
        training = next((task for task in self.of(name) if task.kind == "train"), None)
        if training is not None:
            return self.resume(training.id)
        self._refuse_if_trained(folder, "wait for it")
        return self.begin("train", _resume_arguments(name), name)

    def stop(self, identifier: str, *, at_once: bool = False) -> None:
        """Ask the process to end; a training first writes a checkpoint. A waiting task leaves the queue.

        With ``at_once`` the process is killed: progress since the last checkpoint is lost.
        """
        with self._lock:
            task = self.get(identifier)
            self._write(replace(task, stop_asked=True))
            if task.process is not None:
                _ = task.process.kill() if at_once else task.process.terminate()

    def forget(self, identifier: str) -> None:
        """Remove the record and partial output of a task that has ended; finished output stays."""
        with self._lock:
            task = self.get(identifier)
            if self.status(task).active:
                raise ParameterError(f"{task.about}: stop it first")
            if task.kind in ("simulate", "import"):
                clear_stale_parts(self.output(task))
            for suffix in (".log", ".json"):
                (self.folder / (identifier + suffix)).unlink(missing_ok=True)

    def delete_run(self, run: Path) -> None:
        """Delete a run folder with the records of its tasks, unless a process uses it."""
        folder = self.workspace.inside(run)
        if folder == self.workspace.folder or not (folder / "recipe.toml").is_file():
            raise ParameterError(f"{run}: not a run of this workspace")
        with self._lock:
            name = self.workspace.name_of(folder)
            self._refuse_if_used(name)
            self._refuse_if_trained(folder, "stop it before you delete the run")
            folder.rename(folder.with_name(f".{folder.name}-{secrets.token_hex(3)}.gone"))
            for gone in folder.parent.glob(
                f".*-{'[0-9a-f]' * 6}.gone"
            ):  # includes leftovers of killed servers
                shutil.rmtree(gone, ignore_errors=True)
            for task in self.of(name):
                self.forget(task.id)

    def _refuse_if_used(self, name: str) -> None:
        """Raise if a task is active in a folder, given relative to the workspace."""
        active = next((task for task in self.of(name) if self.status(task).active), None)
        if active is not None:
            raise ParameterError(f"{name}: in use by {NOUNS[active.kind]}; wait for it, or stop it first")

    def _refuse_if_trained(self, folder: Path, remedy: str) -> None:
        """Raise if a process of any origin is training a run."""
        if is_training(folder):
            name = self.workspace.name_of(folder)
            raise ParameterError(f"{name}: a process started outside the studio is training it; {remedy}")

    def all(self) -> list[StudioTask]:
        """Return every task, newest first, without unreadable records."""
        tasks = []
        for path in sorted(self.folder.glob("*.json"), reverse=True) if self.folder.is_dir() else []:
            with suppress(DataError):
                tasks.append(self.get(path.stem))
        return tasks

    def get(self, identifier: str) -> StudioTask:
        """Return a task; raise `DataError` if there is none with this id, or its record is broken."""
        path = self.folder / f"{identifier}.json"
        if not ID.fullmatch(identifier) or not path.is_file():
            raise DataError(f"no task {identifier[:40]!r}; it may have been removed")
        try:
            values: dict[str, Any] = json.loads(path.read_text(encoding="utf-8"))
            values["arguments"] = tuple(values["arguments"])
            values["process"] = DetachedProcess(**values["process"]) if values["process"] else None
            return StudioTask(**values)
        except (OSError, ValueError, TypeError, KeyError) as error:
            raise DataError(path, f"not readable: {error}") from error

    def status(self, task: StudioTask) -> TaskStatus:
        """Return the status of a task, from its process, log and output folder."""
        if task.process is None:
            return (
                TaskStatus("stopped", "stopped before it began") if task.stop_asked else TaskStatus("waiting")
            )
        text = self.log(task)
        progress = progress_of(text, self.output(task) if task.kind == "train" else None)
        if task.process.alive():
            return TaskStatus("stopping" if task.stop_asked else "running", progress=progress)
        message = last_message(text)
        if self._finished(task) and message is None:
            return TaskStatus("finished", progress=progress)
        if message is not None and self._continued_elsewhere(task):
            return TaskStatus("stopped", CONTINUED)
        if message is not None and not reports_stop(message):
            return TaskStatus("failed", message, progress)
        if task.stop_asked or message is not None or (self.output(task) / "checkpoint.safetensors").is_file():
            return TaskStatus("stopped", message or (STOPPED_NOW if task.stop_asked else KILLED), progress)
        return TaskStatus("failed", KILLED, progress)

    def log(self, task: StudioTask) -> str:
        """Return the end of a task's log."""
        path = self.folder / f"{task.id}.log"
        if task.process is None or not path.is_file():
            return ""
        with path.open("rb") as file:
            file.seek(max(0, path.stat().st_size - LOG_BYTES))
            return file.read().decode("utf-8", "replace")

    def output(self, task: StudioTask) -> Path:
        """Return the output folder of a task."""
        return self.workspace.folder / task.about

    def of(self, about: str) -> list[StudioTask]:
        """Return the tasks of an output folder, newest first."""
        return [task for task in self.all() if task.about == about]

    def advance(self) -> None:
        """Start waiting tasks, oldest first, up to the limit."""
        with self._lock:
            tasks = [(task, self.status(task).state) for task in reversed(self.all())]
            room = self.max_running - sum(state in ("running", "stopping") for _, state in tasks)
            for task in [task for task, state in tasks if state == "waiting"][: max(0, room)]:
                log = self.folder / f"{task.id}.log"
                process = start(task.arguments, folder=self.workspace.folder, log=log)
                self._write(replace(task, process=process, began_at=time.time()))

    def keep_advancing(self, every_s: float = 1.0) -> None:
        """Call `advance` regularly in a daemon thread, started once."""
        with self._lock:
            if self._advancing:
                return
            self._advancing = True

        def run() -> None:
            while True:
                time.sleep(every_s)
                if any(task.process is None and not task.stop_asked for task in self.all()):
                    self.advance()

        threading.Thread(target=run, name="trainings", daemon=True).start()

    def _finished(self, task: StudioTask) -> bool:
        """Return whether the output is complete; that of an evaluation must be newer than its start."""
        file = self.output(task) / OUTPUTS[task.kind]
        return file.is_file() and (task.kind != "evaluate" or file.stat().st_mtime >= task.began_at - 1)

    def _continued_elsewhere(self, task: StudioTask) -> bool:
        """Return whether the run has a checkpoint that is newer than the task's log."""
        try:
            checkpoint = (self.output(task) / "checkpoint.safetensors").stat().st_mtime
            return checkpoint > (self.folder / f"{task.id}.log").stat().st_mtime
        except OSError:
            return False

    def _write(self, task: StudioTask) -> None:
        write_text(self.folder / f"{task.id}.json", json.dumps(asdict(task), ensure_ascii=False, indent=1))


_queues: dict[Path, TaskQueue] = {}


def trainings_of(workspace: Workspace) -> TaskQueue:
    """Return the task queue of a workspace, shared by all pages of a server."""
    return _queues.setdefault(workspace.folder, TaskQueue(workspace))


def _resume_arguments(run: str) -> tuple[str, ...]:
    return ("train", "--resume", run)


def output_name(folder: str, name: str | None) -> str:
    """Return an output folder below ``folder``, by its name; raise `ParameterError` if that is no folder name."""
    text = (name or "").strip()
    if not NAME.fullmatch(text):
        raise ParameterError(
            "Name: must be letters, digits, '.', '_' and '-', at most 80, not starting with '.' or '-', "
            f"got {text[:100]!r}"
        )
    return f"{folder}/{text}"
