"""From blocks of a texture to blocks of a display's drive, causally, with the display's own guard at the end.

`tactogram.rendering.drive.fit` sees a whole signal; a stream has only the past. So a *rehearsal* (seconds of the same
textures under a simulated hand) is fitted first, with its level and its report, and the factor that it found is kept;
what makes up for the response is an `equaliser`, in the family's `drives`.
An electrovibration display needs no rehearsal: the whole of its surface is known.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from contextlib import suppress
from typing import Any

import numpy as np
from numpy.typing import NDArray

from tactogram.errors import ParameterError
from tactogram.rendering.displays.display import Display
from tactogram.rendering.drive.fit import fit
from tactogram.rendering.drive.safety import DriveGuard
from tactogram.rendering.families import linear, ultrasonic
from tactogram.rendering.level import Level
from tactogram.rendering.streaming.drives import (
    ElectrovibrationDrive,
    LinearDrive,
    StreamDrive,
    UltrasonicDrive,
)
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
        Some seconds of what will be streamed, at the display's rate: its level decides the factor. For an
        electrovibration display the surface itself.
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
        makers: dict[str, Callable[[Display, str, Mapping[str, Any]], StreamDrive]] = {
            "linear": LinearDrive,
            "ultrasonic": UltrasonicDrive,
        }
        if display.family not in (*makers, "electrovibration"):
            raise ParameterError(
                f"{display.name}: displays of the family {display.family} cannot be streamed to so far; "
                f"streaming is for {', '.join(makers)} and electrovibration displays: render a file for it instead"
            )
        self.display = display
        self.drive: StreamDrive
        if display.family == "electrovibration":
            if not isinstance(rehearsed, SurfaceTexture):
                raise ParameterError(
                    f"{display.name}: streams one surface, a friction coefficient over displacement; got "
                    "what is not a surface"
                )
            self.drive = ElectrovibrationDrive(display, rehearsed, level)
            self.rehearsal: dict[str, Any] | None = None
        else:
            if not isinstance(rehearsed, Signal):
                raise ParameterError(f"{display.name}: the level is found on a signal, got a surface")
            report = fit(rehearsed, display, level=level).report
            self.drive = makers[display.family](display, rehearsed.unit, report.facts)
            self.rehearsal = report.as_json()
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
        if isinstance(self.drive, ElectrovibrationDrive):
            # Its carrier goes on while it fades: held at an instant it would be a direct voltage.
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
        if isinstance(self.drive, ElectrovibrationDrive):
            return None
        found = self.drive.facts()["equaliser"]
        late = f"{found['delay_samples']:.1f} samples ({found['delay_ms']:.2f} ms) at {found['reference_hz']:g} Hz"
        if not found["on"]:
            why = (
                "is left as it is"
                if _known(self.display)
                else f"is not known: {_MEASURE[self.display.family]}"
            )
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
    if on and not _known(display) and display.family in _MEASURE:
        raise ParameterError(
            f"{display.name}: its response is not known, so nothing can be made up for; {_MEASURE[display.family]}"
        )
    settings = display.settings
    if isinstance(settings, linear.Settings):
        how = settings.equalise if on and settings.equalise != "none" else "full" if on else "none"
        return display.of(settings=settings.model_copy(update={"equalise": how}))
    if isinstance(settings, ultrasonic.Settings):
        return display.of(settings=settings.model_copy(update={"pre_emphasis": on}))
    raise ParameterError(f"{display.name}: the family {display.family} has no equaliser to switch")


_MEASURE = {
    "linear": "measure it with `tactogram sweep` and `tactogram response`",
    "ultrasonic": "its q is wanted, which `tactogram transducer` tells from a measured admittance",
}


def _known(display: Display) -> bool:
    """Say whether what the display does to a frequency was measured or stated."""
    if isinstance(display.settings, ultrasonic.Settings):
        return display.settings.q is not None
    return display.response is not None
