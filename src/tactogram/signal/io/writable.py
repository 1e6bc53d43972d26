"""Write check of a target, made before work whose result would be lost."""

from __future__ import annotations

import tempfile
from pathlib import Path

from tactogram.errors import ParameterError


def check_writable(path: Path, *, folder: bool = False) -> None:
    """Refuse a path that no file can be written to; nothing is left there, and no folder is made.

    Rights alone do not say it (a file system may be read-only, a network share may have its own): a file without a
    name is opened in the nearest folder that there is.

    Parameters
    ----------
    path : Path
        Of a file, which may be there already; its folders need not be.
    folder : bool
        Whether it is that of a folder with files.

    Raises
    ------
    ParameterError
        If it cannot be written, or is a folder where a file is needed, or the other way round.
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
