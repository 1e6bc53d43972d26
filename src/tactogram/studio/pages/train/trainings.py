"""Long errands of the studio, trainings above all: processes of the same command line that survive the server.

Each has a record ``studio/trainings/ID.json`` and a log ``ID.log`` beside it. What state it is in follows from the
record, the process, and what lies in the folder it makes, so that a server that was restarted finds all of it.
"""

from __future__ import annotations

import json
import os
import re
import secrets
import shutil
import threading
import time
from collections.abc import Sequence
from dataclasses import asdict, dataclass, field, replace
from datetime import UTC, datetime
from pathlib import Path
from typing import Any, Literal

from tactogram.datasets.store.pending import clear_stale_parts
from tactogram.errors import DataError, ParameterError
from tactogram.signal.io.atomic import write_text
from tactogram.studio.pages.train.detached import DetachedProcess, start
from tactogram.studio.pages.train.log import TaskProgress, complaint, is_stopped, step_of
from tactogram.studio.workspace.folder import Workspace
from tactogram.workflows.training.run_lock import is_training

Kind = Literal["train", "evaluate", "simulate", "import"]
State = Literal["waiting", "running", "stopping", "stopped", "finished", "failed"]
ID = re.compile(r"\d{8}-\d{6}-[0-9a-f]{6}")
MADE = {
    "train": "model.json",
    "evaluate": "evaluation.json",
    "simulate": "dataset.json",
    "import": "dataset.json",
}
"""What lies in the folder when it is done."""
LOG_BYTES = 64 * 1024
"""How much of the end of a log is looked at."""
KILLED = "it ended without a word: it was killed, or the machine was switched off"
ENDED = "it was ended at once, as asked"
GONE_ON = "a process that was begun elsewhere went on with it, and ended before the run was finished"


