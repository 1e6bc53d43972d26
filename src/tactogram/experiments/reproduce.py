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
        Folder of its artifacts; default ``runs/NAME``. Data and finished runs in it are used again.
    options : mapping, optional
        Keyword arguments of the experiment's ``run``, such as ``{"model": "ar_texture"}``.
    package : str
        Package of the experiments.

    Returns
    -------
    dict
        The experiment's figures, and ``text``: its table, with published figures beside ours.

    Raises
    ------
    ParameterError
        If the experiment, recipe or an option does not exist, or ``out`` cannot be written to.
    """
    known = experiments(Path(import_module(package).__path__[0]))
    if name not in known:
        raise ParameterError(f"experiment must be one of {', '.join(known)}, got {name!r}")
    if recipe not in ("bench", "paper"):
        raise ParameterError(f"recipe must be bench or paper, got {recipe!r}")
    run = import_module(f"{package}.{name}").run
    available = [p.name for p in inspect.signature(run).parameters.values() if p.default is not p.empty]
    for key in options or {}:
        if key not in available:
            raise ParameterError(
                f"option of {name} must be one of {', '.join(available) or 'none'}, got {key!r}"
            )
    folder = Path(out) if out else Path("runs") / name
    check_writable(folder, folder=True)
    folder.mkdir(parents=True, exist_ok=True)
    result: dict[str, Any] = run(folder, paper=recipe == "paper", progress=progress, **(options or {}))
    write_text(folder / "result.json", json.dumps(result, indent=1) + "\n")
    return result
