"""Runs on an object store, such as S3: worked on in a local copy, of which every checkpoint is sent there."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from tactogram.datasets.scratch import scratch_of
from tactogram.datasets.store.remote import RemotePath, location
from tactogram.model import Kind, Learner
from tactogram.training.loop import TrainingPosition
from tactogram.training.run import Run

LAST = ("recipe.toml", "model.json")
"""Files that make a folder a run, and a run finished: sent after the others."""


class _Owner:
    """Lives as long as a run, whose local copy goes with it."""


@dataclass(frozen=True)
class RemoteRun(Run):
    """A run at a URL; ``folder`` is its local copy, which is removed with this.

    Nothing keeps two processes from training at the same URL.
    """

    remote: RemotePath
    owner: _Owner = field(compare=False)
    sent: dict[str, tuple[int, int]] = field(default_factory=dict, compare=False)
    """Size and time of modification of each local file that is at the URL."""

    @classmethod
    def fetch(cls, remote: RemotePath) -> RemoteRun:
        """Return a run with a local copy of all that is at a URL, which may be nothing."""
        owner = _Owner()
        run = cls(scratch_of(owner) / "run", remote, owner)
        for name in remote.files():
            file = run.folder / name
            file.parent.mkdir(parents=True, exist_ok=True)
            file.write_bytes((remote / name).read_bytes())
            run.sent[name] = _state(file)
        return run

    def __reduce__(self) -> tuple[Any, ...]:
        """Pickle as the URL: another process has a local copy of its own."""
        return run_at, (self.place,)

    @property
    def place(self) -> str:
        """The URL."""
        return str(self.remote)

    @property
    def name(self) -> str:
        """The last part of the URL."""
        return self.remote.path.rpartition("/")[2]

    def save_checkpoint(self, learner: Learner, position: TrainingPosition) -> None:
        """Save the state at ``position``, and send it."""
        super().save_checkpoint(learner, position)
        self.publish()

    def finish(self, learner: Learner, kind: Kind, facts: Mapping[str, Any]) -> None:
        """Finish the run, and send it."""
        super().finish(learner, kind, facts)
        self.publish()

    def publish(self) -> None:
        """Send the files that were written since the last time, and remove those that are gone.

        Raises `DataError` if the object store cannot be written to; the local copy is complete.
        """
        there = {
            file.relative_to(self.folder).as_posix(): _state(file)
            for file in sorted(self.folder.rglob("*"), key=lambda file: (file.name in LAST, file))
            if file.is_file() and not file.name.startswith(".")
        }
        for name, state in there.items():
            if self.sent.get(name) != state:
                with (self.remote / name).writing() as out:
                    out.write((self.folder / name).read_bytes())
                self.sent[name] = state
        for name in self.sent.keys() - there.keys():
            (self.remote / name).delete()
            del self.sent[name]


def _state(file: Path) -> tuple[int, int]:
    facts = file.stat()
    return facts.st_size, facts.st_mtime_ns


def run_at(place: Path | str) -> Run:
    """Return the run in a folder or at a URL such as ``s3://bucket/run``, which need not hold one yet."""
    found = location(place)
    return RemoteRun.fetch(found) if isinstance(found, RemotePath) else Run(found)


def open_run(place: Path | str) -> Run:
    """Return the run in a folder or at a URL.

    Raises `RunError` if there is none; `DataError` if the object store cannot be reached.
    """
    run = run_at(place)
    run.check_begun()
    return run
