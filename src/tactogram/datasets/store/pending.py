"""Pending files of a store, named and noted so that those of a killed process are found and removed."""

from __future__ import annotations

import os
import re
import shutil
import socket
import time
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from pathlib import Path
from typing import Literal

import psutil

from tactogram.datasets.store.layout import FACTS, StoreInfo
from tactogram.errors import DataError
from tactogram.signal.io.atomic import to_disk

Purpose = Literal["adding", "compacting"]
REPLACED_S = 2.0
"""How long somebody who adds waits for shards to be replaced by those written anew, s: a matter of milliseconds."""


def part_folder(path: Path) -> Path:
    """Return the folder beside ``path`` in which this process makes what will be ``path``."""
    return path.with_name(f"{path.name}.part-{host_name()}-{os.getpid()}")


def clear_stale_parts(path: Path) -> list[Path]:
    """Remove part folders of ``path`` whose process is gone; return those of which that is not known."""
    left = []
    for part in sorted(path.parent.glob(f"{path.name}.part-*")):
        host, _, process = part.name.removeprefix(f"{path.name}.part-").rpartition("-")
        if host == host_name() and process.isdigit() and not psutil.pid_exists(int(process)):
            shutil.rmtree(part, ignore_errors=True)
        elif not (host == host_name() and process == str(os.getpid())):
            left.append(part)
    return left


def clear_unfinished(path: Path, *, own: bool = True) -> list[str]:
    """Remove what a killed process left in the store ``path`` on its way into it, and return the files' names.

    Only what was noted before it was written, and what ``dataset.json`` does not name: a reader of all
    ``shard-*.parquet`` then finds what the store holds. Those of a process that still runs are left alone; so are those
    noted under this process's number unless they are its ``own``, left by an earlier process of that number.
    """
    removed = []
    for noted in sorted(path.glob(f"*-{host_name()}-*.txt")):
        kind, process = noted.stem.partition("-")[0], noted.stem.rpartition("-")[2]
        if kind not in ("adding", "compacting", "replacing") or not process.isdigit():
            continue
        if not own if int(process) == os.getpid() else psutil.pid_exists(int(process)):
            continue
        facts = StoreInfo.load(path)
        named = {stored.file for stored in (*facts.shards, *facts.images)} | {facts.ids, FACTS}
        named |= {facts.ratings.file} if facts.ratings is not None else set()
        with suppress(FileNotFoundError):  # another process clears them, too
            for name in noted.read_text(encoding="utf-8").split():
                if name not in named and (path / name).exists():
                    (path / name).unlink()
                    removed.append(name)
            noted.unlink()
    return removed


@contextmanager
def replacing(path: Path) -> Iterator[None]:
    """Replace ``dataset.json`` by one that names other files of the same content, while nobody adds.

    Each side says what it is about before it looks at the other: those who add note their files and then wait for
    whoever replaces (`await_replaced`); whoever replaces marks it and then gives way to those who add.

    Raises
    ------
    DataError
        If somebody is adding.
    """
    mark = path / f"replacing-{host_name()}-{os.getpid()}.txt"
    mark.touch()
    try:
        if busy := _at_work(path, "adding"):
            raise DataError(
                f"{path}: something is being added to it ({busy}); nothing was changed, repeat it when that is done"
            )
        yield
    finally:
        mark.unlink(missing_ok=True)


def await_replaced(path: Path) -> None:
    """Return when nobody replaces the shards of ``path`` any more.

    Raises
    ------
    DataError
        If that lasts longer than `REPLACED_S`.
    """
    until = time.monotonic() + REPLACED_S
    while mark := _at_work(path, "replacing"):
        if time.monotonic() > until:
            raise DataError(
                f"{path}: its shards are being replaced ({mark}); repeat it, or remove that file if no process is at it"
            )
        time.sleep(0.01)


def _at_work(path: Path, kind: str) -> str | None:
    """Return the note of a process that is, as far as can be seen from here, at work on a store."""
    for noted in sorted(path.glob(f"{kind}-*.txt")):
        host, _, process = noted.stem.removeprefix(f"{kind}-").rpartition("-")
        if host != host_name() or not process.isdigit() or psutil.pid_exists(int(process)):
            return noted.name
    return None


class StagedFiles:
    """The files that one process puts into a store's folder.

    Parameters
    ----------
    folder : Path
        Where they go.
    adding : bool
        Whether ``folder`` is a store already: new files then have names that no other process gives.
    durable : bool
        Whether what is written shall outlast a pulled plug. Into a store, each name is then on the disk before
        its file is begun (`clear_unfinished`).
    purpose : {"adding", "compacting"}
    """

    def __init__(
        self, folder: Path, *, adding: bool, durable: bool = False, purpose: Purpose = "adding"
    ) -> None:
        self.folder, self.adding, self.durable = folder, adding, durable
        self._noted = folder / f"{purpose}-{host_name()}-{os.getpid()}.txt"
        self._written: list[Path] = []

    def parquet(self, kind: str, number: int) -> Path:
        """Return the path of a new Parquet file."""
        # The suffix keeps two processes that add at once, and what a killed one left, apart.
        suffix = f"-{os.urandom(4).hex()}" if self.adding else ""
        path = self.folder / f"{kind}-{number:05d}{suffix}.parquet"
        self.begin(path)
        return path

    def begin(self, *paths: Path) -> None:
        """Take ``paths``, which are written next, for files of this process."""
        self._written += paths
        self.note(*paths)

    def note(self, *paths: Path) -> None:
        """Have ``paths`` removed after a kill, where ``dataset.json`` does not name them by then."""
        if self.adding:
            with self._noted.open("a", encoding="utf-8") as file:
                file.writelines(f"{path.name}\n" for path in paths)
                if self.durable:
                    file.flush()
                    os.fsync(file.fileno())

    def to_disk(self) -> None:
        """Return when all of them, and their folder, are on the disk."""
        to_disk(*(path for path in self._written if path.exists()), self.folder)

    def remove(self) -> None:
        """Remove all of them; a folder that is no store yet goes as well."""
        if not self.adding:
            shutil.rmtree(self.folder, ignore_errors=True)
        for path in self._written:
            path.unlink(missing_ok=True)

    def forget_notes(self) -> None:
        """Remove the list of what was on its way: it has arrived, or was removed."""
        self._noted.unlink(missing_ok=True)


def host_name() -> str:
    """Return this machine's name as it stands in names of files; a process's number is of one machine."""
    return re.sub(r"[^A-Za-z0-9]+", "_", socket.gethostname()) or "host"
