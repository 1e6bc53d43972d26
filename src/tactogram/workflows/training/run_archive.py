"""Runs packed into one file."""

from __future__ import annotations

import zipfile
import zlib
from pathlib import Path, PurePosixPath
from typing import Any

from tactogram.datasets.store.pending import new_folder
from tactogram.errors import RunError
from tactogram.signal.io.atomic import atomic_write
from tactogram.training.run import Run, open_run

LEFT_OUT = {"checkpoint.safetensors"}
LARGEST_BYTES = 8 * 2**30
"""Largest size of an unpacked run: a larger one is refused before it is unpacked."""


def export_run(run: Path | str, out: Path | str) -> dict[str, Any]:
    """Pack the finished run in ``run`` into the zip file ``out``; return ``file``, ``files`` and ``bytes``."""
    found, target = open_run(run), Path(out)
    found.facts()
    files = [
        f
        for f in sorted(found.folder.rglob("*"))
        if f.is_file() and f.name not in LEFT_OUT and not f.name.startswith(".")
    ]
    with atomic_write(target) as part, zipfile.ZipFile(part, "w", zipfile.ZIP_DEFLATED) as packed:
        for file in files:
            packed.write(file, file.relative_to(found.folder).as_posix())
    return {"file": str(target), "files": len(files), "bytes": target.stat().st_size}


def import_run(file: Path | str, out: Path | str) -> dict[str, Any]:
    """Unpack the run in the zip file ``file`` into the folder ``out``; return ``run`` and ``files``.

    Raises
    ------
    RunError
        If the file is not a packed run, names a path outside it, or ``out`` exists.
    """
    try:
        with new_folder(Path(out)) as part:
            with zipfile.ZipFile(file) as packed:
                for member in packed.infolist():
                    place = PurePosixPath(member.filename)
                    if place.is_absolute() or ".." in place.parts or "\\" in member.filename:
                        raise RunError(f"{file}: names a path outside the run: {member.filename!r}")
                if sum(member.file_size for member in packed.infolist()) > LARGEST_BYTES:
                    raise RunError(f"{file}: would unpack to more than {LARGEST_BYTES >> 30} GiB")
                packed.extractall(part)
                count = len(packed.infolist())
            check_foreign(Run.open(part))
    except (OSError, zipfile.BadZipFile, zlib.error, RuntimeError, NotImplementedError, EOFError) as error:
        raise RunError(f"{file}: not a packed run: {error}") from error
    return {"run": str(out), "files": count}


def check_foreign(run: Run) -> None:
    """Refuse an unfinished run from elsewhere, and forget the folders of models on another machine."""
    run.facts()
    # Code is never loaded from a path in a file.
    data = {key: value for key, value in run.data.items() if key != "model_folders"}
    if data != run.data:
        run.write_json("data.json", data)
