"""A drive on a connected device: begun weak, turned up while it plays, stopped with a fade, logged."""

from __future__ import annotations

import shlex
from typing import Any

from nicegui import ui

from tactogram.rendering.displays.catalogue import open_display
from tactogram.signal.io import read_signal
from tactogram.studio.layout import in_background, report_errors
from tactogram.studio.pages.send.cards import command_line
from tactogram.studio.pages.send.played_log import played_lately
from tactogram.studio.pages.send.sending import DriveRequest, SendResult, SendService
from tactogram.studio.pages.send.speaker import Speaker
from tactogram.workflows.rendering.playback import CAREFUL, NULL, outputs


class DeviceCard:
    """The card under a display's report.

    Parameters
    ----------
    sending : Sending
    speaker : Speaker
    kept : dict
        Of the browser: the output that was chosen.
    """

    def __init__(self, sending: SendService, speaker: Speaker, kept: dict[str, Any]) -> None:
        self.sending, self.speaker, self.kept = sending, speaker, kept
        self.sent: SendResult | None = None
        self._outputs: list[dict[str, Any]] = []

    def draw(self, sent: SendResult, unit: str) -> None:
        """Draw the card for a result whose drive is in ``unit``."""
        self.sent = sent
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

    def _play_commands(self, sent: SendResult) -> list[str]:
        display = sent.order.display if isinstance(sent.order, DriveRequest) else ""
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

    @report_errors
    async def _play(self) -> None:
        sent = self.sent
        if sent is None or not isinstance(sent.order, DriveRequest):
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

    @report_errors
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
