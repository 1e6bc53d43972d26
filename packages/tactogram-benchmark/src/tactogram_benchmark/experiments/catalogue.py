"""List of experiments, read from their files without importing them, because that would import torch."""

from __future__ import annotations

import ast
from pathlib import Path
from typing import Any

from tactogram.text_files import read_json

PUBLISHED = Path(__file__).parent
"""Folder of the experiments behind published tables and figures."""
BENCHMARKS = Path(__file__).parents[5] / "benchmarks"
"""Our own experiments and committed results, next to the source; missing from an installed package."""


def experiments(folder: Path = PUBLISHED) -> dict[str, str]:
    """Return name and title of each experiment in a folder: its modules that define ``run``, in alphabetical order."""
    found = {}
    for file in sorted(folder.glob("*.py")):
        module = ast.parse(file.read_text(encoding="utf-8"))
        if any(isinstance(node, ast.FunctionDef) and node.name == "run" for node in module.body):
            found[file.stem] = (ast.get_docstring(module) or "").split("\n", 1)[0]
    return found


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
        one["name"] + " (simulated)" * (one["simulated"] and "simulated" not in one["name"])
        for one in header.get("data", ())
    )
