"""One run of an experiment, by name: its figures, written to a folder."""

from __future__ import annotations

import inspect
import json
import os
from collections.abc import Mapping
from datetime import UTC, datetime
from importlib import import_module
from importlib.metadata import version
from pathlib import Path
from typing import Any

from tactogram.errors import ParameterError
from tactogram.signal.io import check_writable, write_text
from tactogram.workflows import ProgressCallback, silent
from tactogram_benchmark.experiments.catalogue import experiments


def reproduce(
    name: str,
    *,
    data: str = "",
    recipe: str = "bench",
    out: Path | str | None = None,
    options: Mapping[str, Any] | None = None,
    on: str = "",
    processes: int | None = None,
    package: str = "tactogram_benchmark.experiments",
    progress: ProgressCallback = silent,
) -> dict[str, Any]:
    """Run the experiment ``name`` and return its result, also written to ``OUT/result.json``.

    Raises `ParameterError` if the experiment, recipe or an option does not exist, or ``out`` cannot be written to.

    Parameters
    ----------
    name : str
        One of `experiments`.
    data : str
        Store to run it on, its option ``data``; default: usually simulated data of the published layout.
    recipe : {"bench", "paper"}
        ``bench`` is sized for two cores, ``paper`` is the published size.
    out : path, optional
        Folder of its artifacts; default ``runs/NAME``. Data and finished runs in it are used again.
    options : mapping, optional
        Keyword arguments of the experiment's ``run``, such as ``{"model": "ar_texture"}``.
    on : str
        ``ray`` or ``ray:ADDRESS``: where the experiment's independent trainings run, see `run_tasks`.
    processes : int, optional
        Of this machine, for these trainings, each on one thread; by default one training after the other, on all cores.
    package : str
        Package of the experiments.

    Returns
    -------
    dict
        The experiment's figures; ``text``: its table, with published figures beside ours; and ``header``:
        ``experiment``, ``recipe``, ``options`` (those given), ``data`` (of each store ``name``, ``sha256`` and
        ``simulated``), ``finished`` (UTC) and ``version``. Paths are relative to ``out``.
    """
    known = experiments(Path(import_module(package).__path__[0]))
    if name not in known:
        raise ParameterError(f"experiment must be one of {', '.join(known)}, got {name!r}")
    if recipe not in ("bench", "paper"):
        raise ParameterError(f"recipe must be bench or paper, got {recipe!r}")
    run = import_module(f"{package}.{name}").run
    available = [p.name for p in inspect.signature(run).parameters.values() if p.default is not p.empty]
    if data and "data" not in available:
        raise ParameterError(
            f"{name} takes no `data`; its options: {', '.join(available) or 'none'}, got {data!r}"
        )
    for key in options or {}:
        if key not in available:
            raise ParameterError(
                f"option of {name} must be one of {', '.join(available) or 'none'}, got {key!r}"
            )
    workers: dict[str, Any] = {"on": on} if on else {}
    workers |= {} if processes is None else {"processes": processes}
    if workers and "on" not in available:
        raise ParameterError(f"{name} has no independent trainings for workers: omit `on` and `processes`")
    folder = Path(out) if out else Path("runs") / name
    check_writable(folder, folder=True)
    folder.mkdir(parents=True, exist_ok=True)
    given = dict(options or {}) | ({"data": data} if data else {})
    result: dict[str, Any] = run(folder, paper=recipe == "paper", progress=progress, **given, **workers)
    header = {
        "experiment": name,
        "recipe": recipe,
        "options": {key: value for key, value in given.items() if key != "data"},
        "data": _data_of(result),
        "finished": datetime.now(UTC).isoformat(timespec="seconds"),
        "version": version("tactogram"),
    }
    result = {"header": header, **_relative(result, f"{folder}{os.sep}")}
    write_text(folder / "result.json", json.dumps(result, indent=1) + "\n")
    return result


def _relative(value: Any, folder: str) -> Any:
    """Return a result with its paths relative to its folder, so that it does not depend on the machine."""
    if isinstance(value, Mapping):
        return {key: _relative(inner, folder) for key, inner in value.items()}
    if isinstance(value, list | tuple):
        return [_relative(inner, folder) for inner in value]
    return value.removeprefix(folder) if isinstance(value, str) else value


def _data_of(result: Mapping[str, Any]) -> list[dict[str, Any]]:
    """Return name, hash and origin of each store in a result (see `tactogram_benchmark.experiments`)."""
    stores = [
        value
        for value in result.values()
        if isinstance(value, Mapping) and {"name", "sha256"} <= value.keys()
    ]
    if "data_sha256" in result:
        stores.append({"name": result["data"], "sha256": result["data_sha256"]})
    return [
        {"name": one["name"], "sha256": one["sha256"], "simulated": one.get("simulated", result["simulated"])}
        for one in stores
    ]
