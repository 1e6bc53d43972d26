"""A signal to a display: what for, how strong, the report as a picture and in words, and the drive."""

from __future__ import annotations

from collections.abc import Callable
from functools import lru_cache
from typing import Any

from nicegui import ui

from tactogram.errors import TactogramError
from tactogram.rendering.displays.catalogue import open_display
from tactogram.rendering.displays.families import display_family
from tactogram.rendering.drive.friction_calibration import read_calibrations
from tactogram.signal import Signal
from tactogram.studio.layout import busy, in_background, report_errors
from tactogram.studio.pages.send.cards import SignalFields, command_line, form_beside_result, last_sent, there
from tactogram.studio.pages.send.device import DeviceCard
from tactogram.studio.pages.send.sending import DriveRequest, SelectedSignal, SendService
from tactogram.studio.pages.send.speaker import Speaker
from tactogram.studio.pages.send.wording import LEVELS, NEEDS, level_text, warnings_of
from tactogram.workflows.rendering.render import levels_of, list_displays


@lru_cache(maxsize=64)
def _levels(name: str) -> tuple[str, ...]:
    return tuple(levels_of(open_display(name)))


def _ways(axes: tuple[str, ...]) -> dict[str, str]:
    """Return how several axes become those of a display."""
    return {
        "": "as the display says",
        "dft321": "their energy as one (DFT321)",
        "mean": "their mean",
        "channels": "an axis per channel",
        **{axis: f"axis {axis} alone" for axis in axes},
    }


