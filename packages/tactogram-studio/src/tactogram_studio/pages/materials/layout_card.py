"""Card of files with the same columns: what each column is read as, and the first file as it would be imported."""

from __future__ import annotations

from base64 import b64encode
from collections.abc import Awaitable, Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import partial
from typing import Any

from nicegui import ui

from tactogram.datasets import Recording
from tactogram.errors import ParameterError, UnitError
from tactogram.signal import Signal, parse_seconds, parse_unit, split_heading
from tactogram.signal.io import (
    IGNORED,
    LABELS,
    RATE,
    STREAM_OF_UNIT,
    TIME,
    UNCLEAR,
    TableLayout,
    default_axes,
    heading,
    time_unit_of,
)
from tactogram.validation import validated
from tactogram_studio import kit
from tactogram_studio.workspace.recordings import trace_svg

STREAM_ROLES = ("force", "position")
"""Streams of their own beside the axes; one column is their z, three are x, y and z."""
ROLES = (TIME, "x", "y", "z", *STREAM_ROLES, *LABELS, IGNORED)
TIME_UNITS = ("s", "ms", "us", "ns")
UNITS = ("m/s^2", "g", "mg", "m/s", "mm/s", "m", "mm", "um", "N", "mN", "V", "mV", "1")
ROLE_NAMES = {UNCLEAR: "choose", IGNORED: "not read", RATE: "sampling rate"}


@dataclass(frozen=True)
class ColumnChoices:
    """Role and unit of each column; roles are `ROLES`, other names of axes, and ``STREAM: AXIS`` of other streams."""

    headings: tuple[str, ...]
    roles: tuple[str, ...]
    units: tuple[str, ...]  # empty where none is stated
    rate: float | None = None  # Hz
    stream: str | None = None  # of the axes; by default after the unit

    @classmethod
    def of(cls, columns: Sequence[Mapping[str, Any]], layouts: Sequence[TableLayout]) -> ColumnChoices:
        """Return the choices that ``layouts`` of these columns make; without axes in them, those of a preview."""
        headings = tuple(column["heading"] for column in columns)
        roles = {column["heading"]: column["role"] for column in columns}
        units = {column["heading"]: _known(column["unit"]) for column in columns}
        main = next((layout for layout in layouts if layout.stream not in STREAM_ROLES), None)
        if layouts and all(layout.axes for layout in layouts):
            roles = {name: role if role == RATE else IGNORED for name, role in roles.items()}
            for layout in layouts:
                roles |= _roles(layout, main=layout is main)
                units |= {
                    name: layout.unit or _known(split_heading(name)[1]) for name in layout.axes.values()
                }
                if layout.time is not None:
                    units[layout.time] = layout.time_unit or _known(time_unit_of(heading(layout.time)))
        return cls(
            headings,
            tuple(roles[name] for name in headings),
            tuple(units[name] for name in headings),
            layouts[0].rate if layouts else None,
            main.stream if main else None,
        )

    def with_role(self, place: int, role: str) -> ColumnChoices:
        """Change the role of a column; time and axes have other units."""
        unit = self.units[place]
        changed = replace(self, roles=_put(self.roles, place, role))
        if not unit or (role == TIME) != (parse_seconds(unit) is not None):
            unit = changed.stated_unit(place)
        changed = replace(changed, units=_put(self.units, place, unit))
        alike = [self.units[i] for i in changed.of_one_stream(place) if i != place]
        return changed.with_unit(place, alike[0]) if alike and not unit else changed

    def stated_unit(self, place: int) -> str:
        """Return the unit in a heading, which stays unless another is chosen; empty if there is none."""
        text = self.headings[place]
        timed = self.roles[place] == TIME
        unit = time_unit_of(heading(text)) if timed else heading(text).unit
        return _known(unit) if timed == (parse_seconds(unit or "") is not None) else ""

    def with_unit(self, place: int, unit: str) -> ColumnChoices:
        """Change the unit of a column, and of those in its stream: a stream has one unit."""
        alike = self.of_one_stream(place)
        return replace(self, units=tuple(unit if i in alike else old for i, old in enumerate(self.units)))

    def of_one_stream(self, place: int) -> list[int]:
        """Return the columns in the stream of a column."""
        stream = _stream(self.roles[place])
        if stream is None or self.roles[place] == TIME:
            return [place]
        return [i for i, role in enumerate(self.roles) if role != TIME and _stream(role) == stream]

    def layouts(self) -> list[TableLayout]:
        """Return the mapping: a layout per stream; `ParameterError` if the choices contradict each other."""
        streams: dict[str, list[int]] = {}
        for place, role in enumerate(self.roles):
            if role != TIME and (stream := _stream(role)) is not None:
                streams.setdefault(stream, []).append(place)
        if not streams:
            raise ParameterError("choose x, y, z, force or position for at least one column")
        times = [i for i, role in enumerate(self.roles) if role == TIME]
        for role in (TIME, *LABELS):
            self._check_once(role, [i for i, other in enumerate(self.roles) if other == role])
        return [self._layout(stream, places, times, len(streams)) for stream, places in streams.items()]

    def _layout(self, stream: str, places: Sequence[int], times: Sequence[int], streams: int) -> TableLayout:
        unit = self.units[places[0]] or None
        names = [self.roles[i].rpartition(": ")[2] for i in places]
        if {*names} == {stream}:
            names = list(default_axes(len(places)))
        for name in names:
            self._check_once(name, [i for i, other in zip(places, names, strict=True) if other == name])
        named = stream or self.stream
        if not named and streams > 1:
            named = STREAM_OF_UNIT[parse_unit(unit or "1")[0]]
        time_unit = self.units[times[0]] if times else ""
        values = {
            "columns": self.headings,
            "axes": {axis: self.headings[i] for axis, i in zip(names, places, strict=True)},
            "unit": unit,
            "time": self.headings[times[0]] if times else None,
            "time_unit": time_unit or None,
            "rate": self.rate,
            "stream": named or None,
            **{
                role: heading
                for role, heading in zip(self.roles, self.headings, strict=True)
                if role in LABELS
            },
        }
        return validated(TableLayout, values, where="layout")

    def _check_once(self, role: str, places: Sequence[int]) -> None:
        if len(places) > 1:
            listed = ", ".join(self.headings[i] for i in places)
            raise ParameterError(f"{role} must be one column, got {listed}; choose another for one of them")


