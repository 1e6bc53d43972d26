"""Verbs that render signals for displays."""

from __future__ import annotations

from typing import Any

from tactogram.cli.printing import columns, lines_of, text_of
from tactogram.cli.verbs import Verb

RENDER = "tactogram.workflows.rendering.render"


def _displays_text(facts: dict[str, Any]) -> str:
    if "levels" in facts:
        return lines_of({name: _shown(value) for name, value in facts.items()})
    rows = [(name, d["family"], f"{d['rate']:g} Hz", d["unit"], d["title"]) for name, d in facts.items()]
    return columns([("name", "family", "rate", "unit", ""), *rows])


def _render_text(result: dict[str, Any]) -> str:
    lines = [result["text"], f"drive: {result['file']}", f"report: {result['report_file']}"]
    return "\n".join([*lines, *([f"figure: {result['figure']}"] if "figure" in result else [])])


def _shown(value: Any) -> str:
    """Return a value in one line; of a table of points only their number."""
    if isinstance(value, dict) and value.get("points"):
        return text_of({**value, "points": f"({len(value['points'])} measured)"})
    return text_of(value)


VERBS = {
    "displays": Verb(f"{RENDER}:describe_displays", _displays_text),
    "render": Verb(f"{RENDER}:render", _render_text),
}
