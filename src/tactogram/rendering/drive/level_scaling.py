"""Level scaling: removal of a constant, the factor for a level, and the reduction of a drive beyond the limits."""

from __future__ import annotations

from typing import Literal

import numpy as np
from numpy.typing import NDArray

from tactogram.errors import ParameterError, UnitError
from tactogram.rendering.displays.display import Display
from tactogram.rendering.drive.report import amount, percent
from tactogram.rendering.level import Level
from tactogram.signal.perception import sensation_level_db
from tactogram.signal.signal import Signal

MOTION = {"m": 0, "m/s": 1, "m/s^2": 2}
"""Units that are derivatives of each other, by order over time."""
CHANCE = 0.05
"""Share of the vibration's rms below which a mean is not reported."""


def kinematic_power(unit: str, display: Display) -> int:
    """Return how often a signal is differentiated over time to get the display's output unit; 0 if not a motion."""
    if unit in MOTION and display.output_unit in MOTION:
        return MOTION[display.output_unit] - MOTION[unit]
    return 0


def factor_of(
    level: Level, *, display: Display, signal: Signal, output: Signal, peak: float
) -> tuple[float, float, str]:
    """Return the factor of the drive for a requested level, that of the wanted output, and a sentence.

    ``output`` is the output for a factor of 1, in the unit of the wanted ``signal``; ``peak`` the largest magnitude of
    the drive for a factor of 1. The second factor relates the wanted output to the signal. Raises `UnitError` if the
    level does not apply to this signal or this display.
    """
    physical = display.response is not None and (
        signal.unit == display.output_unit or {signal.unit, display.output_unit} <= set(MOTION)
    )
    match level.kind:
        case "gain":
            value = float(level.value or 1.0)
            per = "times the signal" if physical else f"{display.output_unit} per {signal.unit} of the signal"
            return value, value, f"output {value:g} {per}, as requested"
        case "peak":
            factor = float(level.value or 1.0) * display.limit / peak if peak > 0 else 1.0
            share = f"{level.value:g} of the limit of {amount(display.limit, display.unit)}"
            words = f"times {factor:.4g}: the largest drive is {share}; the signal's own level is lost"
            return factor, factor, words
    if not physical:
        known = "is not known" if display.response is None else f"is in {display.output_unit}"
        raise UnitError(
            f"level {level.kind} needs a signal and a display in the same physical unit; the signal is in "
            f"{signal.unit}, the output of {display.name} {known}: measure its response, or use gain=FACTOR or "
            "peak=SHARE"
        )
    if level.kind == "physical":
        return 1.0, 1.0, "nothing: the output is the signal, in its own unit"
    original = sensation_level_db(signal)
    present = sensation_level_db(output)
    target_db = original if level.value is None else level.value
    if not (np.isfinite(original) and np.isfinite(present)):
        return 1.0, 1.0, "nothing: the signal is silent"
    factor = float(10 ** ((target_db - present) / 20))
    words = f"times {factor:.4g}: from {present:.1f} to {target_db:.1f} dB above the threshold"
    return factor, float(10 ** ((target_db - original) / 20)), words


def within_limits(
    drive: NDArray[np.float64],
    low: float,
    high: float,
    *,
    unit: str,
    over: Literal["scale", "clip", "refuse"],
    clip_share: float,
    scaled: list[str],
    clipped: list[str],
) -> tuple[NDArray[np.float64], float]:
    """Return a drive within ``low`` to ``high``, and the factor by which it was reduced.

    Up to ``clip_share`` of the samples are clipped; beyond that, ``over`` decides. Sentences are appended to
    ``scaled`` and ``clipped``. Raises `ParameterError` if too much exceeds the limit and ``over`` is ``refuse``.
    """
    reach = drive / high if low >= 0 else np.maximum(drive / high, drive / low)
    share = float(np.mean(reach > 1))
    limit = amount(high, unit)
    factor = 1.0
    if share > clip_share and over != "clip":
        if over == "refuse":
            raise ParameterError(
                f"{percent(share)} of the drive is over the limit of {limit} (largest "
                f"{amount(float(reach.max()) * high, unit)}); lower the level, or let it scale or clip"
            )
        factor = 1 / float(np.quantile(reach, 1 - clip_share, method="higher"))
        scaled.append(
            f"times {factor:.4g} ({20 * np.log10(factor):.1f} dB): {percent(share)} of the drive was over the "
            f"limit of {limit}"
        )
    outside = float(np.mean(reach * factor > 1 + 1e-9))
    if outside > 0:
        largest = 20 * np.log10(float(reach.max()) * factor)
        clipped.append(f"{percent(outside)} of the samples at {limit}, the largest by {largest:.1f} dB")
    return np.clip(drive * factor, low, high), factor


def without_constant(signal: Signal, *, least: float = 0.0) -> tuple[Signal, str | None]:
    """Return a motion (m, m/s or m/s^2) without its mean, and a sentence if the mean was significant.

    Other units are returned unchanged, and so is a motion whose mean is below ``least`` times its rms on every axis.
    """
    if signal.unit not in MOTION:
        return signal, None
    x = signal.samples.astype(np.float64)
    mean = x.mean(axis=1, keepdims=True)
    vibration = signal.with_samples(x - mean)
    largest, rms = float(np.abs(mean).max()), float(vibration.samples.std())
    if largest < least * rms:
        return signal, None
    if not largest > CHANCE * rms:
        return vibration, None
    words = f"a constant of up to {largest:.3g} {signal.unit} removed: gravity or an offset, no vibration"
    return vibration, words
