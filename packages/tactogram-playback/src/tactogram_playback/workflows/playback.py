"""Playback of a rendered drive on a sound card or the null device: as fitted or weaker, never stronger.

`rendering.drive.safety.DriveGuard` has the last word on every block: it fades in, fades out when stopped, and stays
within the display's limits.
"""

from __future__ import annotations

import threading
import time
from typing import Any, Literal

import numpy as np
from numpy.typing import NDArray

from tactogram.errors import DeviceError, ParameterError, Remedy, TactogramError
from tactogram.extras import digilents
from tactogram.rendering import Display, display_family
from tactogram.signal import Signal
from tactogram_playback.drive_guard import DriveGuard
from tactogram_playback.sound_card import opened_card, sound_cards

State = Literal["waiting", "playing", "ended", "stopped", "failed"]

CAREFUL = 0.25
"""Share of the drive at which playback begins by default: too strong a drive is felt before it hurts."""
GLIDE_S = 0.2
"""Duration of a change of strength, s."""
HIGHEST_RATE = 384_000
"""Highest rate of sound cards, Hz."""
STALLED_S = 2.0
"""Time without a request for samples after which a device counts as gone, s."""
BUFFER_MS = 40
NULL = "null"


def outputs() -> list[dict[str, Any]]:
    """Return the devices that can play a drive, and the kinds that could not be searched.

    Returns
    -------
    list of dict
        ``device`` (as in `play`), ``title``, ``missing`` (one line on what it lacks, or None), ``simulated``
        (no actuator connected).
    """
    devices: list[dict[str, Any]] = []

    def add(device: str, title: str, missing: str | None = None, *, simulated: bool = False) -> None:
        devices.append({"device": device, "title": title, "missing": missing, "simulated": simulated})

    try:
        names = list(sound_cards())
        for name in names:
            add(f"audio:{name}", f"sound card: {name}")
        if not names:
            add("audio", "sound card", "no sound card found: plug one in and look again")
        add(NULL, "null device, simulated: no actuator connected, real time", simulated=True)
    except TactogramError as error:
        add("audio", "sound card", str(error))
        add(NULL, "null device, simulated", str(error), simulated=True)
    try:
        addresses = digilents()
        for address in addresses:
            add(address, f"Digilent generator {address.partition(':')[2]}, envelopes")
        if not addresses:
            add("digilent", "Digilent generator, envelopes", "WaveForms works; no Digilent device found")
    except TactogramError as error:
        add("digilent", "Digilent generator, envelopes", str(error))
    return devices


def full_scale_of(display: Display, device: str, measured: float | None = None) -> float:
    """Return the drive at 1.0 of a device, in the display's unit; ``measured`` is that of device and amplifier.

    Raises `ParameterError` if a sound card cannot drive the display, or full scale is not known.
    """
    if measured is not None and not (np.isfinite(measured) and measured > 0):
        raise ParameterError.must("full_scale", f"be > 0 {display.unit}", measured)
    if display.unit not in ("1", "V"):
        raise ParameterError(
            f"{display.name} is driven in {display.unit}: a sound card cannot; write the drive and give it to the "
            "device's own program"
        )
    if not display_family(display.family).sampled:
        raise ParameterError(
            f"{display.name} takes strengths, {display.rate:g} a second, no samples: a sound card cannot give them; "
            "write the drive, or a haptic file"
        )
    if display.rate != int(display.rate) or display.rate > HIGHEST_RATE:
        raise ParameterError(
            f"{display.name} takes {display.rate:g} samples a second; a sound card has whole rates up to {HIGHEST_RATE}"
        )
    if measured is not None:
        return measured
    if display.unit == "1" or device == NULL:
        return 1.0 if display.unit == "1" else display.limit
    raise ParameterError(
        f"{display.name} is driven in V",
        remedy=(
            Remedy(
                "measure the voltage of the amplifier at the sound card's full scale and give it as",
                "full_scale",
            ),
            Remedy("render for a display in parts of full scale, such as audio"),
        ),
    )


