"""Display output: blocks of a texture to blocks of a display's drive, causally, limited by a guard at the end.

`tactogram.rendering.drive.fit` sees a whole signal; a stream sees only the past. So a *rehearsal* (seconds of the same
textures under a simulated hand) is fitted first, with its level and its report, and its factor is applied to the
stream. A family that streams a whole surface needs no rehearsal.
"""

from __future__ import annotations

import math
from contextlib import suppress
from typing import Any

import numpy as np
from numpy.typing import NDArray

from tactogram.errors import ParameterError
from tactogram.rendering.displays.display import Display
from tactogram.rendering.displays.family import StreamDrive, display_family
from tactogram.rendering.drive.fit import fit
from tactogram.rendering.drive.safety import DriveGuard
from tactogram.rendering.level import Level
from tactogram.rendering.streaming.engine import LEAST_RATE
from tactogram.rendering.streaming.finger_path import MotionBlock
from tactogram.rendering.streaming.surface import SurfaceTexture
from tactogram.signal.signal import Signal

Block = NDArray[np.float32]


def check_streams(display: Display) -> None:
    """Raise `ParameterError` if a display cannot be streamed to."""
    family = display_family(display.family)
    if family.stream_surface is None and family.stream_signal is None:
        raise ParameterError(
            f"{display.name}: displays of the family {display.family} cannot be streamed to: render a file instead"
        )
    if display.rate < LEAST_RATE:
        raise ParameterError(
            f"{display.name}: streaming needs a drive of at least {LEAST_RATE:g} Hz, this display takes "
            f"{display.rate:g}: render a file"
        )


class DisplayOutput:
    """Drive of a display, block by block; never NaN, never over a limit, at rest after an error.

    ``rehearsed`` is some seconds of the stream at the display's rate, whose level determines the factor, or the
    surface itself for a family that streams surfaces. ``clipped`` counts the samples beyond the display's limits in
    all channels. Raises `ParameterError` or `UnitError` if the display's family cannot be streamed to, or the level
    does not apply to it.
    """

    def __init__(self, display: Display, rehearsed: Signal | SurfaceTexture, *, level: Level) -> None:
        check_streams(display)
        self.display, self.family = display, display_family(display.family)
        self.drive: StreamDrive
        self.rehearsal: dict[str, Any] | None = None
        if self.family.stream_surface is not None:
            if not isinstance(rehearsed, SurfaceTexture):
                raise ParameterError(
                    f"{display.name}: a stream needs one surface, a friction coefficient over displacement; got "
                    "a signal over time"
                )
            self.drive = self.family.stream_surface(display, rehearsed, level)
        elif self.family.stream_signal is not None:
            if not isinstance(rehearsed, Signal):
                raise ParameterError(f"{display.name}: the level needs a rehearsed signal, got a surface")
            report = fit(rehearsed, display, level=level).report
            self.drive = self.family.stream_signal(display, rehearsed.unit, report.facts)
            self.rehearsal = report.as_json()
        self.guard = DriveGuard(display)
        self.clipped = 0
        self._sent, self._square, self._peak = 0, 0.0, 0.0

    def process(self, block: Block, motion: MotionBlock | None = None) -> Block:
        """Return the drive to send, float32, shape (channel, time)."""
        drive = self.drive.process(block, motion)
        # A float's rounding at the limit does not count as clipped.
        over = (drive > self.display.limit * (1 + 1e-6)) | (
            drive < self.display.floor - 1e-6 * self.display.limit
        )
        self.clipped += int(np.count_nonzero(over))
        sent = self.guard.process(drive)
        away = sent.astype(np.float64) - self.display.rest
        self._sent += away.size
        self._square += float(np.square(away).sum())
        self._peak = max(self._peak, float(np.abs(away).max()))
        return sent

    def missing(self, count: int) -> Block:
        """Return a fade to rest, then rest, for the time without motion."""
        if self.drive.runs_on:
            with suppress(Exception):
                return self.guard.leaving(self.drive.process(np.zeros((1, count), np.float32), None))
        return self.guard.missing(count)

    def facts(self) -> dict[str, Any]:
        """Return the display, its rehearsal, and what was clipped and sent (from rest, in its unit), as JSON values."""
        return {
            "display": self.display.name,
            "family": self.display.family,
            "unit": self.display.unit,
            "limit": self.display.limit,
            "rehearsal": self.rehearsal,
            "clipped_samples": self.clipped,
            "drive_rms": math.sqrt(self._square / self._sent) if self._sent else 0.0,
            "drive_peak": self._peak,
            **self.drive.facts(),
        }

    def sentence(self) -> str | None:
        """Return a sentence on the equaliser, its delay and its difference from a file's; None without one."""
        facts = self.drive.facts().get("equaliser")
        if facts is None:
            return None
        delay = f"{facts['delay_samples']:.1f} samples ({facts['delay_ms']:.2f} ms) at {facts['reference_hz']:g} Hz"
        if not facts["on"]:
            known = self.family.response_known(self.display)
            why = "is not equalised" if known else f"is not known: {self.family.measured_by}"
            return f"equaliser: none, the response of {self.display.name} {why}; the band's edges delay by {delay}"
        low, high = facts["checked_hz"]
        return (
            f"equaliser: within {facts['error_most_db']:.2f} dB of a file's from {low:.0f} to {high:.0f} Hz "
            f"({facts['error_rms_db']:.2f} dB rms, largest at {facts['error_most_hz']:.0f} Hz), raises by up to "
            f"{facts['raised_db']:.0f} dB, delays by {delay}"
        )
