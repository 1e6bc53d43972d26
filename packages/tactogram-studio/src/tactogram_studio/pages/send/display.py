"""Tab for displays: display, level, fit report and drive."""

from __future__ import annotations

from collections.abc import Callable
from functools import lru_cache
from typing import Any

from nicegui import ui

from tactogram.errors import TactogramError
from tactogram.rendering import display_family, open_display, read_calibrations
from tactogram.signal import Signal
from tactogram.workflows import levels_of, list_displays
from tactogram_studio.layout import busy, heading, hint, in_background, report_errors
from tactogram_studio.pages.send.cards import SignalFields, command_line, form_and_result, last_result
from tactogram_studio.pages.send.device import DeviceCard
from tactogram_studio.pages.send.sending import DriveRequest, SendService
from tactogram_studio.pages.send.sources import SelectedSignal
from tactogram_studio.pages.send.speaker import Speaker
from tactogram_studio.pages.send.wording import LEVEL_VALUES, LEVELS, level_text, warnings_of


@lru_cache(maxsize=64)
def _levels(name: str) -> tuple[str, ...]:
    return tuple(levels_of(open_display(name)))


def _axis_options(axes: tuple[str, ...]) -> dict[str, str]:
    """Return the ways to map several axes to those of a display."""
    return {
        "": "the display's default",
        "dft321": "combined into one with the same energy (DFT321)",
        "mean": "their mean",
        "channels": "one axis per channel",
        **{axis: f"axis {axis} only" for axis in axes},
    }


