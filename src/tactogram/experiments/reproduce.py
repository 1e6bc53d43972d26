"""One run of an experiment, by name: its figures, written to a folder."""

from __future__ import annotations

import inspect
import json
from collections.abc import Mapping
from importlib import import_module
from pathlib import Path
from typing import Any

from tactogram.errors import ParameterError
from tactogram.experiments.catalogue import experiments
from tactogram.signal.io.atomic import write_text
from tactogram.signal.io.writable import check_writable
from tactogram.workflows.progress import ProgressCallback, silent


def reproduce(
    name: str,
    *,
    recipe: str = "bench",
    out: Path | str | None = None,
    options: Mapping[str, Any] | None = None,
    package: str = "tactogram.experiments",
    progress: ProgressCallback = silent,
) -> dict[str, Any]:
    """Run the experiment ``name`` and return its result, also written to ``OUT/result.json``.

    Parameters
    ----------
    name : str
        One of `experiments`.
    recipe : {"bench", "paper"}
        ``bench`` is sized for two cores, ``paper`` is the published size.
    out : path, optional
        Folder for everything it makes; by default ``runs/NAME``. Data and finished runs that are there
        already are not made again.
    options : mapping, optional
        What the experiment leaves open, such as ``{"model": "ar_texture"}``: the keyword arguments of its ``run``
        that have a default.
    package : str
        Where the experiments are.
    progress : Progress

    Returns
    -------
    dict
        The experiment's figures, and ``text``: its table, published beside ours.

    Raises
    ------
    ParameterError
        If there is no such experiment or recipe, it does not leave open what ``options`` name, or ``out`` cannot be
        written to.
    """
    known = experiments(Path(import_module(package).__path__[0]))
    if name not in known:
        raise ParameterError(f"experiment must be one of {', '.join(known)}, got {name!r}")
    if recipe not in ("bench", "paper"):
        raise ParameterError(f"recipe must be bench or paper, got {recipe!r}")
    run = import_module(f"{package}.{name}").run
    left_open = [p.name for p in inspect.signature(run).parameters.values() if p.default is not p.empty]
    for key in options or {}:
        if key not in left_open:
            raise ParameterError(
                f"{name} leaves open {', '.join(left_open) or 'nothing'}; there is no option {key!r}"
            )
    folder = Path(out) if out else Path("runs") / name
    check_writable(folder, folder=True)
    folder.mkdir(parents=True, exist_ok=True)
    result: dict[str, Any] = run(folder, paper=recipe == "paper", progress=progress, **(options or {}))
    write_text(folder / "result.json", json.dumps(result, indent=1) + "\n")
    return result