def _stream(role: str) -> str | None:
    """Return the stream of a role, empty for the axes of the first one; None for columns that are not read."""
    if role in (RATE, IGNORED, UNCLEAR, *LABELS):
        return None
    return role if role in STREAM_ROLES else role.rpartition(": ")[0]


def _roles(layout: TableLayout, *, main: bool) -> dict[str, str]:
    """Return the role of each heading in a layout, without those that it ignores."""
    roles = {heading: role for role, heading in layout.labels.items()}
    roles |= {} if layout.time is None else {layout.time: TIME}
    places = [layout.columns.index(heading) for heading in layout.axes.values()]
    usual = tuple(layout.axes) == default_axes(len(places)) and places == sorted(places)
    usual = usual and layout.stream in STREAM_ROLES
    for axis, column in layout.axes.items():
        role = axis if main else f"{layout.stream}: {axis}"
        roles[column] = str(layout.stream) if usual else role
    return roles


def _known(unit: str | None) -> str:
    """Return a unit that can be converted, else an empty text."""
    try:
        parse_unit(unit or "")
    except UnitError:
        return unit if unit and parse_seconds(unit) else ""
    return unit or ""


def _put(values: tuple[str, ...], place: int, value: str) -> tuple[str, ...]:
    return (*values[:place], value, *values[place + 1 :])


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
            self._picture = kit.column(gap=2)
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
                _draw_signal(f"{self.example}: {stream}", signal)

    def _draw_columns(self) -> None:
        with ui.element("div").classes("columns").props('role="group" aria-label="Columns"'):
            for place, name in enumerate(self.choices.headings):
                ui.label(name).style("overflow-wrap: anywhere")
                role = ui.select(self._roles_of(place), value=self.choices.roles[place])
                role.props(f'dense options-dense aria-label="{kit.attribute(name)}: read as"')
                unit = ui.select(self._units_of(place), value=self.choices.units[place])
                unit.props(f'dense options-dense aria-label="{kit.attribute(name)}: unit"')
                role.on_value_change(partial(self._set_role, place))
                unit.on_value_change(partial(self._set_unit, place))
                self._lists.append((role, unit))
        rate = kit.NumberField("Rate, Hz", value=self.choices.rate, placeholder="as the files say")
        rate.props("dense debounce=700").classes("w-44").on_value_change(self._set_rate)
        self._show_choices()

    def _roles_of(self, place: int) -> dict[str, str]:
        roles = dict.fromkeys([*ROLES, *self.choices.roles])
        wanted = [role for role in roles if role not in (RATE, UNCLEAR) or self.choices.roles[place] == role]
        return {role: ROLE_NAMES.get(role, role) for role in wanted}

    def _units_of(self, place: int) -> dict[str, str]:
        timed, stated = self.choices.roles[place] == TIME, self.choices.stated_unit(place)
        usual = TIME_UNITS if timed else UNITS
        none = "as stated, or s" if timed else "no unit stated"
        units = dict.fromkeys([*([] if stated else [""]), *usual, stated, self.choices.units[place]])
        return {unit: unit or none for unit in units if unit or not stated}

    async def _set_role(self, place: int, event: Any) -> None:
        if event.value != self.choices.roles[place]:
            await self._change(self.choices.with_role(place, event.value))

    async def _set_unit(self, place: int, event: Any) -> None:
        if event.value != self.choices.units[place]:
            await self._change(self.choices.with_unit(place, event.value))

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
        for place, (role, unit) in enumerate(self._lists):
            role.set_options(self._roles_of(place), value=self.choices.roles[place])
            unit.set_options(self._units_of(place), value=self.choices.units[place])
            unit.set_enabled(self.choices.roles[place] not in (IGNORED, UNCLEAR, RATE, *LABELS))


