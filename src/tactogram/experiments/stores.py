"""Data of an experiment: the store that it was given, or a simulated set that is made once."""

from __future__ import annotations

from pathlib import Path
from typing import Any

from tactogram.datasets import Store, open_store
from tactogram.errors import DataError
from tactogram.workflows.data.simulate import simulate_to_store
from tactogram.workflows.progress import ProgressCallback


def find_or_simulate(
    path: Path, set_name: str, *, progress: ProgressCallback, given: str = "", **options: Any
) -> Store:
    """Return the store at ``given``; without, a simulated set, with seed 0, made in ``path`` unless it is there.

    Parameters
    ----------
    path : Path
    set_name : str
        As `tactogram data simulate` takes it.
    progress : Progress
    given : str
        A store; may be empty.
    options
        As `simulate_to_store` takes them.

    Raises
    ------
    DataError
        If ``given`` is no store.
    """
    if given:
        return open_store(given)
    try:
        return open_store(path)
    except DataError:
        simulate_to_store(set_name, path, seed=0, **options, progress=progress)
        return open_store(path)