@dataclass(frozen=True)
class StudioTask:
    """One errand: what was asked, and the process that does it.

    Parameters
    ----------
    id : str
    kind : str
        One of `Kind`.
    arguments : tuple of str
        Of ``tactogram``, verb first; paths relative to the workspace.
    about : str
        The folder that it makes or writes into, relative to the workspace.
    asked_at : str
        ISO 8601, UTC.
    process : Process, optional
        None while it waits.
    stop_asked : bool
    began_at : float
        Seconds since 1970, of the last start.
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
        """The equal command line."""
        return command_line(self.arguments)


@dataclass(frozen=True)
class TaskStatus:
    """Status of a task.

    Parameters
    ----------
    state : str
    line : str
        Why it failed, or what it said at its end; empty where there is nothing to say.
    step : Step, optional
        How far it is.
    """

    state: State
    line: str = ""
    step: TaskProgress | None = None

    @property
    def active(self) -> bool:
        """Whether a process is at it, or will be."""
        return self.state in ("waiting", "running", "stopping")


@dataclass
class TaskQueue:
    """The errands of a workspace.

    Parameters
    ----------
    workspace : Workspace
    most : int
        How many run at once; the rest wait.
    """

    workspace: Workspace
    most: int = field(default_factory=lambda: max(1, (os.cpu_count() or 2) // 2))
    _lock: threading.RLock = field(default_factory=threading.RLock, repr=False)
    _moving: bool = False

    @property
    def folder(self) -> Path:
        """Where the records lie."""
        return self.workspace.own / "trainings"

    # -- asking ------------------------------------------------------------------------------------------

    def begin(self, kind: Kind, arguments: Sequence[str], about: Path | str) -> StudioTask:
        """Start an errand, or let it wait for one that runs.

        Raises
        ------
        ParameterError
            If another is at the same folder, or the folder lies outside of the workspace.
        """
        name = self.workspace.name_of(self.workspace.inside(about))
        with self._lock:
            if (other := self.active_at(name)) is not None:
                raise ParameterError(f"{name}: {other.kind} is at it already; wait for it, or stop it")
            identifier = f"{datetime.now(UTC):%Y%m%d-%H%M%S}-{secrets.token_hex(3)}"
            now = datetime.now(UTC).isoformat(timespec="seconds")
            self._write(StudioTask(identifier, kind, tuple(arguments), name, now))
            self.advance()
            return self.get(identifier)

    def resume(self, identifier: str) -> StudioTask:
        """Go on with what was stopped or failed: from the start, or where there is a run already from where it is.

        Raises
        ------
        ParameterError
            If it runs, or came to its end.
        """
        with self._lock:
            task = self.get(identifier)
            state = self.status(task).state
            if state not in ("stopped", "failed"):
                raise ParameterError(f"{task.about}: {state}; only what was stopped or failed can go on")
            if (other := self.active_at(task.about)) is not None:
                raise ParameterError(f"{task.about}: {other.kind} is at it already; wait for it, or stop it")
            if is_training(self.place(task)):
                raise ParameterError(f"{task.about}: a process that was begun elsewhere trains it at present")
            arguments = task.arguments
            if task.kind == "train" and (self.place(task) / "recipe.toml").is_file():
                arguments = resuming(task.about)
            self._write(replace(task, arguments=arguments, process=None, stop_asked=False))
            self.advance()
            return self.get(identifier)

    def resume_run(self, run: Path | str) -> StudioTask:
        """Go on with an unfinished run, whoever began it, as it was asked for.

        Raises
        ------
        ParameterError
            If a process is at it, here or at the command line.
        """
        folder = self.workspace.inside(run)
        name = self.workspace.name_of(folder)
        made = next((task for task in self.of(name) if task.kind == "train"), None)
        if made is not None:
            return self.resume(made.id)
        if is_training(folder):
            raise ParameterError(f"{name}: a process that was begun elsewhere trains it at present")
        return self.begin("train", resuming(name), name)

    def stop(self, identifier: str, *, at_once: bool = False) -> None:
        """Ask the process to end; a training writes a checkpoint first. What waits is taken out.

        Parameters
        ----------
        identifier : str
        at_once : bool
            Kill it: what it did since its last checkpoint is lost.
        """
        with self._lock:
            task = self.get(identifier)
            self._write(replace(task, stop_asked=True))
            if task.process is not None:
                _ = task.process.end() if at_once else task.process.ask_to_end()

    def forget(self, identifier: str) -> None:
        """Remove the record of a task that is over, and what it left half made; what it made stays."""
        with self._lock:
            task = self.get(identifier)
            if self.status(task).active:
                raise ParameterError(f"{task.about}: stop it first")
            if task.kind in ("simulate", "import"):
                clear_stale_parts(self.place(task))
            for suffix in (".log", ".json"):
                (self.folder / (identifier + suffix)).unlink(missing_ok=True)

    def delete_run(self, run: Path) -> None:
        """Delete the folder of a run with all that is known of it.

        Raises
        ------
        ParameterError
            If something is at it, or it is no run inside the workspace.
        """
        folder = self.workspace.inside(run)
        if folder == self.workspace.folder or not (folder / "recipe.toml").is_file():
            raise ParameterError(f"{run}: not a run of this workspace")
        with self._lock:
            name = self.workspace.name_of(folder)
            if (other := self.active_at(name)) is not None:
                raise ParameterError(f"{name}: {other.kind} is at it; stop it before the run is deleted")
            if is_training(folder):
                raise ParameterError(f"{name}: a process trains it; stop it before the run is deleted")
            folder.rename(folder.with_name(f".{folder.name}-{secrets.token_hex(3)}.gone"))
            for gone in folder.parent.glob(f".*-{'[0-9a-f]' * 6}.gone"):  # a server that was killed left some
                shutil.rmtree(gone, ignore_errors=True)
            for task in self.all():
                if task.about == name:
                    self.forget(task.id)

    # -- looking -----------------------------------------------------------------------------------------

    def all(self) -> list[StudioTask]:
        """Return every task, newest first; a record that cannot be read is left out."""
        found = []
        for path in sorted(self.folder.glob("*.json"), reverse=True) if self.folder.is_dir() else []:
            try:
                found.append(self.get(path.stem))
            except DataError:
                continue
        return found

    def get(self, identifier: str) -> StudioTask:
        """Return one task.

        Raises
        ------
        DataError
            If there is none of this id, or its record is broken.
        """
        path = self.folder / f"{identifier}.json"
        if not ID.fullmatch(identifier) or not path.is_file():
            raise DataError(f"no training {identifier[:40]!r}; it was removed, or never there")
        try:
            values: dict[str, Any] = json.loads(path.read_text(encoding="utf-8"))
            values["arguments"] = tuple(values["arguments"])
            values["process"] = DetachedProcess(**values["process"]) if values["process"] else None
            return StudioTask(**values)
        except (OSError, ValueError, TypeError, KeyError) as error:
            raise DataError(f"{path}: not readable: {error}") from error

    def status(self, task: StudioTask) -> TaskStatus:
        """Return how it stands with a task, from its process, its log and its folder."""
        text = self.log(task)
        step = step_of(text, self.place(task) if task.kind == "train" else None)
        if task.process is None:
            return TaskStatus("stopped", "it had not begun") if task.stop_asked else TaskStatus("waiting")
        if task.process.alive():
            return TaskStatus("stopping" if task.stop_asked else "running", step=step)
        why = complaint(text)
        if self._made(task) and why is None:
            return TaskStatus("finished", step=step)
        if why is not None and self._gone_on(task):
            return TaskStatus("stopped", GONE_ON)
        if why is not None and not is_stopped(why):
            return TaskStatus("failed", why, step)
        if task.stop_asked or why is not None or (self.place(task) / "checkpoint.safetensors").is_file():
            return TaskStatus("stopped", why or (ENDED if task.stop_asked else KILLED), step)
        return TaskStatus("failed", KILLED, step)

    def log(self, task: StudioTask) -> str:
        """Return the end of what its process said."""
        path = self.folder / f"{task.id}.log"
        if task.process is None or not path.is_file():
            return ""
        with path.open("rb") as file:
            file.seek(max(0, path.stat().st_size - LOG_BYTES))
            return file.read().decode("utf-8", "replace")

    def place(self, task: StudioTask) -> Path:
        """Return the folder that it makes or writes into."""
        return self.workspace.folder / task.about

    def active_at(self, about: str) -> StudioTask | None:
        """Return the task that is at a folder, given relative to the workspace, or will be."""
        held = (task for task in self.all() if task.about == about)
        return next((task for task in held if self.status(task).active), None)

    def of(self, about: str) -> list[StudioTask]:
        """Return the tasks about a folder, newest first."""
        return [task for task in self.all() if task.about == about]

    # -- moving on ---------------------------------------------------------------------------------------

    def advance(self) -> None:
        """Start what waits as far as there is room, the one that was asked first before the others."""
        with self._lock:
            tasks = [(task, self.status(task).state) for task in reversed(self.all())]
            room = self.most - sum(state in ("running", "stopping") for _, state in tasks)
            for task in [task for task, state in tasks if state == "waiting"][: max(0, room)]:
                process = start(
                    task.arguments, folder=self.workspace.folder, log=self.folder / f"{task.id}.log"
                )
                self._write(replace(task, process=process, began_at=time.time()))

    def keep_advancing(self, every_s: float = 1.0) -> None:
        """Call `advance` from now on, in a thread that ends with the server."""
        with self._lock:
            if self._moving:
                return
            self._moving = True

        def move() -> None:
            while True:
                time.sleep(every_s)
                if any(task.process is None and not task.stop_asked for task in self.all()):
                    self.advance()

        threading.Thread(target=move, name="trainings", daemon=True).start()

    def _made(self, task: StudioTask) -> bool:
        """Say whether what it makes is there, and of this start."""
        file = self.place(task) / MADE[task.kind]
        return file.is_file() and (task.kind != "evaluate" or file.stat().st_mtime >= task.began_at - 1)

    def _gone_on(self, task: StudioTask) -> bool:
        """Say whether a run got a checkpoint after the last word of the training that this studio began."""
        try:
            checkpoint = (self.place(task) / "checkpoint.safetensors").stat().st_mtime
            return checkpoint > (self.folder / f"{task.id}.log").stat().st_mtime
        except OSError:
            return False

    def _write(self, task: StudioTask) -> None:
        write_text(self.folder / f"{task.id}.json", json.dumps(asdict(task), ensure_ascii=False, indent=1))


_open: dict[Path, TaskQueue] = {}


def trainings_of(workspace: Workspace) -> TaskQueue:
    """Return the errands of a workspace, the same for all pages of a server."""
    return _open.setdefault(workspace.folder, TaskQueue(workspace))


def resuming(run: str) -> tuple[str, ...]:
    """Return what ``tactogram`` is given to go on with a run."""
    return ("train", "--resume", run)


def command_line(arguments: Sequence[str]) -> str:
    """Return what one would type for ``arguments``."""
    import shlex

    return shlex.join(["tactogram", *arguments])


def free_name(folder: Path, name: str, suffix: str = "") -> str:
    """Return ``name``, or ``name-2``, ``name-3``, … with ``suffix``, whichever is free in ``folder``."""
    number, free = 1, name + suffix
    while (folder / free).exists():
        number += 1
        free = f"{name}-{number}{suffix}"
    return free
