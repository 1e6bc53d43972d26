"""Parts shared by both tabs of the page Send."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import Any

from nicegui import ui

from tactogram.errors import TactogramError
from tactogram.signal import Signal
from tactogram_studio.pages.send.sending import SendResult, SendService


def last_result(service: SendService, state: dict[str, Any], name: str, kind: type) -> SendResult | None:
    """Return the result whose id the browser's ``state`` holds under ``name``, if its request is of ``kind``."""
    if not state.get(name):
        return None
    try:
        result = service.get(str(state[name]))
    except TactogramError:
        state.pop(name)
        return None
    return result if isinstance(result.request, kind) else None


def form_and_result(form: Callable[[], None], result: Callable[[], None]) -> None:
    """Draw a form and its result side by side."""
    with ui.element("div").classes("grid-2 mt-4"):
        with ui.column().classes("items-stretch gap-4"):
            form()
        with ui.column().classes("items-stretch gap-4").props('aria-live="polite"'):
            result()


class SignalFields:
    """Fields that depend on the signal: its axes and, over displacement, the finger's speed.

    ``axis_options`` returns the options for several axes, by value; the first is the default.
    """

    def __init__(
        self, axis_options: Callable[[tuple[str, ...]], Mapping[str, str]], *, speed_mm_s: float = 100.0
    ) -> None:
        self._axis_options = axis_options
        self._axes: tuple[str, ...] = ()
        self._over_time = True
        self._axis_option = ""
        self._speed: float | None = speed_mm_s
        self.draw()

    @ui.refreshable_method
    def draw(self) -> None:
        """Draw the fields that the signal needs."""
        if len(self._axes) > 1:
            options = dict(self._axis_options(self._axes))
            self._axis_option = self._axis_option if self._axis_option in options else next(iter(options))
            ui.select(options, label="Axes").classes("w-full").bind_value(self, "_axis_option")
        if not self._over_time:
            ui.number("Finger speed, mm/s", min=0).classes("w-full").bind_value(self, "_speed")

    def set_signal(self, signal: Signal) -> None:
        """Show the fields that this signal needs."""
        self._axes, self._over_time = signal.axes, signal.domain == "time"
        self.draw.refresh()

    @property
    def axis_option(self) -> str:
        """Selected option for the axes; "" for a single axis."""
        return self._axis_option if len(self._axes) > 1 else ""

    @property
    def speed_mm_s(self) -> float | None:
        """Finger speed; None for a signal over time."""
        return None if self._over_time else float(self._speed or 0)


def command_line(commands: list[str]) -> None:
    """Show the equivalent commands."""
    with ui.expansion("Equivalent command").classes("w-full"):
        for command in commands:
            ui.label(command).classes("code")
