"""List of experiments, read from their files without importing them, because that would import torch."""

from __future__ import annotations

import ast
from pathlib import Path

PUBLISHED = Path(__file__).parent
"""Folder of the experiments behind published tables and figures."""


def experiments(folder: Path = PUBLISHED) -> dict[str, str]:
    """Return name and title of each experiment in a folder: its modules that define ``run``, in alphabetical order."""
    found = {}
    for file in sorted(folder.glob("*.py")):
        module = ast.parse(file.read_text(encoding="utf-8"))
        if any(isinstance(node, ast.FunctionDef) and node.name == "run" for node in module.body):
            found[file.stem] = (ast.get_docstring(module) or "").split("\n", 1)[0]
    return found
