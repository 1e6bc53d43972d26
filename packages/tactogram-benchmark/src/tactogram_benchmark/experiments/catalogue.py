"""Experiments: listed from their files without importing them, because that would import torch, and run by name."""

from __future__ import annotations

import ast
import inspect
import json
import os
from collections.abc import Mapping, Sequence
from datetime import UTC, datetime
from importlib import import_module
from importlib.metadata import version
from pathlib import Path
from typing import TYPE_CHECKING, Any, Literal

from tactogram.errors import ParameterError, Remedy
from tactogram.parameters import Count, Settings, checked
from tactogram.text_files import read_json

if TYPE_CHECKING:
    from tactogram.workflows import ProgressCallback


PUBLISHED = Path(__file__).parent
"""Folder of the experiments behind published tables and figures."""
BENCHMARKS = Path(__file__).parents[5] / "benchmarks"
"""Our own experiments and committed results, next to the source; missing from an installed package."""


def experiments(folder: Path = PUBLISHED) -> dict[str, str]:
    """Return name and title of each experiment in a folder: its modules that define ``run``, in alphabetical order."""
    titles = {}
    for file in sorted(folder.glob("*.py")):
        module = ast.parse(file.read_text(encoding="utf-8"))
        if any(isinstance(node, ast.FunctionDef) and node.name == "run" for node in module.body):
            titles[file.stem] = (ast.get_docstring(module) or "").split("\n", 1)[0]
    return titles


def result_files(name: str, runs: Path = Path("runs")) -> tuple[Path, ...]:
    """Return the results of an experiment: those committed, by recipe and data, and that in the folder ``runs``."""
    folder = BENCHMARKS / "reproduced"
    committed = (*folder.glob(f"{name}.json"), *sorted(folder.glob(f"{name}_*.json")))
    own = runs / name / "result.json"
    return (*committed, *([own] if own.is_file() else []))


def header_of(file: Path) -> dict[str, Any]:
    """Return the header that `reproduce` wrote into a result, empty if there is none.

    Raises `DataError` if the file is not JSON.
    """
    values = read_json(file)
    return dict(values.get("header") or {}) if isinstance(values, dict) else {}


def data_text(header: dict[str, Any]) -> str:
    """Return the names of the data in a header, simulated data marked as such; "" where it states none."""
    return ", ".join(
        store["name"] + " (simulated)" * (store["simulated"] and "simulated" not in store["name"])
        for store in header.get("data", ())
    )


@checked
def reproduce(
    name: str,
    *,
    data: Path | str = "",
    recipe: Literal["bench", "paper"] = "bench",
    options: Settings | None = None,
    out: Path | str | None = None,
    on: str = "",
    processes: Count | None = None,
    package: str = "tactogram_benchmark.experiments",
    progress: ProgressCallback | None = None,
) -> dict[str, Any]:
    """Run the experiment behind a published table or figure.

    The result is also written to ``OUT/result.json``; ``package`` is that of the experiments.

    Parameters
    ----------
    name : str
        One of the experiments that --list lists.
    data : Path or str
        Store to run it on (default: usually simulated data of the published layout).
    recipe : {"bench", "paper"}
        bench is sized for two cores (hours at most), paper is the published size.
    options : dict, optional
        Option of the experiment, as KEY=VALUE, e.g. model=ar_texture.
    out : Path or str, optional
        Folder for its results (default runs/EXPERIMENT); results of an interrupted or smaller run are reused.
    on : str
        Engine: ray starts Ray on this machine, ray:ADDRESS takes a cluster.
    processes : int, optional
        Processes for independent trainings, each on one thread (default: one after the other, on all cores).

    Returns
    -------
    dict
        The experiment's figures; ``text``: its table, with published figures beside ours; and ``header``:
        ``experiment``, ``recipe``, ``options`` (those given), ``data`` (of each store ``name``, ``sha256`` and
        ``simulated``), ``finished`` (UTC) and ``version``. Paths are relative to ``out``.

    Raises
    ------
    ParameterError
        If the experiment or an option does not exist, or ``out`` cannot be written to.
    """
    from tactogram.signal.io import check_writable, write_text
    from tactogram.workflows import silent

    known = experiments(Path(import_module(package).__path__[0]))
    if name not in known:
        raise ParameterError.one_of("experiment", known, name)
    run = import_module(f"{package}.{name}").run
    available = [p.name for p in inspect.signature(run).parameters.values() if p.default is not p.empty]
    if data and "data" not in available:
        remedy = f"it takes only {', '.join(available) or 'none'}"
        raise ParameterError.must("data", f"be omitted for {name}", data, remedy=remedy)
    for key in options or {}:
        if key not in available:
            raise ParameterError.one_of(f"option of {name}", available or ["none"], key)
    workers: dict[str, Any] = {"on": on} if on else {}
    workers |= {} if processes is None else {"processes": processes}
    if workers and "on" not in available:
        problem = f"{name} has no independent trainings for workers"
        raise ParameterError(problem, remedy=Remedy("omit", "on" if on else "processes"))
    folder = Path(out) if out else Path("runs") / name
    check_writable(folder, folder=True)
    folder.mkdir(parents=True, exist_ok=True)
    arguments = dict(options or {}) | ({"data": str(data)} if data else {})
    result: dict[str, Any] = run(
        folder, paper=recipe == "paper", progress=progress or silent, **arguments, **workers
    )
    header = {
        "experiment": name,
        "recipe": recipe,
        "options": {key: value for key, value in arguments.items() if key != "data"},
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


@checked
def published_figures(
    runs: Sequence[Path | str] = (), *, model: str = "", data: str = "", figure: str = ""
) -> dict[str, Any]:
    """Show every model's published results and ours, and the figures of evaluated runs.

    Parameters
    ----------
    runs : sequence of Path or str
        Evaluated runs whose figures are listed first.
    model : str
        Only rows of models whose name contains this.
    data : str
        Only rows of data that contains this.
    figure : str
        Only rows of figures that contain this, e.g. distance.

    Returns
    -------
    dict
        ``rows``, as of `tactogram.workflows.table`.

    Raises
    ------
    ParameterError
        If no row contains all of that.
    """
    from tactogram.workflows import table

    chosen = {"model": model, "data": data, "what": figure}
    rows = [
        row
        for row in table(runs=runs)
        if all(text.casefold() in row[name].casefold() for name, text in chosen.items())
    ]
    if not rows:
        raise ParameterError("no row contains all of that; `tactogram table` lists every row")
    return {"rows": rows}
