"""Choices of the import page about the columns of a layout of tables, and the mapping that they make."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any

from tactogram.errors import ParameterError, UnitError
from tactogram.signal import parse_seconds, parse_unit, split_heading
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

STREAM_ROLES = ("force", "position")
"""Streams of their own beside the axes; one column is their z, three are x, y and z."""
ROLES = (TIME, "x", "y", "z", *STREAM_ROLES, *LABELS, IGNORED)
TIME_UNITS = ("s", "ms", "us", "ns")
UNITS = ("m/s^2", "g", "mg", "m/s", "mm/s", "m", "mm", "um", "N", "mN", "V", "mV", "1")


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
