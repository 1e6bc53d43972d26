"""Electrovibration displays: files by `rendering.drive.electrovibration`, and streams, zero when the finger is lost."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from tactogram.rendering.displays.catalogue import DisplayFamily, MotionBlock
from tactogram.rendering.displays.display import Display
from tactogram.rendering.drive.electrovibration import (
    HIGHEST_HZ,
    Settings,
    drive,
    friction_target,
    voltage,
)
from tactogram.rendering.drive.modulation import limited
from tactogram.rendering.drive.path_playback import PathPlayback
from tactogram.rendering.level import Level
from tactogram.signal.signal import Signal


class ElectrovibrationStream:
    """Voltage for a friction coefficient over displacement (one axis), along a path that arrives in blocks.

    The scaling is determined in advance from the whole texture; ``facts`` holds that of `friction_target`. The
    ``rate`` (Hz) must be above twice the carrier for a waveform, above twice ``highest_hz`` for an envelope.
    ``level`` is as in `drive`.
    """

    def __init__(
        self,
        texture: Signal,
        settings: Settings,
        *,
        rate: float,
        level: Level,
        highest_hz: float = HIGHEST_HZ,
    ) -> None:
        settings.check_rate(rate, highest_hz)
        target, facts, sentences = friction_target(texture, settings, level)
        self.facts: dict[str, Any] = {**facts, **sentences}
        self.settings, self.rate = settings, float(rate)
        self._playback = PathPlayback(
            target, rate=rate, highest_hz=highest_hz, hysteresis_mm=settings.hysteresis_mm
        )
        self._slew = settings.slew_v_per_s / rate
        self._release = 1 / max(1.0, settings.release_s * rate)
        self._patience = settings.watchdog_s * rate  # samples
        self._silent = math.inf
        self._gain = self._amplitude = 0.0
        self._count = 0
        self._stopped = False

    def process(
        self, place_mm: ArrayLike | None, length: int, *, contact: bool = True
    ) -> NDArray[np.float32]:
        """Return the next block of the drive, float32, shape (time,), V at the generator; at most ``settings.peak_v``.

        The arguments are those of `PathPlayback.process`. A lifted finger counts as news: the voltage is held. Without
        news for longer than ``settings.watchdog_s`` the voltage goes to zero within ``settings.release_s``, and with
        news it returns as fast.
        """
        mu = self._playback.process(place_mm, length, contact=contact)
        news = not contact or (place_mm is not None and bool(np.isfinite(np.asarray(place_mm, float)).any()))
        silent = np.arange(1, length + 1) + (0 if news else self._silent)
        if news:
            silent = np.zeros(length)
        self._silent = float(silent[-1])
        alive = (silent <= self._patience) & (not self._stopped)
        volts = math.sqrt(2) * voltage(mu, self.settings)
        envelope = np.empty(length)
        for i in range(length):
            self._amplitude = min(max(volts[i], self._amplitude - self._slew), self._amplitude + self._slew)
            step = self._release if alive[i] else -self._release
            self._gain = min(max(self._gain + step, 0.0), 1.0)
            envelope[i] = self._amplitude * self._gain
        samples = self.settings.output_of(envelope, self.rate, first=self._count)
        self._count += length
        return limited(samples / self.settings.amplifier_gain, self.settings.peak_v)

    def stop(self) -> NDArray[np.float32]:
        """Return the last block, from the present voltage to zero in ``release_s``; later ones are zero."""
        self._stopped = True
        return self.process(None, math.ceil(1 / self._release) + 1)


class SurfaceStream:
    """Drive of an electrovibration display, block by block, from the whole surface; see `ElectrovibrationStream`.

    It plays the surface itself instead of the engine's blocks: it has its own hysteresis, slew and watchdog, and omits
    the transients of landings, which are no friction. Beyond the surface's ends it is mirrored.
    """

    runs_on = True

    def __init__(self, display: Display, surface: Signal, along: str, level: Level) -> None:
        settings = display.settings_as(Settings)
        display.check_volts(settings.peak_v, lower="v_max")
        self._along = along
        self._stream = ElectrovibrationStream(
            surface,
            settings,
            rate=display.rate,
            level=level,
            highest_hz=display.band[1] if display.band else HIGHEST_HZ,
        )

    def process(self, block: NDArray[np.float32], motion: MotionBlock | None = None) -> NDArray[np.float64]:
        """Return the voltage at the generator, float64, shape (1, time); ``block`` determines only the length."""
        count = block.shape[1]
        if motion is None or motion.count != count:
            return np.asarray(self._stream.process(None, count)[None], np.float64)
        path = {"path": motion.path_mm, "x": motion.x_mm, "y": motion.y_mm}[self._along]
        touching = bool(motion.contact[:count].any())
        return np.asarray(self._stream.process(path[:count], count, contact=touching)[None], np.float64)

    def facts(self) -> dict[str, Any]:
        """Return what was scaled, clipped and unreachable for the whole surface."""
        return {"fitted": self._stream.facts}


FAMILY = DisplayFamily(
    name="electrovibration",
    settings=Settings,
    drive=drive,
    renders="friction",
    stream_surface=SurfaceStream,
    measured_by="`tactogram calibrate` fits it to a person",
    calibrated=True,
    hazard=(
        "A voltage touches a person, up to {peak:.3g} V here: play it only through an amplifier that limits the "
        "current. Limits in software do not replace one."
    ),
    close_up_s=0.05,
)
