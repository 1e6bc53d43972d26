"""Fields of the parameters of a verb, as its signature and its docstring declare them."""

from __future__ import annotations

import re
from collections.abc import Iterable, Mapping, MutableMapping, Sequence
from functools import partial
from typing import Any

from nicegui import ui

from tactogram.cli.verbs import converted
from tactogram.parameters import Parameter

NUMBERS = ("int", "float", "Count", "NotNegative", "Positive", "Share")
"""Annotations of numbers."""


class ParameterFields:
    """A field for each of the parameters ``names`` of a verb, in this order; empty ones are left out.

    ``labels`` and ``examples`` are by name; a label is by default the name, and what the verb says of the
    parameter is the field's tooltip. What is entered is in ``entries``, such as those of a browser's storage.
    """

    def __init__(
        self,
        parameters: Iterable[Parameter],
        names: Sequence[str],
        *,
        labels: Mapping[str, str] | None = None,
        examples: Mapping[str, str] | None = None,
        entries: MutableMapping[str, Any] | None = None,
        classes: str = "w-36",
    ) -> None:
        known = {option.name: option for option in parameters}
        self._parameters = {
            name: (known[name], (labels or {}).get(name, name.capitalize())) for name in names
        }
        self._entries: MutableMapping[str, Any] = {} if entries is None else entries
        for name, (option, label) in self._parameters.items():
            field = ui.input(label, placeholder=(examples or {}).get(name, ""))
            field.set_value(str(self._entries.get(name) or ""))
            field.on_value_change(partial(self._store, name)).classes(classes)
            field.props('inputmode="decimal"' if option.annotation in NUMBERS else "").tooltip(option.text)

    def values(self) -> dict[str, Any]:
        """Return the checked values by name; `ParameterError` names the first field that is not one."""
        return {
            name: value_of(option, text, label=label)
            for name, (option, label) in self._parameters.items()
            if (text := str(self._entries.get(name) or "").strip())
        }

    def _store(self, name: str, event: Any) -> None:
        self._entries[name] = event.value or ""


def value_of(parameter: Parameter, entry: Any, *, label: str = "") -> Any:
    """Return an entry as a value of a parameter: of a text the list or the pairs that commas separate."""
    if parameter.annotation.startswith("Mapping"):
        entry = [re.sub(r"\s*=\s*", "=", part.strip()) for part in entry.split(",") if part.strip()]
    return parameter.check(converted(label or parameter.name, entry, parameter.kind))
