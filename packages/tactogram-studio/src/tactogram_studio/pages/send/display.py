"""Tab for displays: display, level, fit report and drive."""

from __future__ import annotations

import math
from collections.abc import Mapping
from functools import lru_cache
from typing import Any

from nicegui import ui

from tactogram.errors import TactogramError
from tactogram.rendering import Display, display_family, open_display, read_calibrations, shipped
from tactogram.signal import Signal, sensation_level_db
from tactogram.workflows import levels_of, list_displays
from tactogram_studio import kit
from tactogram_studio.pages.send.cards import RequestCards
from tactogram_studio.pages.send.device import DeviceCard
from tactogram_studio.signals.traits import strongest_db, unfelt_text
from tactogram_studio.tasks.speaker import Speaker
from tactogram_studio.workspace.sent import LEVEL_VALUES, LEVELS, DriveRequest, SendService, level_text


@lru_cache(maxsize=64)
def _levels(name: str) -> tuple[str, ...]:
    return tuple(levels_of(open_display(name)))


class DisplayCards(RequestCards):
    """Cards of the tab."""

    key, kind = "drive", DriveRequest

    def __init__(self, service: SendService, speaker: Speaker, state: kit.TabSettings) -> None:
        self._device = DeviceCard(service, speaker, state)
        super().__init__(service, state)

    def axis_options(self, axes: tuple[str, ...]) -> dict[str, str]:
        """Return the ways to map several axes to those of a display."""
        return {
            "": "the display's default",
            "dft321": "combined into one with the same energy (DFT321)",
            "mean": "their mean",
            "channels": "one axis per channel",
            **{axis: f"axis {axis} only" for axis in axes},
        }

    def draw_form(self) -> None:
        """Draw the form."""
        with kit.card("Display"):
            names = {name: f"{name}: {facts['title']}" for name, facts in list_displays().items()}
            names |= {name: f"{name}: {title}" for name, title in self.service.displays().items()}
            display = self.fields.choice("display", names, "Display", "voice-coil")
            display.on_value_change(self._display_fields.refresh)
            self._display_fields()
            self.signal_fields()
            with ui.expansion("Change values of the display").classes("w-full"):
                changes = ui.textarea("KEY=VALUE, one per line").bind_value(self.state, "changes")
                changes.classes("w-full")
            self._button = ui.button("Fit to the display", icon="tune", on_click=self._fit)

    @ui.refreshable_method
    def _display_fields(self) -> None:
        file = self.service.display_file(self.state["display"])
        try:
            display, kinds = open_display(file), _levels(file)
        except TactogramError as error:
            kit.alert(str(error))
            return
        band = "" if display.band is None else f", {display.band[0]:g} to {display.band[1]:g} Hz"
        unit = "parts of full scale" if display.unit == "1" else display.unit
        kit.hint(f"{display.rate:g} Hz, {', '.join(display.channels)}, in {unit}{band}")
        ui.label("Level").classes("font-bold mt-2")
        if self.state.get("level") not in kinds:
            self.state["level"] = "peak" if "peak" in kinds else kinds[0]
        titles = {kind: kind.capitalize() for kind in kinds}
        level = ui.radio(titles, on_change=self._level_value.refresh)
        level.bind_value(self.state, "level").props('inline dense aria-label="Level"')
        self._level_value()
        self.state.update(calibration="", person="")
        if display_family(display.family).calibrated:
            options = {"": "none: the display's assumed constants", **self.service.calibrations()}
            calibration = self.fields.choice("calibration", options, "Calibration of a person's finger", "")
            calibration.on_value_change(self._people.refresh)
            self._people()

    @ui.refreshable_method
    def _level_value(self) -> None:
        kit.hint(LEVELS[kind := self.state["level"]])
        if kind in LEVEL_VALUES:
            self.fields.number(f"value_{kind}", *LEVEL_VALUES[kind])

    @ui.refreshable_method
    def _people(self) -> None:
        if self.state["calibration"]:
            path = self.service.workspace.inside(self.state["calibration"])
            self.fields.choice("person", [entry.person for entry in read_calibrations(path)], "Person")
        else:
            self.state["person"] = ""

    def _request(self) -> DriveRequest:
        state, level = self.state, self.state["level"]
        return DriveRequest(
            self.selected.id,
            state["display"],
            level_text(level, state.get(f"value_{level}")),
            self.axis_option,
            self.speed_mm_s,
            state["calibration"],
            state["person"],
            tuple(line.strip() for line in (state.get("changes") or "").splitlines() if line.strip()),
        )

    async def _fit(self) -> None:
        with kit.busy("fitting the signal to the display", button=self._button):
            self.show(await kit.in_background(self.service.drive, self._request()))

    def draw_cards(self) -> None:
        """Draw the fit report, and the card that plays the drive."""
        result = self.result
        if result is None or not isinstance(result.request, DriveRequest):
            with kit.card(label="Fit report"):
                ui.label("The fit report will appear here.").classes("quiet")
            self._device.draw_running()
            return
        with kit.card(label="Fit report"):
            display = open_display(self.service.display_file(result.request.display))
            report, files = result.facts["report"], f"/send/result/{result.id}"
            kit.title_row("Fit report", result.facts.get("simulated"), "simulated signal")
            kit.hint(f"{result.title} on {display.title}".replace("m/s^2", "m/s²"))
            with ui.element("div").classes("warned").props('role="note" aria-label="Safety"'):
                for warning in warnings_of(display, report):
                    ui.label(warning)
            level_db = output_db(report, self._signal)
            if level_db is not None and level_db < 0:
                kit.alert(unfelt_text(level_db, of="the output of this drive"))
            ui.html(
                f'<img class="drawn" src="{files}/drive.report.png" width="100%" alt="Signal, drive with its limits, '
                'and output; the text below says the same">',
                sanitize=False,
            ).classes("scrolled").props('tabindex="0"')
            for name, title in (("scaled", "Scaled"), ("clipped", "Clipped"), ("unreachable", "Unreachable")):
                ui.label(title).classes("font-bold")
                with ui.element("ul").classes("sentences"):
                    for sentence in report[name] or ["nothing"]:
                        ui.element("li")._text = sentence
            with ui.expansion("Full report as text").classes("w-full"):
                ui.label(str(result.facts["text"])).classes("code")
            with ui.row().classes("gap-2 items-center"):
                drive = report["drive"]
                kit.hint(f"For the actuator, in {drive['unit']} at {drive['rate']:,.6g} Hz:")
                for suffix in ("wav", "csv", "npz"):
                    ui.link(f"Drive as {suffix.upper()}", f"{files}/drive.{suffix}").props("download")
                ui.link("Report (JSON)", f"{files}/drive.report.json").props("download")
            kit.command_lines(result.facts["commands"])
        self._device.draw(result, display.unit, level_db)


def output_db(report: Mapping[str, Any], signal: Signal | None) -> float | None:
    """Return the sensation level of a drive's output at its strongest moment, dB; None where it is not known.

    The report has that of the whole; the strongest moment of the ``signal`` is as far above the whole.
    """
    if report["drive"]["rms"] == 0:
        return -math.inf
    levels = report["facts"].get("sensation_level_db")
    if levels is None:
        return None
    level: float = -math.inf if levels["rendered"] is None else levels["rendered"]
    if level < 0 and signal is not None and signal.domain == "time" and math.isfinite(level):
        level += max(0.0, strongest_db(signal) - sensation_level_db(signal))
    return level


def warnings_of(display: Display, report: Mapping[str, Any]) -> list[str]:
    """Return dangers to people or equipment, the worst first."""
    warnings = []
    if hazard := display_family(display.family).hazard:
        warnings.append(hazard.format(peak=report["drive"]["peak"]))
    elif display.unit == "V":
        warnings.append("The drive is in volts at the actuator: set the amplifier before anybody touches it.")
    if display.name in shipped():
        warnings.append(
            "This display's values were not measured on a device; yours may be stronger. Start weak."
        )
    if report["clipped"]:
        warnings.append("Part of the drive was clipped; see below.")
    return warnings
