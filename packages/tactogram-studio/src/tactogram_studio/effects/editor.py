"""Editor of an effect: its history, what is selected, and the operations of the page."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from typing import Any, Literal, cast

from tactogram.errors import ParameterError
from tactogram_studio.effects import editing as edit
from tactogram_studio.effects.effect import LEAST_S, LONGEST_S, MOST_TRACKS, Effect, Track

Operation = Literal["trim", "clear", "in", "out", "repeat"]
MOST_STEPS = 200
"""Steps that can be undone."""
MOST_DRAWN = 5000
GAP_S = 0.1
"""Pause after an added track, before the cursor, s."""
LINES = ("amplitude", "frequency", "transients")
TONE = "tones"
"""Line of the transients' frequencies."""


@dataclass
class Editor:
    """An effect being edited. Times are in s; ``range`` is the selected time, None for the whole track."""

    effect: Effect
    track: int = 0
    item: tuple[str, int] | None = None
    range: tuple[float, float] | None = None
    cursor: float = 0.0
    _undo: list[Effect] = field(default_factory=list)
    _redo: list[Effect] = field(default_factory=list)
    _step: object = None
    """What the last change was about: another of the same is not a step of its own."""

    @property
    def undoable(self) -> bool:
        """Whether there is a change to undo."""
        return bool(self._undo)

    @property
    def redoable(self) -> bool:
        """Whether there is an undone change to redo."""
        return bool(self._redo)

    def undo(self) -> None:
        """Take the last change back."""
        self._swap(self._undo, self._redo)

    def redo(self) -> None:
        """Make the last undone change again."""
        self._swap(self._redo, self._undo)

    def change(self, effect: Effect, *, step: object = None) -> None:
        """Replace the effect; ``step`` is equal for changes that are undone together."""
        if effect == self.effect:
            return
        if step is None or step != self._step:
            self._undo = [*self._undo, self.effect][-MOST_STEPS:]
        self._redo, self._step, self.effect = [], step, effect
        self._settle()

    def handle(self, event: Mapping[str, Any]) -> None:
        """Apply an event of the page's script; `ParameterError` if it is not valid."""
        handlers: dict[str, Callable[[Mapping[str, Any]], None]] = {
            "select": self._select,
            "range": self._range,
            "add": self._add,
            "move": self._move,
            "remove": self._remove,
            "draw": self._draw,
            "start": self._start,
            "gain": self._gain,
            "mute": self._mute,
            "drop": self._drop,
        }
        handler = handlers.get(str(event.get("do")))
        if handler is None:
            raise ParameterError.one_of("do", handlers, str(event.get("do"))[:40])
        handler(event)

    def insert(self, tracks: tuple[Track, ...], *, simulated: bool = False) -> None:
        """Add tracks at the cursor and select the last; the cursor moves behind them."""
        if len(self.effect.tracks) + len(tracks) > MOST_TRACKS:
            raise ParameterError(f"an effect has at most {MOST_TRACKS} tracks; merge or remove some")
        added = tuple(edit.shifted(track, self.cursor) for track in tracks)
        simulated = simulated or self.effect.simulated
        self.change(self.effect.changed(tracks=(*self.effect.tracks, *added), simulated=simulated))
        self.track, self.item, self.range = len(self.effect.tracks) - 1, None, None
        end = max(track.end for track in added)
        if end:
            self.cursor = min(LONGEST_S, round(end + GAP_S, 3))

    def operate(self, name: Operation, **options: Any) -> None:
        """Apply an operation to the selected track: within the selected range, else to all of it."""
        track = self.effect.track(self.track)
        start, end = self.range or (track.start, track.end)
        if end <= start:
            raise ParameterError("the track is empty; add a ready effect, or draw on it")
        if name == "trim":
            new = edit.trimmed(track, start, end)
        elif name == "clear":
            new = edit.cleared(track, start, end)
        elif name == "repeat":
            new = edit.repeated(track, start, end, **options)
        else:
            new = edit.faded(track, start, end, name)
        self._put(self.track, new)

    def merge(self) -> None:
        """Mix all tracks that sound into one."""
        self.change(edit.merged(self.effect))
        self.track, self.item = len(self.effect.tracks) - 1, None

    def _swap(self, back: list[Effect], forth: list[Effect]) -> None:
        if back:
            forth.append(self.effect)
            self.effect, self._step = back.pop(), None
            self._settle()

    def _settle(self) -> None:
        """Select nothing that the effect no longer has."""
        self.track = max(0, min(self.track, len(self.effect.tracks) - 1))
        if self.item is not None and self.effect.tracks:
            line, index = self.item
            count = len(getattr(self.effect.tracks[self.track], "transients" if line == TONE else line))
            self.item = self.item if index < count else None
        elif not self.effect.tracks:
            self.item = None

    def _put(self, number: int, track: Track, *, step: object = None) -> None:
        self.change(self.effect.with_track(number, track), step=step)

    def _select(self, event: Mapping[str, Any]) -> None:
        number = _whole(event, "track")
        self.effect.track(number)
        self.track = number
        self.item = (_line(event), _whole(event, "index")) if "line" in event else None
        self._step = None
        self._settle()

    def _range(self, event: Mapping[str, Any]) -> None:
        start, end = sorted((_number(event, "start"), _number(event, "end")))
        start, end = max(0.0, start), min(LONGEST_S, end)
        self.cursor = round(start, 6)
        self.range = (round(start, 6), round(end, 6)) if end - start >= LEAST_S else None

    def _add(self, event: Mapping[str, Any]) -> None:
        number, line = _whole(event, "track"), _line(event)
        time, value = _number(event, "time"), _number(event, "value")
        track = self.effect.track(number)
        if line == "transients":
            hz = edit.value_at(track.frequency, time)
            new, index = edit.with_transient(track, time, value, hz)
        else:
            new, index = edit.with_point(track, cast(edit.Line, line), time, value)
        self._put(number, new)
        self.track, self.item = number, (line, index)

    def _move(self, event: Mapping[str, Any]) -> None:
        number, line, index = _whole(event, "track"), _line(event), _whole(event, "index")
        time, value = _number(event, "time"), _number(event, "value")
        track = self.effect.track(number)
        if line in ("transients", TONE):
            if not 0 <= index < len(track.transients):
                raise ParameterError(
                    f"the track has {len(track.transients)} transients, there is no {index + 1}."
                )
            old = track.transients[index]
            amplitude, hz = (value, old.frequency) if line == "transients" else (old.amplitude, value)
            new, index = edit.changed_transient(track, index, time=time, amplitude=amplitude, frequency=hz)
        else:
            new = edit.moved_point(track, cast(edit.Line, line), index, time, value)
        self._put(number, new, step=(number, line, index) if event.get("nudge") else None)
        self.track, self.item = number, (line, index)

    def _remove(self, event: Mapping[str, Any]) -> None:
        number, line, index = _whole(event, "track"), _line(event), _whole(event, "index")
        track = self.effect.track(number)
        if line in ("transients", TONE):
            new = edit.without_transient(track, index)
        else:
            new = edit.without_point(track, cast(edit.Line, line), index)
        left = len(getattr(new, "transients" if line == TONE else line))
        self.track, self.item = number, (line, max(0, index - 1)) if left else None
        self._put(number, new)

    def _draw(self, event: Mapping[str, Any]) -> None:
        number, line = _whole(event, "track"), _line(event)
        points = event.get("points")
        if line not in ("amplitude", "frequency") or not isinstance(points, list) or len(points) > MOST_DRAWN:
            raise ParameterError(
                f"a drawing needs an amplitude or a frequency, and at most {MOST_DRAWN} points"
            )
        drawn = [(_number(point, "time"), _number(point, "value")) for point in points]
        self._put(number, edit.drawn(self.effect.track(number), cast(edit.Line, line), drawn))
        self.track, self.item = number, None

    def _start(self, event: Mapping[str, Any]) -> None:
        number = _whole(event, "track")
        track = self.effect.track(number)
        self._put(number, edit.shifted(track, _number(event, "value") - track.start), step=("start", number))

    def _gain(self, event: Mapping[str, Any]) -> None:
        number = _whole(event, "track")
        track = self.effect.track(number).changed(gain=round(_number(event, "value"), 3))
        self._put(number, track, step=("gain", number))

    def _mute(self, event: Mapping[str, Any]) -> None:
        number = _whole(event, "track")
        track = self.effect.track(number)
        self._put(number, track.changed(muted=not track.muted))

    def _drop(self, event: Mapping[str, Any]) -> None:
        number = _whole(event, "track")
        self.effect.track(number)
        tracks = self.effect.tracks
        self.change(self.effect.changed(tracks=(*tracks[:number], *tracks[number + 1 :])))
        self.item = None


def _number(event: Mapping[str, Any], name: str) -> float:
    value = event.get(name)
    if isinstance(value, bool) or not isinstance(value, int | float) or not math.isfinite(value):
        raise ParameterError(f"{name} must be a number, got {str(value)[:40]!r}")
    return float(value)


def _whole(event: Mapping[str, Any], name: str) -> int:
    value = event.get(name)
    if isinstance(value, bool) or not isinstance(value, int):
        raise ParameterError(f"{name} must be a whole number, got {str(value)[:40]!r}")
    return value


def _line(event: Mapping[str, Any]) -> str:
    line = str(event.get("line"))
    if line not in (*LINES, TONE):
        raise ParameterError.one_of("line", (*LINES, TONE), line[:40])
    return line
