"""Timeline of the page Edit: its tools, the tracks that the script draws, and the numbers of what is selected."""

from __future__ import annotations

import json
from collections.abc import Callable
from functools import partial
from typing import Any

from nicegui import events, ui

from tactogram.errors import ParameterError
from tactogram_studio import kit
from tactogram_studio.effects.editor import LINES, TONE, Editor, Operation
from tactogram_studio.effects.effect import Track

TOOLS = {"select": "Select", "draw": "Draw", "transient": "Add transients"}
SNAPS = {0.001: "1 ms", 0.005: "5 ms", 0.01: "10 ms", 0.05: "50 ms"}
ZOOMS = {"Zoom in": ("zoom_in", 2), "Zoom out": ("zoom_out", 0.5), "Fit": ("fit_screen", 0)}
OPERATIONS: dict[Operation, str] = {"trim": "Trim", "clear": "Clear", "in": "Fade in", "out": "Fade out"}
ADDED = {"amplitude": "Add a point", "transients": "Add a transient", "frequency": "Add a frequency point"}
LABELS = {
    line: "Amplitude" if line in ("amplitude", "transients") else "Frequency, Hz" for line in (*LINES, TONE)
}
KEYS = (
    "Tab reaches the cursor and the points of each lane. On a point: arrows move it (finer with Shift), Page Up and "
    "Page Down go to its neighbours, Enter adds one after it, Delete removes it. On the cursor: arrows move it, with "
    "Shift they select time. Ctrl+Z undoes, Ctrl+Shift+Z redoes."
)


