"""Cards of a tab of the page Send: a form for what is selected, and its result."""

from __future__ import annotations

from nicegui import ui

from tactogram.errors import ParameterError
from tactogram.signal import Signal
from tactogram_studio import kit
from tactogram_studio.workspace.sent import SendResult, SendService
from tactogram_studio.workspace.shelf import SelectedSignal


class RequestCards:
    """A form and the newest result of the selected signal, side by side.

    ``state`` holds the tab's settings, whose names begin with ``key``. Subclasses draw a form with `signal_fields`,
    and a result.
    """

    key: str
    kind: type
    """Of requests."""

    def __init__(self, service: SendService, state: kit.TabSettings) -> None:
        self.service, self.state = service, state
        self.fields = kit.Form(state)
        self.result: SendResult | None = None
        self._selected: SelectedSignal | None = None
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

    def show(self, result: SendResult) -> None:
        """Show a new result, unless another signal has been selected meanwhile."""
        if self._selected is not None and result.request.of == self._selected.id:
            self.result = result
            self.draw_result.refresh()

    @ui.refreshable_method
    def signal_fields(self) -> None:
        """Draw the fields that the signal needs: for several axes, and the finger's speed over displacement."""
        signal = self._signal
        if signal is not None and len(signal.axes) > 1:
            self.fields.choice(f"{self.key}_axes", self.axis_options(signal.axes), "Axes", "")
        if signal is not None and signal.domain != "time":
            self.fields.number(f"{self.key}_speed", "Finger speed, mm/s", 100.0)

    @property
    def selected(self) -> SelectedSignal:
        """The signal to send; `ParameterError` if there is none."""
        if self._selected is None:
            raise ParameterError("Choose a signal to send first.")
        return self._selected

    def set_signal(
        self, selected: SelectedSignal | None, signal: Signal | None, result: SendResult | None
    ) -> None:
        """Show the fields that another signal needs, and its newest result."""
        self._selected, self._signal, self.result = selected, signal, result
        self.signal_fields.refresh()
        self.draw_result.refresh()

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
