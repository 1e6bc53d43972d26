"""Fields of the parameters of a verb, as its signature and its docstring declare them."""

from __future__ import annotations

import re
from collections.abc import Iterable, Mapping, Sequence
from typing import Any

from nicegui import ui

from tactogram.cli.verbs import converted
from tactogram.parameters import Parameter

NUMBERS = ("int", "float", "Count", "Positive", "Share")
"""Annotations of numbers."""


class ParameterFields:
    """A field for each of the parameters ``names`` of a verb, in this order; empty ones are left out.

    ``labels`` and ``examples`` are by name; a label is by default the name, and what the verb says of the
    parameter is the field's tooltip. ``entries`` are what the fields begin with.
    """

    def __init__(
        self,
        parameters: Iterable[Parameter],
        names: Sequence[str],
        *,
        labels: Mapping[str, str] | None = None,
        examples: Mapping[str, str] | None = None,
        entries: Mapping[str, str] | None = None,
        classes: str = "w-36",
    ) -> None:
        known = {one.name: one for one in parameters}
        self._fields: dict[str, tuple[Parameter, ui.input]] = {}
        for name in names:
            label = (labels or {}).get(name) or name.replace("_", " ").capitalize()
            entry, example = (entries or {}).get(name, ""), (examples or {}).get(name, "")
            field = ui.input(label, value=entry, placeholder=example).props("dense").classes(classes)
            field.props('inputmode="decimal"' if known[name].annotation in NUMBERS else "")
            self._fields[name] = known[name], field.tooltip(known[name].text)

    def values(self) -> dict[str, Any]:
        """Return the checked values by name; `ParameterError` names the first field that is not one."""
        return {
            name: value_of(one, text, label=str(field.props["label"]))
            for name, (one, field) in self._fields.items()
            if (text := (field.value or "").strip())
        }

    def entries(self) -> dict[str, str]:
        """Return what was entered, by name."""
        return {name: field.value or "" for name, (_, field) in self._fields.items()}


def value_of(parameter: Parameter, entry: Any, *, label: str = "") -> Any:
    """Return an entry as a value of a parameter: of a text the list or the pairs that commas separate."""
    if parameter.annotation.startswith("Mapping"):
        entry = [re.sub(r"\s*=\s*", "=", part.strip()) for part in entry.split(",") if part.strip()]
    return parameter.check(converted(label or parameter.name, entry, parameter.kind))
