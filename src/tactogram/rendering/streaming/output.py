"""Display output: blocks of a texture to blocks of a display's drive, causally, guarded at the end.

`tactogram.rendering.drive.fit` sees a whole signal; a stream has only the past. So a *rehearsal* (seconds of the same
textures under a simulated hand) is fitted first, with its level and its report, and its factor is kept. A family that
streams a whole surface needs no rehearsal.
"""

from __future__ import annotations

from contextlib import suppress
from typing import Any

import numpy as np
from numpy.typing import NDArray

from tactogram.errors import ParameterError
from tactogram.rendering.displays.display import Display
from tactogram.rendering.displays.families import display_family
from tactogram.rendering.displays.family import StreamDrive
from tactogram.rendering.drive.fit import fit
from tactogram.rendering.drive.safety import DriveGuard
from tactogram.rendering.level import Level
from tactogram.rendering.streaming.finger_path import MotionBlock
from tactogram.rendering.streaming.surface import SurfaceTexture
from tactogram.signal.signal import Signal

Block = NDArray[np.float32]


class DisplayOutput:
    """The drive of a display, block by block; never NaN, never over a limit, at rest after an error.

    Parameters
    ----------
    display : Display
    rehearsed : Signal or SurfaceTexture
        Some seconds of what will be streamed, at the display's rate: its level decides the factor. For a family that
        streams surfaces the surface itself.
    level : Level

    Attributes
    ----------
    clipped : int
        Samples that were beyond the display's limits, of all channels.

    Raises
    ------
    ParameterError, UnitError
        If the display's family cannot be streamed to, or the level has no meaning for it.
    """

    def __init__(self, display: Display, rehearsed: Signal | SurfaceTexture, *, level: Level) -> None:
        self.display, self.family = display, display_family(display.family)
        self.drive: StreamDrive
        self.rehearsal: dict[str, Any] | None = None
        if self.family.stream_surface is not None:
            if not isinstance(rehearsed, SurfaceTexture):
                raise ParameterError(
                    f"{display.name}: streams one surface, a friction coefficient over displacement; got "
                    "what is not a surface"
                )
            self.drive = self.family.stream_surface(display, rehearsed, level)
        elif self.family.stream_signal is not None:
            if not isinstance(rehearsed, Signal):
                raise ParameterError(f"{display.name}: the level is found on a signal, got a surface")
            report = fit(rehearsed, display, level=level).report
            self.drive = self.family.stream_signal(display, rehearsed.unit, report.facts)
            self.rehearsal = report.as_json()
        else:
            raise ParameterError(
                f"{display.name}: displays of the family {display.family} cannot be streamed to: render a file for it "
                "instead"
            )
        self.guard = DriveGuard(display)
        self.clipped = 0

    def process(self, block: Block, motion: MotionBlock | None = None) -> Block:
        """Return the drive that may be sent, float32, shape (channel, time)."""
        drive = self.drive.process(block, motion)
        # By more than a float's rounding: what is made to reach the limit is not clipped by it.
        over = (drive > self.display.limit * (1 + 1e-6)) | (
            drive < self.display.floor - 1e-6 * self.display.limit
        )
        self.clipped += int(np.count_nonzero(over))
        return self.guard.process(drive)

    def missing(self, count: int) -> Block:
        """Return what is sent while there is nothing to send: a fade to rest, then rest."""
        if self.drive.runs_on:
            with suppress(Exception):
                return self.guard.leaving(self.drive.process(np.zeros((1, count), np.float32), None))
        return self.guard.missing(count)

    def facts(self) -> dict[str, Any]:
        """Return what it does, as JSON values."""
        return {
            "display": self.display.name,
            "family": self.display.family,
            "unit": self.display.unit,
            "limit": self.display.limit,
            "rehearsal": self.rehearsal,
            "clipped_samples": self.clipped,
            **self.drive.facts(),
        }

    def sentence(self) -> str | None:
        """Return what is made up for of the response, how late and how near to a file's; None where nothing could."""
        found = self.drive.facts().get("equaliser")
        if found is None:
            return None
        late = f"{found['delay_samples']:.1f} samples ({found['delay_ms']:.2f} ms) at {found['reference_hz']:g} Hz"
        if not found["on"]:
            known = self.family.response_known(self.display)
            why = "is left as it is" if known else f"is not known: {self.family.measured_by}"
            return f"equaliser: none, the response of {self.display.name} {why}; the band's edges are late by {late}"
        low, high = found["checked_hz"]
        return (
            f"equaliser: within {found['error_most_db']:.2f} dB of a file's from {low:.0f} to {high:.0f} Hz "
            f"({found['error_rms_db']:.2f} dB rms, farthest at {found['error_most_hz']:.0f} Hz), raises by up to "
            f"{found['raised_db']:.0f} dB, late by {late}"
        )


def equalised(display: Display, *, on: bool) -> Display:
    """Return a display whose response is made up for, or left as it is, in streams and files alike.

    Raises
    ------
    ParameterError
        If its family has no equaliser, or it is asked for where the response is not known.
    """
    family = display_family(display.family)
    if family.equalise is None:
        raise ParameterError(f"{display.name}: the family {family.name} has no equaliser to switch")
    if on and not family.response_known(display):
        raise ParameterError(
            f"{display.name}: its response is not known, so nothing can be made up for; {family.measured_by}"
        )
    return display.of(settings=family.equalise(display.settings, on))