class Timeline:
    """The card of the timeline; ``changed`` saves the effect, ``sound`` returns the address of its sound.

    ``follow`` takes over what other tabs have made of it, whenever the script begins or the window gets the focus.
    """

    def __init__(
        self,
        editor: Editor,
        changed: Callable[[], None],
        sound: Callable[[], str],
        follow: Callable[[], None],
    ) -> None:
        self.editor, self.changed, self.sound, self.follow = editor, changed, sound, follow
        self._number = 0
        self._card()
        ui.on("edit", self._event)

    def _card(self) -> None:
        with kit.card(label="Timeline", classes="w-full edit-card"):
            with ui.element("div").classes("edit-tools"):
                self._play = ui.element("button").classes("player")
                self._play.props('type="button" aria-pressed="false"')
                self._undo = ui.button("Undo", icon="undo", on_click=lambda: self.do(self.editor.undo))
                self._redo = ui.button("Redo", icon="redo", on_click=lambda: self.do(self.editor.redo))
                for button in (self._undo, self._redo):
                    button.props("flat dense")
                tool = ui.toggle(TOOLS, value="select").props('dense aria-label="Tool"')
                tool.on_value_change(lambda: self._script("tool", tool.value))
                snap = ui.select(SNAPS, value=0.01, label="Snap").classes("edit-snap")
                snap.on_value_change(lambda: self._script("snap", snap.value))
                for label, (icon, by) in ZOOMS.items():
                    ui.button(icon=icon, on_click=partial(self._script, "zoom", by)).props(
                        f'flat dense aria-label="{kit.attribute(label)}"'
                    )
            self._sound_status = ui.element("span").classes("small quiet")
            ui.element("div").props('id="timeline" role="region" aria-label="Tracks" data-tool="select"')
            self._operations()
            self._details()
            with ui.expansion("Keys").classes("w-full"):
                kit.hint(KEYS)

    def _operations(self) -> None:
        with ui.element("div").classes("edit-tools"):
            self._from = ui.number("From, s", min=0, step=0.01).props("stack-label placeholder=start")
            self._to = ui.number("To, s", min=0, step=0.01).props("stack-label placeholder=end")
            for field in (self._from, self._to):
                field.on("change", self._set_range)
            for name, label in OPERATIONS.items():
                self._button(label, partial(self.editor.operate, name))
            self._button("Repeat", self._repeat)
            self._times = ui.number("Times", value=2, min=1, max=100, step=1)
            self._gap = ui.number("Gap, s", value=0.1, min=0, step=0.01)
        with ui.element("div").classes("edit-tools"):
            self._button("Add a track", self._add_track)
            for line, label in ADDED.items():
                ui.button(label, on_click=partial(self._script, "add", line)).props("flat dense")
            self._button("Merge the tracks", self.editor.merge)

    def _button(self, label: str, operation: Callable[[], None]) -> None:
        ui.button(label, on_click=lambda: self.do(operation)).props("outline dense")

    @ui.refreshable_method
    def _details(self) -> None:
        """Draw the selected point's numbers."""
        item, tracks = self.editor.item, self.editor.effect.tracks
        if item is None:
            return
        line, index = item
        track = tracks[self.editor.track]
        if line in ("transients", TONE):
            transient = track.transients[index]
            name, values = "Transient", {"transients": transient.amplitude, TONE: transient.frequency}
            time = transient.time
        else:
            point = getattr(track, line)[index]
            name, values, time = f"{line.capitalize()} point", {line: point.value}, point.time

        def move(line: str, time: Any, value: Any) -> None:
            event = {"track": self.editor.track, "line": line, "index": index, "time": time, "value": value}
            self.do(lambda: self.editor.handle({"do": "move", **event}))

        with ui.element("div").classes("edit-tools").props('role="group"') as tools:
            tools.props["aria-label"] = f"{name} {index + 1}"
            ui.label(f"{name} {index + 1}").classes("small")
            time_field = ui.number("Time, s", value=time, min=0, step=0.01)
            first = next(iter(values))
            time_field.on("change", lambda: move(first, time_field.value, values[first]))
            for own, value in values.items():
                field = ui.number(LABELS[own], value=round(value, 4), min=0)
                field.on("change", lambda own=own, field=field: move(own, time, field.value))

    def _add_track(self) -> None:
        self.editor.insert((Track(title=f"Track {len(self.editor.effect.tracks) + 1}"),))

    def _repeat(self) -> None:
        times, gap = self._times.value, self._gap.value
        if times is None or times != int(times):
            raise ParameterError(f"Times must be a whole number from 1 to 100, got {times}")
        self.editor.operate("repeat", times=int(times), gap=float(gap or 0))

    def _set_range(self) -> None:
        start, end = self._from.value, self._to.value
        if start is not None and end is not None:
            self.do(lambda: self.editor.handle({"do": "range", "start": start, "end": end}))
        elif start is None and end is None:
            self.editor.range = None
            self.draw()

    def do(self, operation: Callable[[], None]) -> None:
        """Apply an operation and draw; after an error, too, since the script may be ahead."""
        before = self.editor.effect
        try:
            operation()
            if self.editor.effect != before:
                self.changed()
        finally:
            self.draw()

    def _event(self, event: events.GenericEventArguments) -> None:
        values = event.args if isinstance(event.args, dict) else event.args[0]
        number = values.get("number")
        self._number = number if isinstance(number, int) else self._number
        others: dict[str, Callable[[], None]] = {
            "ready": self.follow,
            "undo": self.editor.undo,
            "redo": self.editor.redo,
        }
        self.do(others.get(str(values.get("do")), lambda: self.editor.handle(values)))

    def draw(self) -> None:
        """Send the effect to the script, and show what is selected."""
        editor = self.editor
        address, label = self.sound(), f"Play {kit.attribute(editor.effect.title)}"
        self._play.props.update({"data-player-url": address, "aria-label": label})
        self._sound_status.props.update({"data-player-status": address, "data-unit": "1"})
        self._undo.set_enabled(editor.undoable)
        self._redo.set_enabled(editor.redoable)
        start, end = editor.range or (None, None)
        self._from.set_value(start)
        self._to.set_value(end)
        self._details.refresh()
        tracks = [
            {**track.model_dump(mode="json"), "start": track.start, "end": track.end}
            for track in editor.effect.tracks
        ]
        shown = {
            "number": self._number,
            "effect": {"tracks": tracks, "seconds": editor.effect.seconds},
            "track": editor.track,
            "item": editor.item,
            "range": editor.range,
            "cursor": editor.cursor,
            "sound": address,
        }
        ui.run_javascript(f"window.tactogramEdit?.draw({json.dumps(shown)})")

    def _script(self, name: str, value: Any) -> None:
        ui.run_javascript(f"window.tactogramEdit.{name}({json.dumps(value)})")