class DisplayCards:
    """Cards of the tab.

    ``state`` holds the browser's settings and ids of results; ``selected`` returns the signal to send, or raises.
    """

    def __init__(
        self,
        service: SendService,
        speaker: Speaker,
        state: dict[str, Any],
        selected: Callable[[], SelectedSignal],
    ) -> None:
        self.service, self.state, self.selected = service, state, selected
        self.result = last_result(service, state, "drive", DriveRequest)
        self._device = DeviceCard(service, speaker, state)
        form_and_result(self._form, self._result)

    def set_signal(self, signal: Signal) -> None:
        """Show the fields that this signal needs."""
        self._fields.set_signal(signal)

    def _form(self) -> None:
        with ui.element("section").classes("card w-full").props('aria-label="Display"'):
            heading("Display")
            names = {name: f"{name}: {facts['title']}" for name, facts in list_displays().items()}
            names |= {name: f"{name}: {title}" for name, title in self.service.displays().items()}
            last = str(self.state.get("display", "voice-coil"))
            self._display = ui.select(
                names,
                label="Display",
                value=last if last in names else "voice-coil",
                on_change=self._display_fields.refresh,
            ).classes("w-full")
            self._display_fields()
            self._fields = SignalFields(_axis_options, speed_mm_s=self.state.get("speed", 100.0))
            with ui.expansion("Change values of the display").classes("w-full"):
                self._changes = ui.textarea(
                    "KEY=VALUE, one per line", value=self.state.get("changes", "")
                ).classes("w-full")
            self._button = ui.button("Fit to the display", icon="tune", on_click=self._fit)

    @ui.refreshable_method
    def _display_fields(self) -> None:
        name = str(self._display.value)
        self._person: ui.select | None = None
        try:
            display = open_display(self.service.display_file(name))
            kinds = _levels(self.service.display_file(name))
        except TactogramError as error:
            ui.label(str(error)).classes("text-negative")
            return
        band = "" if display.band is None else f", {display.band[0]:g} to {display.band[1]:g} Hz"
        unit = "parts of full scale" if display.unit == "1" else display.unit
        hint(f"{display.rate:g} Hz, {', '.join(display.channels)}, in {unit}{band}")
        ui.label("Level").classes("font-bold mt-2")
        last = str(self.state.get("level", "peak"))
        self._level = ui.radio(
            {kind: LEVELS[kind] for kind in kinds},
            value=last if last in kinds else ("peak" if "peak" in kinds else kinds[0]),
            on_change=self._level_value.refresh,
        ).props('aria-label="Level"')
        self._level_value()
        if display_family(display.family).calibrated:
            options = {"": "none: the display's assumed constants", **self.service.calibrations()}
            self._calibration = ui.select(options, label="Calibration of a person's finger", value="")
            self._calibration.classes("w-full").on_value_change(self._people.refresh)
            self._people()

    @ui.refreshable_method
    def _level_value(self) -> None:
        kind = str(self._level.value)
        self._value: ui.number | None = None
        if kind in LEVEL_VALUES:
            label, default = LEVEL_VALUES[kind]
            self._value = ui.number(label, value=self.state.get(f"value_{kind}", default)).classes("w-full")

    @ui.refreshable_method
    def _people(self) -> None:
        self._person = None
        if self._calibration.value:
            path = self.service.workspace.inside(str(self._calibration.value))
            people = [calibration.person for calibration in read_calibrations(path)]
            self._person = ui.select(people, label="Person", value=people[0]).classes("w-full")

    def _request(self) -> DriveRequest:
        value = self._value.value if self._value is not None else None
        return DriveRequest(
            self.selected().id,
            str(self._display.value),
            level_text(str(self._level.value), value),
            self._fields.axis_option,
            self._fields.speed_mm_s,
            str(self._calibration.value) if self._person is not None else "",
            str(self._person.value) if self._person is not None else "",
            tuple(line.strip() for line in (self._changes.value or "").splitlines() if line.strip()),
        )

    @report_errors
    async def _fit(self) -> None:
        request = self._request()
        with busy("fitting the signal to the display", button=self._button):
            self.result = await in_background(self.service.drive, request)
        kind = str(self._level.value)
        self.state.update(
            drive=self.result.id,
            display=request.display,
            level=kind,
            changes=self._changes.value,
            speed=request.speed_mm_s or self.state.get("speed", 100.0),
        )
        if self._value is not None:
            self.state[f"value_{kind}"] = self._value.value
        self._result.refresh()

    @ui.refreshable_method
    def _result(self) -> None:
        result = self.result
        with ui.element("section").classes("card w-full").props('aria-label="Fit report"'):
            if result is None or not isinstance(result.request, DriveRequest):
                ui.label("The fit report will appear here.").classes("quiet")
                return
            display = open_display(self.service.display_file(result.request.display))
            report, files = result.facts["report"], f"/send/result/{result.id}"
            with ui.row().classes("items-center gap-2"):
                heading(f"{result.title} on {display.title}".replace("m/s^2", "m/s²"))
                if result.facts.get("simulated"):
                    ui.label("simulated signal").classes("simulated")
            with ui.element("div").classes("warned").props('role="note" aria-label="Safety"'):
                for warning in warnings_of(display, report):
                    ui.label(warning)
            ui.html(
                f'<img src="{files}/drive.report.png" alt="Signal, drive with its limits, and output; the text below '
                'says the same" width="100%">',
                sanitize=False,
            ).classes("w-full")
            for name, title in (("scaled", "Scaled"), ("clipped", "Clipped"), ("unreachable", "Unreachable")):
                ui.label(title).classes("font-bold")
                with ui.element("ul").classes("sentences"):
                    for sentence in report[name] or ["nothing"]:
                        ui.element("li")._text = sentence
            with ui.expansion("Full report as text").classes("w-full"):
                ui.label(str(result.facts["text"])).classes("code")
            with ui.row().classes("gap-2 items-center"):
                for suffix in ("wav", "csv", "npz"):
                    ui.link(f"Drive as {suffix.upper()}", f"{files}/drive.{suffix}").props("download")
                ui.link("Report (JSON)", f"{files}/drive.report.json").props("download")
            command_line(result.facts["commands"])
        self._device.draw(result, display.unit)