class Playback:
    """One drive on one device, started and stopped once; it plays in the device's own thread.

    ``drive`` has the display's rate, unit and channels; ``device`` is ``null``, ``audio`` or ``audio:NAME``;
    ``strength`` is the share of the drive that is sent; ``full_scale`` as in `full_scale_of`.

    Raises `ParameterError` if it cannot be played there.
    """

    def __init__(
        self,
        drive: Signal,
        display: Display,
        *,
        device: str = NULL,
        strength: float = CAREFUL,
        loop_s: float | None = None,
        full_scale: float | None = None,
    ) -> None:
        kind, _, self._card = device.partition(":")
        if kind not in (NULL, "audio"):
            raise ParameterError.must("device", "be null, audio or audio:NAME", device)
        expected = (display.rate, display.unit, len(display.channels))
        if (drive.rate, drive.unit, len(drive.axes)) != expected or drive.domain != "time":
            raise ParameterError(
                f"this is no drive of {display.name}: expected {expected[2]} channels at {expected[0]:g} Hz in "
                f"{expected[1]}, got {len(drive.axes)} at {drive.rate:g} in {drive.unit}; render it for this display"
            )
        if loop_s is not None and not (np.isfinite(loop_s) and loop_s > 0):
            raise ParameterError.must("loop_s", "be a number of seconds > 0", loop_s)
        self.drive, self.display, self.device = drive, display, device
        self.full_scale = full_scale_of(display, kind, full_scale)
        peak = float(np.abs(drive.samples).max())
        if peak > self.full_scale * (1 + 1e-6):
            raise ParameterError(
                f"the drive goes up to {peak:.4g} {display.unit}, more than the device's full scale of "
                f"{self.full_scale:.4g}: render it weaker"
            )
        self.strength = strength
        self.state: State = "waiting"
        self.error: str | None = None
        self._total = len(drive) if loop_s is None else max(len(drive), round(loop_s * drive.rate))
        self._at, self._requested_at = 0, 0.0
        self._share = 0.0
        self._guard = DriveGuard(display)
        self._leaving, self._stop, self._over = False, threading.Event(), threading.Event()

    @property
    def strength(self) -> float:
        """Share of the drive that is sent; a change glides."""
        return self._strength

    @strength.setter
    def strength(self, share: float) -> None:
        if not 0 <= share <= 1:
            raise ParameterError.must("strength", "be a share of the drive, 0 to 1", share)
        self._strength = float(share)

    @property
    def seconds(self) -> float:
        """Duration of the drive sent so far, s."""
        return self._at / self.drive.rate

    @property
    def total_s(self) -> float:
        """Duration of the playback, s."""
        return self._total / self.drive.rate

    def pull(self, frames: int) -> NDArray[np.float32]:
        """Return the next frames for the device, float32, shape (frames, its channel), relative to full scale."""
        self._requested_at = time.monotonic()
        count = min(frames, self._total - self._at)
        if self._leaving or count <= 0:
            self._over.set()
            block = self._guard.missing(frames)
        else:
            places = (self._at + np.arange(count)) % len(self.drive)
            samples = self.drive.samples[:, places] * self._shares(count)
            self._at += count
            if self._stop.is_set():
                self._leaving = True
                block = self._guard.leaving(samples)
            else:
                block = self._guard.process(samples)
            block = np.pad(block, ((0, 0), (0, frames - count)), constant_values=self.display.rest)
        out = np.ascontiguousarray(block.T / np.float32(self.full_scale), dtype=np.float32)
        return self.display.on_card(out)

    def run(self) -> dict[str, Any]:
        """Play until it ends or is stopped, and return `facts`.

        Raises `MissingExtraError` or `DeviceError` if there is no library or device, or it stopped asking for samples.
        """
        self.state, self._requested_at = "playing", time.monotonic()
        try:
            with opened_card(
                self.pull,
                rate=self.display.rate,
                channels=self.display.card_width,
                buffer_ms=BUFFER_MS,
                null=self.device == NULL,
                name=self._card,
            ) as card:
                card.start()
                self._wait()
                card.stop()
        except TactogramError as error:
            self.state, self.error = "failed", str(error)
            raise
        self.state = "stopped" if self._stop.is_set() and self._at < self._total else "ended"
        return self.facts()

    def stop(self) -> None:
        """Fade to rest and end; safe to call at any time, from any thread."""
        self._stop.set()

    def facts(self) -> dict[str, Any]:
        """Return the facts of the playback: ``sha256`` of the drive, duration, strength, device."""
        return {
            "display": self.display.name,
            "device": self.device,
            "simulated_device": self.device == NULL,
            "sha256": self.drive.sha256,
            "strength": self.strength,
            "full_scale": self.full_scale,
            "unit": self.display.unit,
            "seconds": self.seconds,
            "state": self.state,
            "error": self.error,
        }

    def _wait(self) -> None:
        while not self._over.wait(0.05):
            if time.monotonic() - self._requested_at > STALLED_S:
                raise DeviceError(
                    f"{self.device}: has requested no samples for {STALLED_S:g} s; is it still plugged in?"
                )
        time.sleep(BUFFER_MS / 1e3)  # the device's buffer holds the fade

    def _shares(self, count: int) -> NDArray[np.float32]:
        """Return the share of each of the next samples, gliding to the set strength."""
        step = 1 / (GLIDE_S * self.drive.rate)
        ways = step * np.arange(1, count + 1)
        if self._at == 0:
            self._share = self._strength  # the guard fades in
        away = self._strength - self._share
        shares = self._share + np.sign(away) * np.minimum(ways, abs(away))
        self._share = float(shares[-1])
        return np.asarray(shares, np.float32)


def play_to_end(playing: Playback) -> dict[str, Any]:
    """Play a drive until it ends; Ctrl-C fades it out. Returns `Playback.facts`."""
    result: dict[str, Any] = {}
    # Not by joining the thread: in Python 3.11 a join after an interrupted one returns at once, before the fade.
    ended = threading.Event()

    def run() -> None:
        try:
            result.update(playing.run())
        except TactogramError as error:
            result["raised"] = error
        finally:
            ended.set()

    threading.Thread(target=run, name="playback", daemon=True).start()
    try:
        ended.wait()
    except KeyboardInterrupt:
        playing.stop()
        ended.wait()
    if (raised := result.pop("raised", None)) is not None:
        raise raised
    return result
