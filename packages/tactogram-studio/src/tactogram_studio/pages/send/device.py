"""Playback of drives on connected devices: starts weak, is turned up while it plays, stops with a fade; with a log."""

from __future__ import annotations

import math
from typing import Any

from nicegui import ui

from tactogram.rendering import open_display
from tactogram.signal.io import read_signal
from tactogram_playback import CAREFUL, NULL, outputs
from tactogram_studio import kit
from tactogram_studio.signals.traits import unfelt_text
from tactogram_studio.tasks.speaker import Speaker, recently_played
from tactogram_studio.workspace.commands import arguments, command_line
from tactogram_studio.workspace.sent import DriveRequest, SendResult, SendService

BUFFERED = "digilent"
"""Devices that play from their own buffer, which this page cannot fade out."""


class DeviceCard:
    """Card below a fit report; ``state`` holds the last output."""

    def __init__(self, service: SendService, speaker: Speaker, state: kit.TabSettings) -> None:
        self.service, self.speaker, self.state = service, speaker, state
        self.result: SendResult | None = None
        self._outputs: list[dict[str, Any]] = []
        self._level_db: float | None = None

    def draw(self, result: SendResult, unit: str, level_db: float | None) -> None:
        """Draw the card for a result whose drive is in ``unit``; ``level_db`` is the output's, as of `output_db`."""
        self.result, self._level_db = result, level_db
        with kit.card("Play on a device"):
            kit.hint(
                "Playback starts at a quarter of the drive with a fade-in; turn it up while it plays. It never exceeds "
                "the drive above."
            )
            self._devices(unit)

    def draw_running(self) -> None:
        """Draw what plays, of whichever signal, with a button that stops it; nothing while nothing plays."""
        with kit.card("Playing on a device") as card:
            status = ui.label()
            ui.button("Stop", icon="stop", color="negative", on_click=self._fade_out)

        def update() -> None:
            status.text = self._progress()
            card.set_visibility(self.speaker.busy)

        update()
        ui.timer(0.2, update)

    @ui.refreshable_method
    def _devices(self, unit: str) -> None:
        if not self._outputs:
            with ui.row().classes("items-center"):
                ui.spinner(size="sm")
                kit.hint("Looking for outputs …")
            ui.timer(0.05, self._look, once=True)
            return
        present = [output for output in self._outputs if output["missing"] is None]
        playable = {o["device"]: o["title"] for o in present if not o["device"].startswith(BUFFERED)}
        if playable:
            self._player(playable, unit)
        for output in present:
            if output["device"].startswith(BUFFERED):
                kit.hint(f"{output['title']}: play the drive with the command below.")
        if missing := [f"{o['title']}: {o['missing']}" for o in self._outputs if o["missing"] is not None]:
            with ui.expansion(f"Not connected ({len(missing)})").classes("w-full"):
                for line in missing:
                    kit.hint(line)
        if self.result is not None and isinstance(self.result.request, DriveRequest):
            display = self.result.request.display
            kit.command_lines([_play_command(display, output["device"]) for output in present])
        self._log()

    def _player(self, playable: dict[str, str], unit: str) -> None:
        last = self.state.get("output", NULL)
        first = last if last in playable else next(iter(playable))
        self._output = ui.select(playable, label="Output", value=first).classes("w-full")
        share_label = ui.label().classes("small")
        self._strength = ui.slider(min=0, max=1, step=0.01, value=CAREFUL)
        self._strength.props('aria-label="Strength: share of the drive"').on_value_change(self._set_strength)
        share_label.bind_text_from(
            self._strength, "value", lambda share: f"Strength: {100 * share:.0f} % of the drive"
        )
        self._unfelt = kit.alert()
        self._show_unfelt()
        with ui.row().classes("items-end gap-4"):
            self._loop = ui.number("Repeat for, s (empty: once)", min=0).classes("w-64")
            self._full_scale = ui.number("Volts at the card's full scale", min=0).classes("w-64")
            self._full_scale.set_visibility(unit == "V")
        with ui.row().classes("items-center gap-2 mt-2"):
            self._play_button = ui.button("Play", icon="play_arrow", on_click=self._play)
            self._stop_button = ui.button("Stop", icon="stop", color="negative", on_click=self._stop)
            self._status = ui.label().props('role="status"')
        ui.timer(0.2, self._update)

    async def _look(self) -> None:
        self._outputs = await kit.in_background(outputs)
        self._devices.refresh()

    async def _play(self) -> None:
        result = self.result
        if result is None or not isinstance(result.request, DriveRequest):
            return
        device = str(self._output.value)
        drive = await kit.in_background(read_signal, result.folder / "drive.npz")
        self.speaker.play(
            drive,
            open_display(self.service.display_file(result.request.display)),
            title=result.title,
            device=device,
            strength=float(self._strength.value),
            loop_s=self._loop.value or None,
            full_scale=self._full_scale.value or None,
        )
        self.state["output"] = device
        self._update()

    async def _fade_out(self) -> None:
        await kit.in_background(self.speaker.stop)

    async def _stop(self) -> None:
        await self._fade_out()
        self._update()

    def _set_strength(self) -> None:
        playing = self.speaker.playing
        if playing is not None and self.speaker.busy:
            playing.strength = float(self._strength.value)
        self._show_unfelt()

    def _show_unfelt(self) -> None:
        share = float(self._strength.value)
        level_db = (
            math.inf if self._level_db is None or not share else self._level_db + 20 * math.log10(share)
        )
        self._unfelt.text = unfelt_text(level_db, of="the output at this strength") if level_db < 0 else ""

    def _update(self) -> None:
        playing, busy = self.speaker.playing, self.speaker.busy
        self._play_button.set_enabled(not busy)
        self._stop_button.set_enabled(busy)
        if playing is None:
            text = ""
        elif busy:
            text = self._progress()
        elif playing.state == "failed":
            text = str(playing.error)
        else:
            text = f"{self.speaker.title}: {playing.state} after {playing.seconds:.1f} s"
        if text != self._status.text:
            self._status.text = text
            if not busy:
                self._log.refresh()

    def _progress(self) -> str:
        playing = self.speaker.playing
        return f"{self.speaker.title}: {playing.seconds:.1f} of {playing.total_s:.1f} s" if playing else ""

    @ui.refreshable_method
    def _log(self) -> None:
        entries = recently_played(self.speaker.folder)
        if not entries:
            return
        with ui.expansion("Recently played").classes("w-full"):
            for entry in entries:
                kit.hint(
                    f"{entry['time'][:19].replace('T', ' ')}: {entry['title']} on {entry['device']} at "
                    f"{100 * entry['strength']:.0f} %, {entry['seconds']:.1f} s, {entry['state']}, "
                    f"drive {entry['sha256'][:12]}"
                )


def _play_command(display: str, device: str) -> str:
    strength = None if device.startswith(BUFFERED) else CAREFUL
    return command_line(arguments("play", "drive.npz", display=display, device=device, strength=strength))
