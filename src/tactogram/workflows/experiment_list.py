"""Which experiments there are, known without importing any: they bring in torch."""

from __future__ import annotations

import ast
from pathlib import Path

from tactogram import experiments as package


def experiments() -> dict[str, str]:
    """Return each experiment's name and the first line of what it is, without importing any."""
    found = {}
    for file in sorted(Path(package.__path__[0]).glob("*.py")):
        if not file.stem.startswith("_"):
            text = ast.get_docstring(ast.parse(file.read_text(encoding="utf-8"))) or ""
            found[file.stem] = text.split("\n", 1)[0]
    return found
