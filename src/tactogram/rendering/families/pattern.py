"""Phones: a vibration of one frequency, switched on and off or set to one of 255 strengths, step by step."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray
from pydantic import Field

from tactogram.rendering.displays.catalogue import DisplayFamily
from tactogram.rendering.displays.display import Display
from tactogram.rendering.drive.strength import StrengthSettings, correlation, strength
from tactogram.rendering.level import Level
from tactogram.signal.signal import Signal


class Settings(StrengthSettings):
    """Capabilities of a phone's vibrator."""

    strengths: int = Field(default=255, ge=1, le=255)
    """Steps of strength above silence: 255 with amplitude control, 1 for on and off."""
    frequency_hz: float = Field(default=175.0, gt=0)
    """Frequency of its vibration, which phones do not state."""


def drive(
    signal: Signal, settings: Settings, *, display: Display, level: Level
) -> tuple[Signal, dict[str, Any]]:
    """Return strengths of 0 to ``settings.strengths``, one per step of the display's rate.

    With only on and off, the share of time on follows the strength (error diffusion), with no time shorter than
    the display's ``shortest_ms``. ``facts`` has the same as ``timings_ms`` and ``strengths``, as phones need them, with
    equal neighbours merged. Raises `UnitError` if the level does not apply to this signal or phone; `ParameterError` if
    too much exceeds the limit and ``over`` is ``refuse``.
    """
    vibration = strength(signal, settings, display=display, level=level)
    share, scaled = vibration.share, vibration.scaled
    if settings.strengths == 1:
        values = _on_off(share, display.shortest_steps)
        scaled.append("on and off alternate: the share of time on follows the strength")
    else:
        values = np.round(share * settings.strengths)
    timings, strengths = runs(values, display.rate)
    facts = {
        "limiting": vibration.limiting,
        "timings_ms": timings,
        "strengths": strengths,
        "strength_correlation": correlation(share, values / settings.strengths),
        "scaled": scaled,
        "clipped": vibration.clipped,
        "unreachable": [
            f"the frequencies: a phone vibrates at its own, assumed to be {settings.frequency_hz:g} Hz; only the "
            "strength remains"
        ],
    }
    return Signal(values.astype(np.float32), display.rate, display.unit, display.channels), facts


def runs(values: NDArray[np.floating], rate: float) -> tuple[list[int], list[int]]:
    """Return the length of each run of equal values, in integral ms without drift, and the values."""
    starts = np.concatenate([[0], np.flatnonzero(np.diff(values)) + 1])
    places = np.round(np.concatenate([starts, [len(values)]]) * 1e3 / rate).astype(int)
    return np.diff(places).tolist(), values[starts].astype(int).tolist()


def _on_off(share: NDArray[np.float64], shortest: int) -> NDArray[np.float64]:
    """Return 0 and 1 whose running mean follows ``share``, each for ``shortest`` steps or more (silence at once)."""
    values = np.zeros(len(share))
    error, state, duration = 0.0, 0.0, shortest
    for n, value in enumerate(share):
        error += value
        target = float(error >= shortest / 2 if state == 0 else error > 0)
        if value == 0:
            error, target, duration = 0.0, 0.0, shortest
        if target != state and duration >= shortest:
            state, duration = target, 0
        values[n] = state
        error -= state
        duration += 1
    return values


FAMILY = DisplayFamily(
    name="pattern",
    settings=Settings,
    drive=drive,
    sampled=False,
    close_up_s=1.0,
)