def headings_of(facts: Mapping[str, Any]) -> tuple[str, ...]:
    """Return the headings of a layout of a preview; none of sounds."""
    return tuple(column["heading"] for column in facts["columns"])


def by_key(layouts: Sequence[Mapping[str, Any]]) -> dict[str, Mapping[str, Any]]:
    """Return the layouts of a preview by their headings, or by their first file where these do not distinguish them."""
    found: dict[str, Mapping[str, Any]] = {}
    for facts in layouts:
        headings = repr(headings_of(facts))
        found[facts["example"] if headings in found or not facts["columns"] else headings] = facts
    return found


def _draw_signal(title: str, signal: Signal) -> None:
    over, per = ("s", "Hz") if signal.domain == "time" else ("mm", "per mm")
    ui.label(title).style("overflow-wrap: anywhere")
    kit.hint(f"{signal.extent:.4g} {over} at {signal.rate:.6g} {per}")
    for axis, samples in zip(signal.axes, signal.samples, strict=True):
        low, high = (f"{value:.4g}" for value in (samples.min(), samples.max()))
        text = f"{axis}: {low} to {high} {'' if signal.unit == '1' else signal.unit}".strip()
        picture = trace_svg(replace(signal, samples=samples[None], axes=(axis,)))
        source = f"data:image/svg+xml;base64,{b64encode(picture).decode()}"
        kit.hint(text)
        ui.element("img").classes("trace").props(f'src="{source}" alt="Waveform of {kit.attribute(text)}"')


def timing_text(facts: Mapping[str, Any]) -> str:
    """Return streams, rates and durations of a layout in a line; empty if no file can be read."""
    if not facts["seconds"]:
        return ""
    parts = [
        f"{name}: {', '.join(stream['axes'])} in {'no unit' if stream['unit'] == '1' else stream['unit']}"
        for name, stream in facts["streams"].items()
    ]
    parts.append(f"{', '.join(f'{rate:.7g}' for rate in facts['rates_hz'])} Hz")
    if facts["estimated_rates_hz"] and facts["jitter_s"] > 1e-7:
        low, high = facts["estimated_rates_hz"]
        span = f"{low:.6g}" if low == high else f"{low:.6g} to {high:.6g}"
        parts.append(f"time stamps: {span} Hz, jitter up to {1e3 * facts['jitter_s']:.3g} ms")
    short, long = facts["seconds"]
    parts.append(f"{short:.4g} s" if short == long else f"{short:.4g} to {long:.4g} s")
    if facts["interpolated"]:
        gap = 1e3 * facts["largest_gap_s"]
        parts.append(f"{facts['interpolated']} samples interpolated, longest gap {gap:.3g} ms")
    return " · ".join(parts)
