"""Write check of a target, made before work whose result would be lost."""

from __future__ import annotations

import tempfile
from pathlib import Path

from tactogram.errors import ParameterError


def check_writable(path: Path, *, folder: bool = False) -> None:
    """Raise a `ParameterError` if a file, or with ``folder`` a folder of files, cannot be written to a path.

    Permissions are not sufficient (a file system may be read-only, a network share may have its own), so an unnamed
    file is opened in the nearest existing folder; nothing is left there, and no folder is made.
    """
    try:
        if folder and path.exists() and not path.is_dir():
            raise ParameterError(f"{path}: is a file; a folder is needed here: give another name")
        if not folder and path.is_dir():
            raise ParameterError(f"{path}: is a folder; a file is needed here: give another name")
        whole = path.absolute()
        there = next(at for at in ((whole, *whole.parents) if folder else whole.parents) if at.exists())
        with tempfile.TemporaryFile(dir=there):
            pass
    except OSError as error:
        raise ParameterError(f"{path}: cannot be written ({error.strerror}); give another place") from error
