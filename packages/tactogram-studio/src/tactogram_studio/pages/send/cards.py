"""Cards of a tab of the page Send: a form for what is selected, and its result."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

from nicegui import ui

from tactogram.errors import TactogramError
from tactogram.signal import Signal
from tactogram_studio import kit
from tactogram_studio.workspace.sent import SendResult, SendService
from tactogram_studio.workspace.shelf import SelectedSignal


class RequestCards:
    """A form and its last result, side by side.

    ``state`` holds the browser's settings, and the id of the last result under the name ``key``; ``selected`` returns
    the signal to send, or raises. Subclasses draw a form with `signal_fields`, and a result.
    """

    key: str
    kind: type
    """Of requests."""

    def __init__(
        self, service: SendService, state: dict[str, Any], selected: Callable[[], SelectedSignal]
    ) -> None:
        self.service, self.state, self.selected = service, state, selected
        self.fields = kit.Form(state)
        self.result = self._last_result()
        self._signal: Signal | None = None
        with ui.element("div").classes("grid-2 mt-4 w-full"):
            with kit.column():
                self.draw_form()
            with kit.column(live=True):
                self.draw_result()

    def axis_options(self, axes: tuple[str, ...]) -> dict[str, str]:
        """Return what can be done with several axes, by value; the first is the default."""
        raise NotImplementedError

    def draw_form(self) -> None:
        """Draw the form."""
        raise NotImplementedError

    def draw_cards(self) -> None:
        """Draw the cards of the result."""
        raise NotImplementedError

    @ui.refreshable_method
    def draw_result(self) -> None:
        """Draw the result."""
        self.draw_cards()

    def _last_result(self) -> SendResult | None:
        try:
            result = self.service.get(str(self.state.get(self.key)))
        except TactogramError:
            self.state.pop(self.key, None)
            return None
        return result if isinstance(result.request, self.kind) else None

    def show(self, result: SendResult) -> None:
        """Show another result."""
        self.result, self.state[self.key] = result, result.id
        self.draw_result.refresh()

    @ui.refreshable_method
    def signal_fields(self) -> None:
        """Draw the fields that the signal needs: for several axes, and the finger's speed over displacement."""
        signal = self._signal
        if signal is not None and len(signal.axes) > 1:
            self.fields.choice(f"{self.key}_axes", self.axis_options(signal.axes), "Axes", "")
        if signal is not None and signal.domain != "time":
            self.fields.number(f"{self.key}_speed", "Finger speed, mm/s", 100.0)

    def set_signal(self, signal: Signal) -> None:
        """Show the fields that this signal needs."""
        self._signal = signal
        self.signal_fields.refresh()

    @property
    def axis_option(self) -> str:
        """Selected option for the axes; "" for a single axis."""
        several = self._signal is not None and len(self._signal.axes) > 1
        return str(self.state.get(f"{self.key}_axes", "")) if several else ""

    @property
    def speed_mm_s(self) -> float | None:
        """Finger speed; None for a signal over time."""
        over_time = self._signal is None or self._signal.domain == "time"
        return None if over_time else float(self.state.get(f"{self.key}_speed") or 0)
