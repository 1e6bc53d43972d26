"""Playback of drives on connected devices: starts weak, is turned up while it plays, stops with a fade; with a log."""

from __future__ import annotations

import json
import threading
from collections.abc import Mapping
from datetime import UTC, datetime
from pathlib import Path
from typing import Any

from nicegui import ui

from tactogram.errors import DataError, ParameterError, TactogramError
from tactogram.rendering import Display, open_display
from tactogram.signal import Signal
from tactogram.signal.io import read_signal
from tactogram.text_files import parse_json, read_text
from tactogram_playback import CAREFUL, NULL, Playback, outputs
from tactogram_studio import kit
from tactogram_studio.workspace.commands import arguments, command_line
from tactogram_studio.workspace.sent import DriveRequest, SendResult, SendService

LOG = "played.jsonl"
BUFFERED = "digilent"
"""Devices that play from their own buffer, which this page cannot fade out."""


class Speaker:
    """Plays drives, one at a time, and logs them in ``folder``."""

    def __init__(self, folder: Path) -> None:
        self.folder = folder
        self.playing: Playback | None = None
        self.title = ""
        self._thread: threading.Thread | None = None
        self._lock = threading.Lock()

    @property
    def busy(self) -> bool:
        """Whether a drive is playing."""
        return self._thread is not None and self._thread.is_alive()

    def play(self, drive: Signal, display: Display, *, title: str, **options: Any) -> None:
        """Start to play; ``options`` as for `Playback`. `ParameterError` while another drive is playing."""
        with self._lock:
            if self.busy:
                raise ParameterError("something is playing; stop it first")
            playing = Playback(drive, display, **options)
            self.playing, self.title = playing, title
            self._thread = threading.Thread(
                target=self._run, args=(playing, title), name="speaker", daemon=True
            )
            self._thread.start()

    def stop(self) -> None:
        """Fade out and wait for the end."""
        playing, thread = self.playing, self._thread
        if playing is not None and thread is not None:
            playing.stop()
            thread.join(3.0)

    def _run(self, playing: Playback, title: str) -> None:
        try:
            playing.run()
        except TactogramError:
            pass  # the facts hold the error
        finally:
            log_played(self.folder, {"title": title, **playing.facts()})


def log_played(folder: Path, facts: Mapping[str, Any]) -> None:
    """Add a line to the log: drive by hash, strength and device."""
    folder.mkdir(parents=True, exist_ok=True)
    line = json.dumps({"time": datetime.now(UTC).isoformat(timespec="seconds"), **facts}, ensure_ascii=False)
    with (folder / LOG).open("a", encoding="utf-8") as file:
        file.write(line + "\n")


def recently_played(folder: Path, count: int = 5) -> list[dict[str, Any]]:
    """Return the last readable lines of the log, newest first."""
    try:
        lines = read_text(folder / LOG).splitlines()
    except DataError:
        return []
    entries = []
    for line in reversed(lines[-4 * count :]):
        try:
            entries.append(parse_json(line, LOG))
        except DataError:  # cut short by a kill
            continue
    return entries[:count]


class DeviceCard:
    """Card below a fit report; ``state`` holds the browser's last output."""

    def __init__(self, service: SendService, speaker: Speaker, state: dict[str, Any]) -> None:
        self.service, self.speaker, self.state = service, speaker, state
        self.result: SendResult | None = None
        self._outputs: list[dict[str, Any]] = []

    def draw(self, result: SendResult, unit: str) -> None:
        """Draw the card for a result whose drive is in ``unit``."""
        self.result = result
        with kit.card("Play on a device"):
            kit.hint(
                "Playback starts at a quarter of the drive with a fade-in; turn it up while it plays. It never exceeds "
                "the drive above."
            )
            self._devices(unit)

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
        for output in self._outputs:
            if output["missing"] is not None:
                kit.hint(f"{output['title']}: {output['missing']}")
            elif output["device"].startswith(BUFFERED):
                kit.hint(f"{output['title']}: play the drive with the command below.")
        if self.result is not None and isinstance(self.result.request, DriveRequest):
            display = self.result.request.display
            kit.command_lines([_play_command(display, output["device"]) for output in present])
        self._log()

    def _player(self, playable: dict[str, str], unit: str) -> None:
        last = self.state.get("output", NULL)
        first = last if last in playable else next(iter(playable))
        self._output = ui.select(playable, label="Output", value=first).classes("w-full")
        self._strength = ui.slider(min=0, max=1, step=0.01, value=CAREFUL).props(
            'label aria-label="Strength: share of the drive"'
        )
        self._strength.on_value_change(self._set_strength)
        ui.label().bind_text_from(
            self._strength, "value", lambda share: f"Strength: {100 * share:.0f} % of the drive"
        ).classes("small")
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

    async def _stop(self) -> None:
        await kit.in_background(self.speaker.stop)
        self._update()

    def _set_strength(self) -> None:
        playing = self.speaker.playing
        if playing is not None and self.speaker.busy:
            playing.strength = float(self._strength.value)

    def _update(self) -> None:
        playing, busy = self.speaker.playing, self.speaker.busy
        self._play_button.set_enabled(not busy)
        self._stop_button.set_enabled(busy)
        if playing is None:
            text = ""
        elif busy:
            text = f"{self.speaker.title}: {playing.seconds:.1f} of {playing.total_s:.1f} s"
        elif playing.state == "failed":
            text = str(playing.error)
        else:
            text = f"{self.speaker.title}: {playing.state} after {playing.seconds:.1f} s"
        if text != self._status.text:
            self._status.text = text
            if not busy:
                self._log.refresh()

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
    options = {"--display": display, "--device": device, "--strength": strength}
    return command_line(arguments("play", "drive.npz", options=options))
