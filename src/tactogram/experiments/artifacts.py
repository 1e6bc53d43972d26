"""Artifacts of an experiment, made once in its folder and read again: data, runs and results."""

from __future__ import annotations

import json
from collections.abc import Callable, Mapping
from pathlib import Path
from typing import Any

from tactogram.datasets import Store, open_store
from tactogram.errors import DataError
from tactogram.signal.io.atomic import write_text
from tactogram.workflows.data.simulate import simulate_to_store
from tactogram.workflows.progress import ProgressCallback
from tactogram.workflows.training.train import train


def find_or_simulate(
    path: Path, set_name: str, *, progress: ProgressCallback, given: str = "", seed: int = 0, **options: Any
) -> Store:
    """Return the store at ``given``, otherwise the one in ``path``, simulated with ``seed`` if there is none yet.

    ``options`` are those of `simulate_to_store`.

    Raises
    ------
    DataError
        If ``given`` is not a store.
    """
    if given:
        return open_store(given)
    try:
        return open_store(path)
    except DataError:
        simulate_to_store(set_name, path, seed=seed, **options, progress=progress)
        return open_store(path)


def trained_run(model: str, store: Store, run: Path, *, progress: ProgressCallback, **options: Any) -> Path:
    """Return ``run`` after training it, or continuing it if it exists; ``options`` are those of `train`."""
    train(model, store.path, out=run, resume=(run / "recipe.toml").exists(), progress=progress, **options)
    return run


def cached_result(
    file: Path, facts: Mapping[str, Any], compute: Callable[[], Mapping[str, Any]]
) -> dict[str, Any]:
    """Return the result in ``file`` if it has the same ``facts``, otherwise compute and write it."""
    if file.is_file():
        found: dict[str, Any] = json.loads(file.read_text(encoding="utf-8"))
        if found["asked"] == facts:
            return found
    found = {"asked": dict(facts), **compute()}
    file.parent.mkdir(parents=True, exist_ok=True)
    write_text(file, json.dumps(found, indent=1) + "\n")
    return found


def kind_of(store: Store) -> str:
    """Return the name of the store's signals in a table."""
    return "simulated strokes" if store.simulated else f"recorded strokes ({store.name})"
