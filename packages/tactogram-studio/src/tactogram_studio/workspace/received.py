"""Folders of recordings that a browser sent, as files or as a zip: kept in the workspace until they are removed.

Paths are checked and sizes counted while the files are written; a folder that is refused leaves nothing behind. All lie
in a hidden folder: what somebody sent is never taken for a run, a store or a session of the workspace.
"""

from __future__ import annotations

import re
import stat
import unicodedata
import zipfile
from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from pathlib import Path, PurePosixPath
from typing import IO

from tactogram.errors import DataError, one_line
from tactogram.signal.io import READABLE, UnpackedSizeError, check_archive
from tactogram_studio.workspace.folder import DatedFolders, Workspace
from tactogram_studio.workspace.uploads import LONGEST_NAME, MIB, RESERVED, check_unpacked_size, most_bytes_of

FOLDER = ".received"
MOST_FILES = 5000
MOST_SENT = 512 * MIB
"""Bytes of a request: of all files, or of a zip."""
MOST_UNPACKED = 1024 * MIB
MOST_PARTS = 12
"""Folders in a path, and its file."""
REMEDY = "put the folder into the workspace, and choose it there"
_SYSTEM = re.compile(r"\..*|__MACOSX|Thumbs\.db|desktop\.ini", re.IGNORECASE)
"""Files and folders that operating systems add."""
_CHUNK = MIB


@dataclass(frozen=True)
class ReceivedFolders:
    """Received folders of a workspace."""

    workspace: Workspace

    @property
    def _folders(self) -> DatedFolders:
        return DatedFolders(self.workspace.studio_folder / FOLDER)

    def keep(self, files: Sequence[tuple[str, IO[bytes]]]) -> Path:
        """Write files, given with their paths; a single zip is unpacked. Return the folder of their materials.

        Raises `DataError` if a path leaves the folder, two files have the same one, something is too large, or a zip is
        damaged.
        """
        if len(files) == 1 and files[0][0].lower().endswith(".zip"):
            [(name, file)] = files
            return self._keep_zip(PurePosixPath(name.replace("\\", "/")).name, file)
        return self._write(files, "recordings")

    def all(self) -> list[Path]:
        """Return the folders, newest first."""
        folders = [self._folders.folder / name for name in self._folders.names()]
        return [path for folder in folders for path in folder.iterdir() if path.is_dir()]

    def contains(self, path: Path) -> bool:
        """Return whether a folder is one of them."""
        return path.parent.parent == self._folders.folder and self._folders.find(path.parent.name) is not None

    def remove(self, path: Path) -> None:
        """Delete one of them."""
        if not self.contains(path):
            raise DataError(path.name, "is not a received folder")
        self._folders.remove(path.parent.name)

    def _keep_zip(self, name: str, file: IO[bytes]) -> Path:
        check_archive(file, name, most_bytes=MOST_UNPACKED, most_members=4 * MOST_FILES)
        try:
            with zipfile.ZipFile(file) as archive:
                members = [member for member in archive.infolist() if _is_file(member)]
                if any(member.flag_bits & 1 for member in members):
                    raise DataError(name, "is encrypted; save it without a password")
                opened = ((member.filename, archive.open(member)) for member in members)
                paths = [member.filename for member in members]
                return self._write(opened, name.rpartition(".")[0], paths)
        except (
            zipfile.BadZipFile,
            zipfile.LargeZipFile,
            NotImplementedError,
            EOFError,
            RuntimeError,
        ) as error:
            raise DataError(name, f"damaged: {one_line(error)}; make it again") from None

    def _write(
        self, files: Iterable[tuple[str, IO[bytes]]], name: str, paths: Sequence[str] | None = None
    ) -> Path:
        if paths is None:
            files = list(files)
            paths = [path for path, _ in files]
        name, places = _places(paths, name)

        def write(part: Path) -> None:
            total = 0
            for path, file in files:
                if (parts := places[path]) is not None:
                    target = part.joinpath(name, *parts)
                    target.parent.mkdir(parents=True, exist_ok=True)
                    total += _copy(file, target, path, MOST_UNPACKED - total)

        return self._folders.folder / self._folders.add(write) / name


