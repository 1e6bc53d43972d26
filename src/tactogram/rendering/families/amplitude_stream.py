"""Eccentric motors (ERM) and linear resonant actuators (LRA) whose driver accepts a vibration strength.

The driver takes an amplitude a few hundred times a second: the real-time playback of Texas Instruments' DRV2605 and
similar ones. Formats and addresses of the registers are from the data sheet (SLOS825C, sec. 7.5.8 and 7.6). In closed
loop the driver itself overdrives and brakes, and values at or below the middle are silence; in open loop full scale is
the overdrive clamp, and negative values brake.
"""

from __future__ import annotations

from typing import Any, Literal

import numpy as np
from numpy.typing import NDArray
from pydantic import Field
from scipy import signal as dsp

from tactogram.rendering.displays.catalogue import DisplayFamily
from tactogram.rendering.displays.display import Display
from tactogram.rendering.drive.report import percent
from tactogram.rendering.drive.strength import StrengthSettings, correlation, strength
from tactogram.rendering.level import Level
from tactogram.signal.signal import Signal

PLAYBACK_REGISTER = 0x02
FULL = 127
"""Largest magnitude of the register's signed 8 bits that is used in both directions."""


class Settings(StrengthSettings):
    """The actuator and its driver's configuration."""

    actuator: Literal["erm", "lra"]
    """An ERM's acceleration is proportional to the square of its speed, an LRA's to its drive."""
    loop: Literal["closed", "open"] = "closed"
    """Whether the driver (closed) or the stream (open) overdrives and brakes."""
    rise_ms: float = Field(default=30.0, gt=0)
    """Time constant of the amplitude, or of the motor's speed, ms."""
    start: float = Field(default=0.0, ge=0, lt=1)
    """Drive, as a share of rated, below which nothing moves; weaker values become silence."""
    rated_share: float = Field(default=0.7, gt=0, le=1)
    """Open loop: rated voltage over overdrive clamp; the rest is for overdrive."""
    overdrive: bool = True
    """Open loop: whether the stream overdrives and brakes for a faster response."""


def drive(
    signal: Signal, settings: Settings, *, display: Display, level: Level
) -> tuple[Signal, dict[str, Any]]:
    """Return register values for real-time playback, one per step of the display's rate.

    Raises `UnitError` if the level does not apply to this signal or actuator; `ParameterError` if too much exceeds
    the limit and ``over`` is ``refuse``.
    """
    vibration = strength(signal, settings, display=display, level=level)
    share, scaled = vibration.share, vibration.scaled
    target = np.sqrt(share) if settings.actuator == "erm" else share
    silent = target < settings.start
    target = np.where(silent, 0.0, target)
    keeps = float(np.exp(-1e3 / (settings.rise_ms * display.rate)))
    rated = FULL * (settings.rated_share if settings.loop == "open" else 1.0)
    most = FULL / rated
    command = _overdriven(target, keeps, most) if settings.loop == "open" and settings.overdrive else target
    values = np.round(command * rated)
    values = np.clip(values, max(display.floor, -FULL), min(display.limit, FULL))
    speed = dsp.lfilter([1 - keeps], [1, -keeps], values / rated)
    reached = np.maximum(speed, 0) ** 2 if settings.actuator == "erm" else np.maximum(speed, 0)
    facts: dict[str, Any] = {
        "setup": setup_registers(settings),
        "register": PLAYBACK_REGISTER,
        "limiting": vibration.limiting,
        "silent_share": float(np.mean(silent & (share > 0))),
        "overdriven_share": float(np.mean(np.abs(values) > rated + 0.5)),
        "braking_share": float(np.mean(values < 0)),
        "strength_correlation": correlation(share, reached),
        "strength_rms_error": float(np.sqrt(np.mean((share - reached) ** 2))),
        "frequency_hz": settings.frequency_hz,
    }
    unreachable = [_one_frequency(settings)]
    if facts["silent_share"]:
        unreachable.append(
            f"{percent(facts['silent_share'])} of the time is too weak to move it and is silent"
        )
    if settings.loop == "closed":
        scaled.append(
            "overdrive and braking are the driver's own: neither the stream nor the figures include them"
        )
    elif settings.overdrive:
        above, below = (percent(facts[name]) for name in ("overdriven_share", "braking_share"))
        scaled.append(
            f"overdriven in {above} and braked in {below} of the steps, against a time constant of "
            f"{settings.rise_ms:g} ms"
        )
    facts |= {"scaled": scaled, "clipped": vibration.clipped, "unreachable": unreachable}
    return Signal(values.astype(np.float32), display.rate, display.unit, display.channels), facts


def setup_registers(settings: Settings) -> list[list[int]]:
    """Return the (address, value) pairs that configure a DRV2605 for the stream, after its own calibration.

    Mode 5 is real-time playback; bit 7 of 0x1A is an LRA; bit 7 of 0x1C accepts values in both directions; of 0x1D,
    bit 3 (0) is signed data, bit 5 an ERM in open loop, bit 0 an LRA in open loop. The other bits of 0x1A, 0x1C and
    0x1D are those after a reset: keep what the calibration wrote there instead.
    """
    feedback = 0x36 | (0x80 if settings.actuator == "lra" else 0)
    opened = settings.loop == "open"
    control3 = 0x80 | (0x20 if opened and settings.actuator == "erm" else 0)
    control3 |= 0x01 if opened and settings.actuator == "lra" else 0
    return [[0x01, 0x05], [0x1A, feedback], [0x1C, 0xF5], [0x1D, control3]]


def register_bytes(drive: Signal) -> NDArray[np.uint8]:
    """Return a drive as bytes for `PLAYBACK_REGISTER` (two's complement), uint8, shape (time,)."""
    whole: NDArray[np.int8] = np.round(drive.samples[0]).astype(np.int8)
    return whole.view(np.uint8)


def _overdriven(target: NDArray[np.float64], keeps: float, most: float) -> NDArray[np.float64]:
    """Return the commands that bring a first-order lag to ``target`` at the end of each step, within ±``most``."""
    command = np.empty_like(target)
    now = 0.0
    for n, value in enumerate(target):
        command[n] = min(max((value - keeps * now) / (1 - keeps), -most), most)
        now = keeps * now + (1 - keeps) * command[n]
    return command


def _one_frequency(settings: Settings) -> str:
    kind = (
        "an ERM's frequency follows its strength, up to"
        if settings.actuator == "erm"
        else "an LRA vibrates only at"
    )
    return f"the frequencies: {kind} {settings.frequency_hz:g} Hz; only the strength remains"


FAMILY = DisplayFamily(
    name="amplitude_stream",
    settings=Settings,
    drive=drive,
    sampled=False,
    close_up_s=0.5,
)
