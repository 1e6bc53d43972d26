"""Cards of the page Send: a form beside its result."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import Any

from nicegui import ui

from tactogram.errors import ParameterError, TactogramError
from tactogram.signal import Signal
from tactogram.studio.pages.send.sending import SelectedSignal, SendResult, SendService


def last_sent(sending: SendService, kept: dict[str, Any], name: str, kind: type) -> SendResult | None:
    """Return the result that stands under ``name`` in what a browser keeps, if it is one of such an order."""
    if not kept.get(name):
        return None
    try:
        sent = sending.get(str(kept[name]))
    except TactogramError:
        kept.pop(name)
        return None
    return sent if isinstance(sent.order, kind) else None


def form_beside_result(form: Callable[[], None], result: Callable[[], None]) -> None:
    """Draw a form, and beside it what came of it."""
    with ui.element("div").classes("grid-2 mt-4"):
        with ui.column().classes("items-stretch gap-4"):
            form()
        with ui.column().classes("items-stretch gap-4").props('aria-live="polite"'):
            result()


def there(chosen: SelectedSignal | None) -> SelectedSignal:
    """Return what is to be sent.

    Raises
    ------
    ParameterError
        If nothing was chosen.
    """
    if chosen is None:
        raise ParameterError("Choose what to send first.")
    return chosen


class SignalFields:
    """Fields of a signal to send: its axes and, over displacement, the finger's speed.

    Parameters
    ----------
    ways : callable
        Of the names of several axes: what can be chosen, by value; the first is the usual one.
    speed_mm_s : float
        That is asked for first.
    """

    def __init__(
        self, ways: Callable[[tuple[str, ...]], Mapping[str, str]], *, speed_mm_s: float = 100.0
    ) -> None:
        self._ways = ways
        self._axes: tuple[str, ...] = ()
        self._over_time = True
        self._how = ""
        self._speed: float | None = speed_mm_s
        self.draw()

    @ui.refreshable_method
    def draw(self) -> None:
        """Draw the fields that the signal needs."""
        if len(self._axes) > 1:
            ways = dict(self._ways(self._axes))
            self._how = self._how if self._how in ways else next(iter(ways))
            ui.select(ways, label="Axes").classes("w-full").bind_value(self, "_how")
        if not self._over_time:
            speed = ui.number("Speed of the finger, mm/s", min=0).classes("w-full")
            speed.bind_value(self, "_speed")

    def signal_chosen(self, signal: Signal) -> None:
        """Ask for what this signal needs."""
        self._axes, self._over_time = signal.axes, signal.domain == "time"
        self.draw.refresh()

    @property
    def how(self) -> str:
        """What was chosen of the ways; empty where there is one axis."""
        return self._how if len(self._axes) > 1 else ""

    @property
    def speed_mm_s(self) -> float | None:
        """The finger's speed; None of a signal over time."""
        return None if self._over_time else float(self._speed or 0)


def command_line(commands: list[str]) -> None:
    """Show how the command line does the same."""
    with ui.expansion("The same on the command line").classes("w-full"):
        for command in commands:
            ui.label(command).classes("told")