class DisplayCards:
    """The cards of the tab.

    Parameters
    ----------
    sending : Sending
    speaker : Speaker
    kept : dict
        Of the browser: what was chosen, and the last result.
    chosen : callable
        Returns what is to be sent.
    """

    def __init__(
        self,
        sending: SendService,
        speaker: Speaker,
        kept: dict[str, Any],
        chosen: Callable[[], SelectedSignal | None],
    ) -> None:
        self.sending, self.kept, self.chosen = sending, kept, chosen
        self.sent = last_sent(sending, kept, "drive", DriveRequest)
        self._device = DeviceCard(sending, speaker, kept)
        form_beside_result(self._form, self._result)

    def signal_chosen(self, signal: Signal) -> None:
        """Ask for what this signal needs."""
        self._signal.signal_chosen(signal)

    # -- what is asked for -------------------------------------------------------------------------------

    def _form(self) -> None:
        with ui.element("section").classes("card w-full").props('aria-label="Display"'):
            ui.label("Display").classes("h2")
            names = {name: f"{name}: {facts['title']}" for name, facts in list_displays().items()}
            names |= {name: f"{name}: {title}" for name, title in self.sending.displays().items()}
            held = str(self.kept.get("display", "voice-coil"))
            self._display = ui.select(
                names,
                label="Display",
                value=held if held in names else "voice-coil",
                on_change=self._display_chosen,
            ).classes("w-full")
            self._display_fields()
            self._signal = SignalFields(_ways, speed_mm_s=self.kept.get("speed", 100.0))
            with ui.expansion("Change values of the display").classes("w-full"):
                self._changes = ui.textarea(
                    "KEY=VALUE, one a line", value=self.kept.get("changes", "")
                ).classes("w-full")
            self._button = ui.button("Fit to the display", icon="tune", on_click=self._fit)

    def _display_chosen(self) -> None:
        self._display_fields.refresh()

    def _level_chosen(self) -> None:
        self._level_value.refresh()

    def _calibration_chosen(self) -> None:
        self._people.refresh()

    @ui.refreshable_method
    def _display_fields(self) -> None:
        name = str(self._display.value)
        self._person: ui.select | None = None
        try:
            display = open_display(self.sending.display_file(name))
            kinds = _levels(self.sending.display_file(name))
        except TactogramError as error:
            ui.label(str(error)).classes("text-negative")
            return
        band = "" if display.band is None else f", {display.band[0]:g} to {display.band[1]:g} Hz"
        unit = "parts of full scale" if display.unit == "1" else display.unit
        ui.label(f"{display.rate:g} Hz, {', '.join(display.channels)}, in {unit}{band}").classes(
            "small quiet"
        )
        ui.label("How strong").classes("font-bold mt-2")
        held = str(self.kept.get("level", "peak"))
        self._level = ui.radio(
            {kind: LEVELS[kind] for kind in kinds},
            value=held if held in kinds else ("peak" if "peak" in kinds else kinds[0]),
            on_change=self._level_chosen,
        ).props('aria-label="Level: how strong"')
        self._level_value()
        if display_family(display.family).calibrated:
            self._calibration_fields()

    @ui.refreshable_method
    def _level_value(self) -> None:
        kind = str(self._level.value)
        self._value: ui.number | None = None
        if kind in NEEDS:
            label, usual = NEEDS[kind]
            self._value = ui.number(label, value=self.kept.get(f"value_{kind}", usual)).classes("w-full")

    def _calibration_fields(self) -> None:
        found = {"": "none: the display's assumed constants", **self.sending.calibrations()}
        self._calibration = ui.select(found, label="Calibration of a person's finger", value="").classes(
            "w-full"
        )
        self._calibration.on_value_change(self._calibration_chosen)
        self._people()

    @ui.refreshable_method
    def _people(self) -> None:
        self._person = None
        if self._calibration.value:
            path = self.sending.workspace.inside(str(self._calibration.value))
            people = [found.person for found in read_calibrations(path)]
            self._person = ui.select(people, label="Whose", value=people[0]).classes("w-full")

    def _order(self) -> DriveRequest:
        chosen = there(self.chosen())
        kind, value = str(self._level.value), self._value.value if self._value is not None else None
        calibrated = self._person is not None
        return DriveRequest(
            chosen.of,
            str(self._display.value),
            level_text(kind, value),
            self._signal.how,
            self._signal.speed_mm_s,
            str(self._calibration.value) if calibrated else "",
            str(self._person.value) if self._person is not None else "",
            tuple(line.strip() for line in (self._changes.value or "").splitlines() if line.strip()),
        )

    @report_errors
    async def _fit(self) -> None:
        order = self._order()
        with busy("fitting the signal to the display", button=self._button):
            sent = await in_background(self.sending.drive, order)
        self.sent = sent
        kind = str(self._level.value)
        self.kept.update(
            drive=sent.id,
            display=order.display,
            level=kind,
            changes=self._changes.value,
            speed=order.speed_mm_s or self.kept.get("speed", 100.0),
        )
        if self._value is not None:
            self.kept[f"value_{kind}"] = self._value.value
        self._result.refresh()

    # -- what came of it ---------------------------------------------------------------------------------

    @ui.refreshable_method
    def _result(self) -> None:
        sent = self.sent
        with ui.element("section").classes("card w-full").props('aria-label="Fit report"'):
            if sent is None or not isinstance(sent.order, DriveRequest):
                ui.label("The report of the fit comes here.").classes("quiet")
                return
            display = open_display(self.sending.display_file(sent.order.display))
            report = sent.found["report"]
            with ui.row().classes("items-center gap-2"):
                ui.label(f"{sent.title} on {display.title}".replace("m/s^2", "m/s²")).classes("h2")
                if sent.found.get("simulated"):
                    ui.label("simulated signal").classes("simulated")
            with ui.element("div").classes("warned").props('role="note" aria-label="Safety"'):
                for warning in warnings_of(display, report):
                    ui.label(warning)
            text = str(sent.found["text"])
            ui.html(
                f'<img src="/send/result/{sent.id}/drive.report.png" alt="Signal, drive within its limits, and what '
                f'comes out; the same in words below" width="100%">',
                sanitize=False,
            ).classes("w-full")
            for name, heading in (
                ("scaled", "Scaled"),
                ("clipped", "Clipped"),
                ("unreachable", "Cannot be reached"),
            ):
                ui.label(heading).classes("font-bold")
                with ui.element("ul").classes("said"):
                    for sentence in report[name] or ["nothing"]:
                        ui.element("li")._text = sentence
            with ui.expansion("The whole report as text").classes("w-full"):
                ui.label(text).classes("told")
            with ui.row().classes("gap-2 items-center"):
                for suffix in ("wav", "csv", "npz"):
                    ui.link(f"Drive as {suffix.upper()}", f"/send/result/{sent.id}/drive.{suffix}").props(
                        "download"
                    )
                ui.link("Report (JSON)", f"/send/result/{sent.id}/drive.report.json").props("download")
            command_line(sent.found["commands"])
        self._device.draw(sent, display.unit)
