"""Verbs that render signals for displays and measure displays."""

from __future__ import annotations

from typing import Any

from tactogram.cli.printing import Printer, columns, lines_of, text_of
from tactogram.cli.verbs import Verb
from tactogram.workflows.rendering.requests import (
    DisplayRequest,
    RenderRequest,
    ResponseRequest,
    SweepRequest,
)


def _displays(request: DisplayRequest, show: Printer) -> None:
    from tactogram.workflows.rendering.render import list_displays, show_display

    if request.name is None:
        displays = list_displays()
        rows = [
            (name, d["family"], f"{d['rate']:g} Hz", d["unit"], d["title"]) for name, d in displays.items()
        ]
        show(displays, columns([("name", "family", "rate", "unit", ""), *rows]))
        return
    facts = show_display(request.name, changes=request.changes)
    show(facts, lines_of({name: _shown(value) for name, value in facts.items()}))


def _render(request: RenderRequest, show: Printer) -> None:
    from tactogram.workflows.rendering.render import render

    result = render(**vars(request))
    lines = [result.pop("text"), f"drive: {result['file']}", f"report: {result['report_file']}"]
    lines += [f"figure: {result['figure']}"] if "figure" in result else []
    show(result, "\n".join(lines))


def _sweep(request: SweepRequest, show: Printer) -> None:
    from tactogram.workflows.rendering.render import write_sweep

    show(facts := write_sweep(**vars(request)), lines_of(facts))


def _response(request: ResponseRequest, show: Printer) -> None:
    from tactogram.workflows.rendering.render import write_identified

    show(facts := write_identified(**vars(request)), lines_of(facts))


def _shown(value: Any) -> str:
    """Return a value in one line; of a table of points only their number."""
    if isinstance(value, dict) and value.get("points"):
        return text_of({**value, "points": f"({len(value['points'])} measured)"})
    return text_of(value)


VERBS = {
    "displays": Verb(DisplayRequest, _displays),
    "render": Verb(RenderRequest, _render),
    "sweep": Verb(SweepRequest, _sweep),
    "response": Verb(ResponseRequest, _response),
}
