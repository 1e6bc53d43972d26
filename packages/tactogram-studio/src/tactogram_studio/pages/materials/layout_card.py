"""Card of files with the same columns: what each column is read as, and the first file as it would be imported."""

from __future__ import annotations

from base64 import b64encode
from collections.abc import Awaitable, Callable, Mapping, Sequence
from dataclasses import replace
from functools import partial
from typing import Any

from nicegui import ui

from tactogram.datasets import Recording
from tactogram.errors import ParameterError
from tactogram.signal import Signal
from tactogram.signal.io import (
    IGNORED,
    LABELS,
    RATE,
    TIME,
    UNCLEAR,
    TableLayout,
)
from tactogram_studio import kit
from tactogram_studio.workspace.imports import ROLES, ColumnChoices, timing_text
from tactogram_studio.workspace.recordings import trace_svg

TIME_UNITS = ("s", "ms", "us", "ns")
UNITS = ("m/s^2", "g", "mg", "m/s", "mm/s", "m", "mm", "um", "N", "mN", "V", "mV", "1")
ROLE_NAMES = {UNCLEAR: "choose", IGNORED: "not read", RATE: "sampling rate"}


class LayoutCard:
    """A layout of a preview; ``changed`` is called with the mapping of its columns whenever the user changes it."""

    def __init__(
        self,
        number: int,
        key: str,
        facts: Mapping[str, Any],
        layouts: Sequence[TableLayout],
        changed: Callable[[Sequence[TableLayout]], Awaitable[None]] | None,
    ) -> None:
        self.number, self.key, self.facts, self._changed = number, key, facts, changed
        self.choices = ColumnChoices.of(facts["columns"], layouts)
        self._lists: list[tuple[ui.select, ui.select]] = []
        self._shown = ""

    @property
    def example(self) -> str:
        """Name of the first file."""
        return str(self.facts["example"])

    def draw(self) -> None:
        """Draw the card without its picture."""
        with kit.card(label=f"Layout {self.number}", classes="w-full layout"):
            with ui.element("div"):
                kit.heading(f"Layout {self.number}")
                self._counts = ui.label().style("overflow-wrap: anywhere")
                if self.choices.headings and self._changed is not None and not self.facts["tables"]:
                    self._draw_columns()
                self._timing = kit.hint("")
                self._problem = kit.alert()
            self._picture = ui.element("div").classes("streams")
        self.update(self.facts)

    def update(self, facts: Mapping[str, Any]) -> None:
        """Show another preview of the same files."""
        self.facts = facts
        files = f"{facts['files']} file{'s' * (facts['files'] != 1)}"
        skipped = f", {facts['skipped']} of them would be skipped" if facts["skipped"] else ""
        self._counts.text = f"{files}{skipped}, e.g. {facts['example']}"
        self._timing.text = timing_text(facts)

    def show(self, recording: Recording | str) -> None:
        """Show the first file as it would be imported, or why it cannot be read."""
        shown = recording if isinstance(recording, str) else recording.id
        if shown == self._shown:
            return
        self._shown = shown
        self._picture.clear()
        with self._picture:
            if isinstance(recording, str):
                ui.label(recording).classes("text-negative").style("overflow-wrap: anywhere")
                return
            for stream, signal in recording.streams.items():
                with kit.column(gap=1):
                    _draw_signal(stream, signal)

    def _draw_columns(self) -> None:
        with ui.element("div").classes("columns").props('role="group" aria-label="Columns"'):
            for column, name in enumerate(self.choices.headings):
                ui.label(name).style("overflow-wrap: anywhere")
                role = ui.select(self._roles_of(column), value=self.choices.roles[column])
                role.props(f'aria-label="{kit.attribute(name)}: read as"')
                unit = ui.select(self._units_of(column), value=self.choices.units[column])
                unit.props(f'aria-label="{kit.attribute(name)}: unit"')
                role.on_value_change(partial(self._set_role, column))
                unit.on_value_change(partial(self._set_unit, column))
                self._lists.append((role, unit))
        rate = kit.NumberField("Rate, Hz", value=self.choices.rate, placeholder="as the files say")
        rate.props("debounce=700").classes("w-44").on_value_change(self._set_rate)
        self._show_choices()

    def _roles_of(self, column: int) -> dict[str, str]:
        roles = dict.fromkeys([*ROLES, *self.choices.roles])
        shown = [role for role in roles if role not in (RATE, UNCLEAR) or self.choices.roles[column] == role]
        return {role: ROLE_NAMES.get(role, role) for role in shown}

    def _units_of(self, column: int) -> dict[str, str]:
        timed, stated = self.choices.roles[column] == TIME, self.choices.stated_unit(column)
        usual = TIME_UNITS if timed else UNITS
        none = "as stated, or s" if timed else "no unit stated"
        units = dict.fromkeys([*([] if stated else [""]), *usual, stated, self.choices.units[column]])
        return {unit: unit or none for unit in units if unit or not stated}

    async def _set_role(self, column: int, event: Any) -> None:
        if event.value != self.choices.roles[column]:
            await self._change(self.choices.with_role(column, event.value))

    async def _set_unit(self, column: int, event: Any) -> None:
        if event.value != self.choices.units[column]:
            await self._change(self.choices.with_unit(column, event.value))

    async def _set_rate(self, event: Any) -> None:
        value = None if event.value is None else float(event.value)
        if value != self.choices.rate:
            await self._change(replace(self.choices, rate=value))

    async def _change(self, choices: ColumnChoices) -> None:
        self.choices = choices
        try:
            layouts = choices.layouts()
        except ParameterError as error:
            self._problem.text = str(error)
            self._show_choices()
            return
        self._problem.text = ""
        read = tuple(IGNORED if role == UNCLEAR else role for role in choices.roles)
        self.choices = replace(choices, roles=read)
        self._show_choices()
        if self._changed is not None:
            await self._changed(layouts)

    def _show_choices(self) -> None:
        """Show roles and units as they are now: a unit may follow from another."""
        for column, (role, unit) in enumerate(self._lists):
            role.set_options(self._roles_of(column), value=self.choices.roles[column])
            unit.set_options(self._units_of(column), value=self.choices.units[column])
            unit.set_enabled(self.choices.roles[column] not in (IGNORED, UNCLEAR, RATE, *LABELS))


def _draw_signal(title: str, signal: Signal) -> None:
    over, per = ("s", "Hz") if signal.domain == "time" else ("mm", "per mm")
    ui.label(f"{title}, {signal.extent:.4g} {over} at {signal.rate:.6g} {per}")
    for axis, samples in zip(signal.axes, signal.samples, strict=True):
        low, high = (f"{value:.4g}" for value in (samples.min(), samples.max()))
        text = f"{axis}: {low} to {high} {'' if signal.unit == '1' else signal.unit}".strip()
        picture = trace_svg(replace(signal, samples=samples[None], axes=(axis,)))
        source = f"data:image/svg+xml;base64,{b64encode(picture).decode()}"
        kit.hint(text)
        ui.element("img").classes("trace").props.update(src=source, alt=f"Waveform of {text}")
