"""Fit of a signal to the drive of a display, with a report of the changes."""

from __future__ import annotations

import math
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from tactogram.errors import ParameterError
from tactogram.rendering.displays.catalogue import display_family, open_display
from tactogram.rendering.displays.display import Display
from tactogram.rendering.drive.axes import combined
from tactogram.rendering.drive.level_scaling import without_constant
from tactogram.rendering.drive.report import SENTENCES, FitReport, amount, signal_facts
from tactogram.rendering.drive.safety import safe
from tactogram.rendering.level import Level, parse_level
from tactogram.signal.displacement import played
from tactogram.signal.signal import RATES, Signal, signal_of

MOST_SAMPLES = 2e8
"""Most samples of a drive's channel: 400 s of an ultrasonic waveform, and 1.6 GB while it is transformed."""


@dataclass(frozen=True, eq=False)
class Drive:
    """Drive of a display, and the report of its fit.

    ``signal`` is the drive: at the display's rate, in its unit, with its channels as axes, within its limits;
    ``source`` the rendered signal: over time, the axes already combined, in its own unit.
    """

    signal: Signal
    report: FitReport
    source: Signal


def fit(
    signal: Signal,
    display: Display | Path | str,
    *,
    level: Level | str,
    axes: str | None = None,
    speed_mm_s: float | Signal | None = None,
) -> Drive:
    """Return the drive that renders ``signal`` on ``display`` at ``level``.

    In this order: conversion from displacement to time; removal of a motion's constant (gravity); axes; then by the
    display's family: rate, unit, level, equalisation, limit; then fades, DC and the limits again.

    Parameters
    ----------
    signal : Signal
    display : Display, Path or str
        Or its name or file, as of `open_display`.
    level : Level or str
        Or its text, as of `parse_level`; there is no default.
    axes : str, optional
        How several axes become the display's, see `tactogram.rendering.drive.axes`; the display's own way by default.
    speed_mm_s : float or Signal, optional
        The finger's, for a signal over displacement: a constant, or over time in m/s.

    Raises
    ------
    UnitError
        If the level does not apply to this signal or this display.
    ParameterError
        If a signal over displacement has no speed, a signal over time has one, or the family refuses.

    Examples
    --------
    >>> tick = tactogram.Signal([0, 1, -1, 0] * 100, 1000, "m/s^2")
    >>> drive = tactogram.fit(tick, tactogram.open_display("audio"), level="peak=0.5")
    >>> round(float(abs(drive.signal.samples).max()), 2)
    0.5
    """
    level = parse_level(level) if isinstance(level, str) else level
    if not isinstance(level, Level):
        raise ParameterError.must("level", "be a Level or its text, such as peak=0.5", level)
    display = display if isinstance(display, Display) else open_display(display)
    source_facts = signal_facts(signal_of(signal))
    scaled: list[str] = []
    if signal.domain == "displacement":
        if speed_mm_s is None:
            raise ParameterError("a signal over displacement needs speed_mm_s, the speed of the finger")
        signal, words = _over_time(signal, speed_mm_s, display)
        scaled.append(words)
    elif speed_mm_s is not None:
        raise ParameterError("a signal over time takes no speed_mm_s; omit it")
    if signal.seconds * display.rate > MOST_SAMPLES:
        raise ParameterError(
            f"{signal.seconds:.4g} s at {display.rate:g} Hz are more samples than a drive may have, {MOST_SAMPLES:g}: "
            "cut the signal, or render an envelope"
        )
    signal, constant = without_constant(signal)
    if constant is not None:
        scaled.append(constant)
    source, words = combined(signal, axes if axes is not None else display.axes)
    scaled.append(words)
    raw, facts = display_family(display.family).drive(source, display.settings, display=display, level=level)
    drive, safety = safe(raw, display, faded=bool(facts.pop("faded", False)))
    scaled += [*facts.get("scaled", []), *_lost_to_fades(raw, drive, display)]
    clipped = list(facts.get("clipped", []))
    if safety["clipped_samples"]:
        clipped.append(f"{safety['clipped_samples']} samples by the last check of the limits")
    report = FitReport(
        display=display.name,
        family=display.family,
        level=level.facts(),
        signal=source_facts,
        drive=signal_facts(drive),
        scaled=scaled,
        clipped=clipped,
        unreachable=list(facts.get("unreachable", [])),
        facts={**{k: v for k, v in facts.items() if k not in SENTENCES}, "safety": safety},
    )
    return Drive(drive, report, source)


def _lost_to_fades(raw: Signal, drive: Signal, display: Display) -> list[str]:
    """Return a sentence if the largest drive was in a fade."""
    before, after = (float(np.abs(x.samples).max()) for x in (raw, drive))
    if after > 0.99 * before:
        return []
    return [
        f"the largest drive was {amount(before, display.unit)}, in a fade of {display.fade_ms:g} ms; after it, it is "
        f"{amount(after, display.unit)}"
    ]


def _over_time(signal: Signal, speed_mm_s: float | Signal, display: Display) -> tuple[Signal, str]:
    if not isinstance(speed_mm_s, Signal) and not (speed_mm_s > 0 and math.isfinite(speed_mm_s)):
        raise ParameterError(f"a speed must be > 0 mm/s and finite, got {speed_mm_s:g}")
    if isinstance(speed_mm_s, Signal):
        rate = display.rate if display.band is None else min(display.rate, 4 * display.band[1])
        return played(signal, speed_mm_s, rate), f"played at a given speed over {speed_mm_s.seconds:.4g} s"
    low, high = (limit / signal.rate for limit in RATES)
    if not low <= speed_mm_s <= high:
        raise ParameterError(
            f"a speed must be {low:.3g} to {high:.3g} mm/s for this signal, got {speed_mm_s:g}"
        )
    over_time = played(signal, speed_mm_s, signal.rate * speed_mm_s)
    return over_time, f"played at {speed_mm_s:g} mm/s: {signal.length_mm:.4g} mm in {over_time.seconds:.4g} s"