def safe_path(path: str) -> tuple[str, ...] | None:
    """Return the parts of a path in names that every system accepts; None for files that operating systems add.

    A `DataError` if it is absolute or leads out of the folder.
    """
    parts = re.split(r"[/\\]", unicodedata.normalize("NFC", path))
    if ".." in parts or not parts[0] or re.match(r"[A-Za-z]:", path):
        raise DataError(f"{path[:200]}: leads out of the folder; make the zip again, of the folder alone")
    if any(_SYSTEM.fullmatch(part) for part in parts):
        return None
    safe = tuple(_safe_part(part) for part in parts if part)
    if len(safe) > MOST_PARTS:
        raise DataError(f"{path[:200]}: must have at most {MOST_PARTS - 1} folders, got {len(safe) - 1}")
    return safe


def _safe_part(part: str) -> str:
    text = re.sub(r'[\x00-\x1f\x7f<>:"|?*]', "_", part).encode("utf-8", "replace").decode()
    stem, dot, suffix = text.strip().rpartition(".")
    if not dot:
        stem, suffix = suffix, ""
    stem = stem.encode()[:LONGEST_NAME].decode("utf-8", "ignore").rstrip(". ")
    stem = f"_{stem}" if stem.lower() in RESERVED or not stem else stem
    return stem + dot + suffix[:20].rstrip(". ") if suffix else stem


def _places(paths: Sequence[str], name: str) -> tuple[str, dict[str, tuple[str, ...] | None]]:
    """Return the name of the folder, and the place of each file in it; None for files to leave out.

    A folder around all others is the folder itself; one that holds files alone is a material.
    """
    places = {path: safe_path(path) for path in paths}
    kept = [parts for parts in places.values() if parts]
    if not kept:
        raise DataError(name, "no files; choose a folder with a folder for each material")
    if len(kept) > MOST_FILES:
        raise DataError(name, f"must have at most {MOST_FILES} files, got {len(kept)}", remedy=REMEDY)
    if len({parts[0] for parts in kept}) == 1 and max(map(len, kept)) > 2:
        name = kept[0][0]
        places = {path: parts[1:] if parts else None for path, parts in places.items()}
    seen: dict[str, str] = {}
    for path, parts in places.items():
        other = seen.setdefault("/".join(parts).lower(), path) if parts else path
        if other != path:
            raise DataError(f"{path[:200]}: the same name as {other[:200]}; rename one of them")
    if len(set(paths)) < len(paths):
        raise DataError(name, "two files have the same name; rename one of them")
    return _safe_part(name), places


def _copy(file: IO[bytes], target: Path, path: str, room: int) -> int:
    """Write a file within the limits of its kind and of the folder; return its size."""
    suffix = target.suffix.lower()
    most = min(room, most_bytes_of(suffix)) if target.name.lower().endswith(READABLE) else room
    size = 0
    with file, target.open("xb") as out:
        while chunk := file.read(_CHUNK):
            size += len(chunk)
            if size > most:
                whole = f"all files together must have at most {MOST_UNPACKED // MIB} MiB"
                each_file = f"must have at most {most_bytes_of(suffix) // MIB} MiB"
                raise DataError(path[:200], whole if most == room else each_file, remedy=REMEDY)
            out.write(chunk)
    if target.name.lower().endswith(READABLE):
        try:
            check_unpacked_size(target)
        except UnpackedSizeError as error:
            raise DataError(path[:200], error.message.problem, remedy=REMEDY) from None
    return size


def _is_file(member: zipfile.ZipInfo) -> bool:
    return not member.is_dir() and not stat.S_ISLNK(member.external_attr >> 16)
