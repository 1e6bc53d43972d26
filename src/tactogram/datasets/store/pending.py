"""Pending files of a store, named and noted so that those of a killed process are found and removed."""

from __future__ import annotations

import os
import shutil
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from pathlib import Path

from tactogram.datasets.store.layout import FACTS, StoreInfo
from tactogram.errors import DataError, Remedy, RunError
from tactogram.signal.io.atomic import clear_parts, host_name, is_running, sole_writer, to_disk


def part_folder(path: Path) -> Path:
    """Return the folder beside ``path`` in which this process prepares it."""
    return path.with_name(f"{path.name}.part-{host_name()}-{os.getpid()}")


def adopt_part(path: Path, job: str) -> StoreInfo | None:
    """Take over the part folder in which an ended process of this machine began ``job`` for ``path``.

    It becomes this process's own, with only the files of its last checkpoint, whose content is returned; None if there
    is no such folder.
    """
    own = part_folder(path)
    for part in sorted(path.parent.glob(f"{path.name}.part-{host_name()}-*")):
        process = part.name.rpartition("-")[2]
        if part != own and not (process.isdigit() and not is_running(int(process))):
            continue
        try:
            facts = StoreInfo.load(part)
        except DataError:
            continue
        if facts.unfinished is None or facts.unfinished.job != job:
            continue
        with suppress(OSError):  # another process may take it over, too
            part.rename(own)
            named = {file.file for file in facts.files} | {facts.ids, FACTS}
            for file in own.iterdir():
                if file.name not in named:
                    file.unlink()
            return facts
    return None


def clear_stale_parts(path: Path) -> list[Path]:
    """Remove part folders of ``path`` whose process has ended; return those of unknown state."""
    left = []
    for part in sorted(path.parent.glob(f"{path.name}.part-*")):
        host, _, process = part.name.removeprefix(f"{path.name}.part-").rpartition("-")
        if host == host_name() and process.isdigit() and not is_running(int(process)):
            shutil.rmtree(part, ignore_errors=True)
        elif not (host == host_name() and process == str(os.getpid())):
            left.append(part)
    return left


def clear_unfinished(path: Path, *, own: bool = True) -> list[str]:
    """Remove pending files of killed processes from the store ``path``, and return their names.

    Only files that were noted before they were written and that ``dataset.json`` does not name are removed, so that all
    ``shard-*.parquet`` are again the store's content. Files of running processes stay; so do those noted under this
    process's number unless they are its ``own``, left by an earlier process of that number.
    """
    clear_parts(path)
    removed = []
    for noted in sorted(path.glob(f"adding-{host_name()}-*.txt")):
        process = noted.stem.rpartition("-")[2]
        if not process.isdigit():
            continue
        if not own if int(process) == os.getpid() else is_running(int(process)):
            continue
        facts = StoreInfo.load(path)
        named = {stored.file for stored in facts.files} | {facts.ids, FACTS}
        with suppress(FileNotFoundError):  # another process may clear them, too
            for name in noted.read_text(encoding="utf-8").split():
                if name not in named and (path / name).exists():
                    (path / name).unlink()
                    removed.append(name)
            noted.unlink()
    return removed


@contextmanager
def new_folder(target: Path) -> Iterator[Path]:
    """Yield a private folder beside ``target``, which becomes ``target`` unless the block raises.

    Raises `RunError` if ``target`` exists.
    """
    part = part_folder(target)
    with sole_writer(target):
        if target.exists():
            raise RunError(target, "exists already", remedy=Remedy("choose another", "out"))
        clear_stale_parts(target)
        shutil.rmtree(part, ignore_errors=True)  # of a killed process with the same number
        part.mkdir(0o700, parents=True)
        try:
            yield part
            part.chmod(0o755)
            part.rename(target)
        finally:
            shutil.rmtree(part, ignore_errors=True)


class StagedFiles:
    """Files that one process writes into a store's folder.

    A folder that is already a store (``adding``) gets unique names, which are noted. With ``durable`` the files survive
    a power cut: each name is then on the disk before its file is begun (`clear_unfinished`).
    """

    def __init__(self, folder: Path, *, adding: bool, durable: bool = False) -> None:
        self.folder, self.adding, self.durable = folder, adding, durable
        self._noted = folder / f"adding-{host_name()}-{os.getpid()}.txt"
        self._written: list[Path] = []

    def parquet(self, kind: str, number: int) -> Path:
        """Return the path of a new Parquet file."""
        # The suffix keeps apart processes that add at the same time, and leftovers.
        suffix = f"-{os.urandom(4).hex()}" if self.adding else ""
        path = self.folder / f"{kind}-{number:05d}{suffix}.parquet"
        self.begin(path)
        return path

    def begin(self, *paths: Path) -> None:
        """Register ``paths``, which are written next, as files of this process."""
        self._written += paths
        self.note(*paths)

    def note(self, *paths: Path) -> None:
        """Note ``paths`` for removal after a kill, unless ``dataset.json`` then names them."""
        if self.adding:
            with self._noted.open("a", encoding="utf-8") as file:
                file.writelines(f"{path.name}\n" for path in paths)
                if self.durable:
                    file.flush()
                    os.fsync(file.fileno())

    def to_disk(self) -> None:
        """Synchronise all files and their folder to the disk, if they are to survive a power cut."""
        to_disk(*(path for path in (*self._written, self.folder) if self.durable and path.exists()))

    def remove(self, *, but: str) -> None:
        """Remove all files ``but`` the current list of ids, and the folder if it is not a store yet."""
        if not self.adding:
            shutil.rmtree(self.folder, ignore_errors=True)
        for path in self._written:
            if path.name != but:
                path.unlink(missing_ok=True)

    def forget_notes(self) -> None:
        """Remove the list of pending files once they are complete or removed."""
        self._noted.unlink(missing_ok=True)
