"""Fields: numbers that are checked and never altered, forms whose entries survive a reload, and declared settings."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, MutableMapping, Sequence
from dataclasses import dataclass
from typing import Any, Protocol, TypeVar

from nicegui import ui
from nicegui.elements.mixins.value_element import ValueElement

from tactogram.errors import ParameterError

Field = TypeVar("Field", bound=ValueElement[Any])
Options = Sequence[str] | Mapping[Any, str]
"""Choices, or their titles by value."""


class NumberField(ui.number):
    """A number field that leaves bad input as typed; `checked` refuses it.

    NiceGUI's own field silently moves a number into its range when it loses focus.
    """

    def sanitize(self) -> None:
        """Leave the value unchanged."""

    def checked(
        self, *, least: float = -math.inf, most: float = math.inf, whole: bool = False
    ) -> float | None:
        """Return the number, or None if the field is empty; raise `ParameterError` naming the field as `in_range`."""
        return in_range(self.label or "number", self.value, least=least, most=most, whole=whole)


def in_range(
    name: str, value: float | None, *, least: float = -math.inf, most: float = math.inf, whole: bool = False
) -> float | None:
    """Return ``value`` unchanged, None included.

    Raises `ParameterError` if it is outside ``least`` to ``most``, or a fraction although ``whole``.
    """
    if value is None:
        return None
    if whole and not float(value).is_integer():
        raise ParameterError(f"{name} must be a whole number, got {value:g}")
    if not least <= value <= most:
        bounds = f"at least {least:g}" if most == math.inf else f"{least:g} to {most:g}"
        raise ParameterError(f"{name} must be {bounds}, got {value:g}")
    return value


@dataclass
class Form:
    """Fields whose entries are in ``values`` by name, such as those of a browser's storage, which survive a reload.

    ``changed`` is called after each change; ``classes`` are the fields' own.
    """

    values: MutableMapping[str, Any]
    changed: Callable[[], Any] | None = None
    classes: str = "w-full"

    def text(self, name: str, label: str, default: str = "", *, hint: str = "", **options: Any) -> ui.input:
        """Draw a field of a text."""
        field = ui.input(label, value=self._value(name, default), **options)
        return self._bound(field.props(f'hint="{hint}"') if hint else field, name)

    def number(self, name: str, label: str, default: float | None = None, **options: Any) -> NumberField:
        """Draw a field of a number, which may be empty."""
        return self._bound(NumberField(label, value=self._value(name, default), **options), name)

    def choice(self, name: str, options: Options, label: str, default: Any = None, **more: Any) -> ui.select:
        """Draw a choice; an entry that is no longer offered becomes the default, by default the first."""
        if self.values.get(name) not in options:
            self.values[name] = default if default in options else next(iter(options), None)
        shown = list(options) if isinstance(options, Sequence) else dict(options)
        return self._bound(ui.select(shown, label=label, value=self.values[name], **more), name)

    def box(self, name: str, label: str, default: bool = False) -> ui.checkbox:
        """Draw a box to tick."""
        return self._bound(ui.checkbox(label, value=bool(self._value(name, default))), name)

    def stripped(self, name: str) -> str:
        """Return the entry of a text without spaces around it."""
        return str(self.values.get(name) or "").strip()

    def _value(self, name: str, default: Any) -> Any:
        return self.values.setdefault(name, default)

    def _bound(self, field: Field, name: str) -> Field:
        def store(event: Any) -> Any:
            self.values[name] = event.value
            return self.changed() if self.changed else None

        field.on_value_change(store)
        return field.classes(self.classes)


class Declared(Protocol):
    """A setting as its model declares it."""

    @property
    def widget(self) -> str:
        """One of switch, choice, integer, number, numbers, line and text."""

    @property
    def choices(self) -> Options:
        """Values of a choice, or their titles by value."""


def declared_field(field: Declared, label: str, value: Any, change: Callable[[Any], Any]) -> Any:
    """Draw and return the widget of a declared setting, which calls ``change`` with each entry."""
    if field.widget == "switch":
        return ui.switch(label, value=bool(value), on_change=lambda event: change(event.value))
    if field.widget == "choice":
        titles = field.choices if isinstance(field.choices, Mapping) else {one: one for one in field.choices}
        other = {} if value in titles else {value: "none" if value is None else str(value)}
        options = other | dict(titles)
        widget: Any = ui.select(
            options, label=label, value=value, on_change=lambda event: change(event.value)
        )
        return widget.props("dense options-dense")
    if field.widget in ("integer", "number"):
        widget = NumberField(label, value=value, format="%.10g")
    else:
        widget = ui.input(label, value=value or "")
    return widget.on_value_change(lambda event: change(event.value)).props("dense debounce=300")
