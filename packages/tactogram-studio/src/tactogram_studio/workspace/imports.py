"""Import of recordings: its settings, and what each column of the files is read as."""

from __future__ import annotations

import shlex
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

from tactogram.datasets import TableMapping, layouts_by_columns
from tactogram.errors import ParameterError, UnitError
from tactogram.recipe import parse_changes
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
from tactogram_studio.workspace.folder import Workspace

STREAM_ROLES = ("force", "position")
"""Streams of their own beside the axes; one column is their z, three are x, y and z."""
ROLES = (TIME, "x", "y", "z", *STREAM_ROLES, *LABELS, IGNORED)


class ImportSettings:
    """Settings of an import of a ``folder`` of the workspace; ``values`` survive a reload."""

    def __init__(self, workspace: Workspace, folder: str, values: dict[str, Any]) -> None:
        self.workspace, self.folder, self.values = workspace, folder, values

    @property
    def path(self) -> Path:
        """The folder; `ParameterError` if it is gone, or outside of the workspace."""
        path = self.workspace.inside(self.folder)
        if not path.is_dir():
            raise ParameterError(f"{self.folder[:200]}: no longer available; choose it again")
        return path

    @property
    def layouts(self) -> list[TableLayout]:
        """The mapping so far."""
        return [TableLayout.model_validate(values) for values in self.values["layouts"]]

    @property
    def is_folder(self) -> bool:
        """Whether the files are the user's own, which a mapping can describe."""
        return bool(self.values["set"] == "folder")

    def options(self) -> dict[str, Any]:
        """Return the options of the importer; `ParameterError` if they cannot be read."""
        options = parse_changes(shlex.split(self.values["options"] or ""), option="Missing information")
        if self.is_folder:
            if self.values["material_from"] != "folder":
                options["material_from"] = self.values["material_from"]
            if layouts := self.layouts:
                options["mapping"] = TableMapping(layout=tuple(layouts))
        return options

    def map_columns(self, layouts: Sequence[TableLayout]) -> None:
        """Store another mapping of some columns."""
        others = layouts_by_columns(self.layouts) | layouts_by_columns(layouts)
        flat = [layout.model_dump(mode="json") for alike in others.values() for layout in alike]
        self.values.update(layouts=flat, mapping="")


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
        for column, role in enumerate(self.roles):
            if role != TIME and (stream := _stream(role)) is not None:
                streams.setdefault(stream, []).append(column)
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


def _put(values: tuple[str, ...], index: int, value: str) -> tuple[str, ...]:
    return (*values[:index], value, *values[index + 1 :])


def headings_of(facts: Mapping[str, Any]) -> tuple[str, ...]:
    """Return the headings of a layout of a preview; none of sounds."""
    return tuple(column["heading"] for column in facts["columns"])


def by_key(layouts: Sequence[Mapping[str, Any]]) -> dict[str, Mapping[str, Any]]:
    """Return the layouts of a preview by their headings, or by their first file where these do not distinguish them."""
    keyed: dict[str, Mapping[str, Any]] = {}
    for facts in layouts:
        headings = repr(headings_of(facts))
        keyed[facts["example"] if headings in keyed or not facts["columns"] else headings] = facts
    return keyed


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
