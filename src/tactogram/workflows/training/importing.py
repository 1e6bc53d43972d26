"""Runs from elsewhere: packed in a file, in a folder of the Hub's layout, or on the Hub."""

from __future__ import annotations

import tempfile
from pathlib import Path
from typing import Any

from tactogram.workflows.hub import PREFIX, pull
from tactogram.workflows.training.hub_folder import import_hub
from tactogram.workflows.training.run_archive import import_run


def import_from(source: Path | str, out: Path | str) -> dict[str, Any]:
    """Put a run from ``source`` into the folder ``out``; return ``run`` and ``files``.

    Raises
    ------
    RunError
        If it is no run, cannot be had, or ``out`` exists.
    """
    if str(source).startswith(PREFIX):
        with tempfile.TemporaryDirectory(prefix="tactogram-hub-") as folder:
            pull(str(source).removeprefix(PREFIX), Path(folder), kind="model")
            return import_hub(folder, out)
    return import_hub(source, out) if Path(source).is_dir() else import_run(source, out)
