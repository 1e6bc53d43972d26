"""The data that an experiment is on: what it was given, or a simulated set that is made once."""

from __future__ import annotations

from pathlib import Path
from typing import Any

from tactogram.datasets import Store, open_store
from tactogram.errors import DataError
from tactogram.experiments._jobs import Jobs


def given_or_simulated(jobs: Jobs, path: Path, set_name: str, *, given: str = "", **options: Any) -> Store:
    """Return the store at ``given``; without, a simulated set, with seed 0, made in ``path`` unless it is there.

    Parameters
    ----------
    jobs : Jobs
    path : Path
    set_name : str
        As `tactogram data simulate` takes it.
    given : str
        A store; may be empty.
    options
        As ``jobs.simulate`` takes them.

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
        jobs.simulate(set_name, path, seed=0, **options)
        return open_store(path)
