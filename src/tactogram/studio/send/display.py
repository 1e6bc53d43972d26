"""A signal to a display: what for, how strong, the report as a picture and in words, the drive, and playing it."""

from __future__ import annotations

import shlex
from collections.abc import Callable
from functools import lru_cache
from typing import Any

from nicegui import ui

from tactogram.errors import ParameterError, TactogramError
from tactogram.jobs.playback import CAREFUL, NULL, outputs
from tactogram.jobs.render import levels_of, list_displays
from tactogram.rendering.catalogue import open_display
from tactogram.rendering.friction_calibration import read_calibrations
from tactogram.signal import Signal
from tactogram.signal.io import read_signal
from tactogram.studio.layout import busy, in_background, telling
from tactogram.studio.send.played_log import played_lately
from tactogram.studio.send.sending import Chosen, DriveOrder, Sending, Sent
from tactogram.studio.send.speaker import Speaker
from tactogram.studio.send.wording import LEVELS, NEEDS, level_text, warnings_of


@lru_cache(maxsize=64)
def _levels(name: str) -> tuple[str, ...]:
    return tuple(levels_of(open_display(name)))


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
        sending: Sending,
        speaker: Speaker,
        kept: dict[str, Any],
        chosen: Callable[[], Chosen | None],
    ) -> None:
        self.sending, self.speaker, self.kept, self.chosen = sending, speaker, kept, chosen
        self.sent: Sent | None = None
        self._outputs: list[dict[str, Any]] = []
        self._axes: tuple[str, ...] = ()
        self._over_time = True
        if kept.get("drive"):
            try:
                self.sent = sending.get(str(kept["drive"]))
            except TactogramError:
                kept.pop("drive")
        with ui.element("div").classes("grid-2 mt-4"):
            with ui.column().classes("items-stretch gap-4"):
                self._form()
            with ui.column().classes("items-stretch gap-4").props('aria-live="polite"'):
                self._result()

    def signal_chosen(self, signal: Signal) -> None:
        """Ask for what this signal needs."""
        self._axes, self._over_time = signal.axes, signal.domain == "time"
        self._signal_fields.refresh()

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
            self._signal_fields()
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
        held = str(self.kept.get("level", "peak"))
        self._level = ui.radio(
            {kind: LEVELS[kind] for kind in kinds},
            value=held if held in kinds else ("peak" if "peak" in kinds else kinds[0]),
            on_change=self._level_chosen,
        ).props('aria-label="Level: how strong"')
        self._level_value()
        if display.family == "electrovibration":
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

    @ui.refreshable_method
    def _signal_fields(self) -> None:
        ways = {"": "as the display says"}
        if len(self._axes) > 1:
            ways |= {
                "dft321": "their energy as one (DFT321)",
                "mean": "their mean",
                "channels": "an axis per channel",
            }
            ways |= {axis: f"axis {axis} alone" for axis in self._axes}
        self._how = ui.select(ways, label="Axes", value="").classes("w-full")
        self._how.set_visibility(len(self._axes) > 1)
        self._speed = ui.number("Speed of the finger, mm/s", value=self.kept.get("speed", 100.0)).classes(
            "w-full"
        )
        self._speed.set_visibility(not self._over_time)

    def _order(self) -> DriveOrder:
        chosen = self.chosen()
        if chosen is None:
            raise ParameterError("choose what to send first")
        kind, value = str(self._level.value), self._value.value if self._value is not None else None
        calibrated = self._person is not None
        return DriveOrder(
            chosen.of,
            str(self._display.value),
            level_text(kind, value),
            str(self._how.value or ""),
            None if self._over_time else float(self._speed.value or 0),
            str(self._calibration.value) if calibrated else "",
            str(self._person.value) if self._person is not None else "",
            tuple(line.strip() for line in (self._changes.value or "").splitlines() if line.strip()),
        )

    @telling
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
            speed=self._speed.value,
        )
        if self._value is not None:
            self.kept[f"value_{kind}"] = self._value.value
        self._result.refresh()

    # -- what came of it ---------------------------------------------------------------------------------

    @ui.refreshable_method
    def _result(self) -> None:
        sent = self.sent
        with ui.element("section").classes("card w-full").props('aria-label="Fit report"'):
            if sent is None or not isinstance(sent.order, DriveOrder):
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
        self._play_card(sent, display.unit)

    def _play_card(self, sent: Sent, unit: str) -> None:
        with ui.element("section").classes("card w-full").props('aria-label="Play on a device"'):
            ui.label("Play on a device").classes("h2")
            ui.label(
                "It begins at a quarter of the drive, with a fade; turn it up while it plays. Never stronger than the "
                "drive above."
            ).classes("small quiet")
            self._devices(unit)

    @ui.refreshable_method
    def _devices(self, unit: str) -> None:
        if not self._outputs:
            with ui.row().classes("items-center"):
                ui.spinner(size="sm")
                ui.label("looking for outputs").classes("quiet small")
            ui.timer(0.05, self._look, once=True)
            return
        there = {
            o["device"]: o["title"]
            for o in self._outputs
            if o["missing"] is None and not o["device"].startswith("digilent")
        }
        if there:
            held = self.kept.get("output", NULL)
            self._output = ui.select(
                there, label="Output", value=held if held in there else next(iter(there))
            ).classes("w-full")
            self._strength = ui.slider(min=0, max=1, step=0.01, value=CAREFUL).props(
                'label aria-label="Strength: share of the drive"'
            )
            self._strength.on_value_change(self._turned)
            ui.label().bind_text_from(
                self._strength, "value", lambda share: f"Strength: {100 * share:.0f} % of the drive"
            ).classes("small")
            with ui.row().classes("items-end gap-4"):
                self._loop = ui.number("Loop for, s (empty: once)", min=0).classes("w-64")
                self._full_scale = ui.number("V at the card's full scale", min=0).classes("w-64")
                self._full_scale.set_visibility(unit == "V")
            with ui.row().classes("items-center gap-2 mt-2"):
                self._play_button = ui.button("Play", icon="play_arrow", on_click=self._play)
                self._stop_button = ui.button("Stop", icon="stop", color="negative", on_click=self._stop)
                self._told = ui.label().props('role="status"')
            ui.timer(0.2, self._tell)
        for output in self._outputs:
            if output["missing"] is not None:
                ui.label(f"{output['title']}: {output['missing']}").classes("small quiet")
            elif output["device"].startswith("digilent"):
                # It plays out of its own buffer, which this page could not fade out.
                ui.label(f"{output['title']}: play the drive on it by the command below.").classes(
                    "small quiet"
                )
        if self.sent is not None:
            command_line(self._play_commands(self.sent))
        self._log()

    def _play_commands(self, sent: Sent) -> list[str]:
        display = sent.order.display if isinstance(sent.order, DriveOrder) else ""
        devices = [o["device"] for o in self._outputs if o["missing"] is None]
        return [
            shlex.join(
                ["tactogram", "play", "drive.npz", "--display", display, "--device", device]
                + ([] if device.startswith("digilent") else ["--strength", f"{CAREFUL:g}"])
            )
            for device in devices
        ]

    async def _look(self) -> None:
        self._outputs = await in_background(outputs)
        self._devices.refresh()

    @telling
    async def _play(self) -> None:
        sent = self.sent
        if sent is None or not isinstance(sent.order, DriveOrder):
            return
        device = str(self._output.value)
        drive = await in_background(read_signal, sent.folder / "drive.npz")
        display = open_display(self.sending.display_file(sent.order.display))
        self.speaker.play(
            drive,
            display,
            title=sent.title,
            device=device,
            strength=float(self._strength.value),
            loop_s=self._loop.value or None,
            full_scale=self._full_scale.value or None,
        )
        self.kept["output"] = device
        self._tell()

    @telling
    async def _stop(self) -> None:
        await in_background(self.speaker.stop)
        self._tell()

    def _turned(self) -> None:
        playing = self.speaker.playing
        if playing is not None and self.speaker.busy:
            playing.strength = float(self._strength.value)

    def _tell(self) -> None:
        playing, busy_now = self.speaker.playing, self.speaker.busy
        self._play_button.set_enabled(not busy_now)
        self._stop_button.set_enabled(busy_now)
        if playing is None:
            text = ""
        elif busy_now:
            text = f"{self.speaker.title}: {playing.seconds:.1f} of {playing.total_s:.1f} s"
        elif playing.state == "failed":
            text = str(playing.error)
        else:
            text = f"{self.speaker.title}: {playing.state} after {playing.seconds:.1f} s"
        if text != self._told.text:
            self._told.text = text
            if not busy_now:
                self._log.refresh()

    @ui.refreshable_method
    def _log(self) -> None:
        lines = played_lately(self.speaker.folder)
        if not lines:
            return
        with ui.expansion("What was played lately").classes("w-full"):
            for line in lines:
                ui.label(
                    f"{line['time'][:19].replace('T', ' ')}: {line['title']} on {line['device']} at "
                    f"{100 * line['strength']:.0f} %, {line['seconds']:.1f} s, {line['state']}, "
                    f"drive {line['sha256'][:12]}"
                ).classes("small quiet")


def command_line(commands: list[str]) -> None:
    """Show how the command line does the same."""
    with ui.expansion("The same on the command line").classes("w-full"):
        for command in commands:
            ui.label(command).classes("told")
