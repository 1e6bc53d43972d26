"""Vibration strength over time, for displays that accept only a strength."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

import numpy as np
import scipy
from numpy.typing import NDArray
from pydantic import Field

from tactogram.errors import UnitError
from tactogram.rendering.displays.display import Display
from tactogram.rendering.drive.level_scaling import MOTION, within_limits
from tactogram.rendering.level import Level
from tactogram.signal.filters import bandpass, differentiate
from tactogram.signal.perception import FELT_HZ, detection_threshold, sensation_level_db, weighted
from tactogram.signal.signal import Signal
from tactogram.validation import FrozenModel


class StrengthSettings(FrozenModel):
    """Settings of displays that accept only a strength."""

    frequency_hz: float = Field(gt=0)
    """Frequency of its vibration."""
    output_at_full: float | None = Field(default=None, gt=0)
    """Amplitude of the acceleration at full drive, m/s^2; None is unknown."""
    smoothing_ms: float = Field(default=20.0, gt=0)
    """Hann window over which the signal's power is averaged, ms."""
    over: Literal["scale", "clip", "refuse"] = "scale"
    """If more than ``clip_share`` would exceed full drive: reduce all of it, clip, or refuse."""
    clip_share: float = Field(default=0.01, ge=0, lt=1)


@dataclass(frozen=True, eq=False)
class Strength:
    """Strength of a display's vibration over time, as a share of full drive's output, 0 to 1: float64, shape (time,).

    ``scaled`` and ``clipped`` are sentences on the level and on what exceeded it; ``limiting`` is the reducing factor.
    """

    share: NDArray[np.float64]
    scaled: list[str]
    clipped: list[str]
    limiting: float


def strength(signal: Signal, settings: StrengthSettings, *, display: Display, level: Level) -> Strength:
    """Return the strength of ``display``'s vibration for a signal, at its rate.

    The strength is the amplitude of the sine with the power of the signal around each moment, summed over axes. For a
    sensation level each frequency is weighted by its threshold, and the display vibrates as far above the threshold
    at its own frequency. Level ``peak`` is a share of full drive; ``gain`` is in m/s^2 per unit of signal if the
    display's output is known, else in parts of full drive per unit of signal. Raises `UnitError` if a physical or
    sensation level does not apply to signal or display; `ParameterError` if too much exceeds full drive and the
    settings refuse that.
    """
    unlimited, words = _wanted(signal, settings, display, level)
    scaled, clipped = [words], list[str]()
    share, limiting = within_limits(
        unlimited,
        0.0,
        1.0,
        unit="1",
        over=settings.over,
        clip_share=settings.clip_share,
        scaled=scaled,
        clipped=clipped,
    )
    return Strength(share, scaled, clipped, limiting)


def _wanted(
    signal: Signal, settings: StrengthSettings, display: Display, level: Level
) -> tuple[NDArray[np.float64], str]:
    """Return the strength for ``level``, above 1 where it exceeds the display, and a sentence."""
    output_at_full, frequency_hz = settings.output_at_full, settings.frequency_hz
    smoothing_ms = settings.smoothing_ms
    moving = signal.unit in MOTION and output_at_full is not None
    if level.kind in ("physical", "sensation") and not moving:
        known = "is not known" if output_at_full is None else "is known"
        raise UnitError(
            f"level {level.kind} needs a signal in {', '.join(MOTION)} and a display whose acceleration at full drive "
            f"is known; the signal is in {signal.unit}, that of {display.name} {known}: use gain=FACTOR or peak=SHARE"
        )
    if level.kind == "sensation":
        amplitude = _at_rate(_amplitude(weighted(signal), smoothing_ms), signal.rate, display.rate)
        original = sensation_level_db(signal)
        more = 0.0 if level.value is None or not np.isfinite(original) else level.value - original
        threshold = float(detection_threshold(frequency_hz, "m/s^2"))
        share = amplitude * threshold / float(output_at_full or 1.0) * 10 ** (more / 20)
        return share, f"as far above the threshold at {frequency_hz:g} Hz as the signal, {more:+.1f} dB"
    amplitude = _at_rate(_amplitude(_in_band(signal, display), smoothing_ms), signal.rate, display.rate)
    full = output_at_full or 1.0
    match level.kind:
        case "physical":
            return amplitude / full, f"{full:g} m/s^2 of the signal are full drive"
        case "gain":
            value = float(level.value or 1.0)
            per = "m/s^2" if output_at_full is not None else "of full drive"
            return amplitude * value / full, f"{value:g} {per} per {signal.unit} of the signal, as requested"
    peak = float(amplitude.max())
    factor = float(level.value or 1.0) / peak if peak > 0 else 1.0
    words = f"the strongest moment is {level.value:g} of full drive; the signal's own level is lost"
    return amplitude * factor, words


def _in_band(signal: Signal, display: Display) -> Signal:
    """Return the part of a signal felt as vibration, as acceleration if it is a motion."""
    low, high = display.band or FELT_HZ
    if high < 0.45 * signal.rate:
        signal = bandpass(signal, low, high)
    elif low < 0.4 * signal.rate:
        signal = bandpass(signal, low, np.inf) if low > 0 else signal
    while signal.unit in ("m", "m/s"):
        signal = differentiate(signal)
    return signal


def _amplitude(signal: Signal, smoothing_ms: float) -> NDArray[np.float64]:
    """Return the amplitude of the sine of equal power around each sample, float64, shape (time,)."""
    length = max(1, round(smoothing_ms / 1e3 * signal.rate))
    window = np.hanning(length + 2)[1:-1]
    power = np.sum(signal.samples.astype(np.float64) ** 2, axis=0)
    around = scipy.signal.fftconvolve(power, window / window.sum(), mode="same")
    amplitude: NDArray[np.float64] = np.sqrt(2 * np.maximum(around, 0.0))
    # The convolution leaves rounding where there is silence.
    return np.where(amplitude > 1e-7 * amplitude.max(initial=0.0), amplitude, 0.0)


def _at_rate(x: NDArray[np.float64], rate: float, new: float) -> NDArray[np.float64]:
    """Return the strength in the middle of each step of the display, interpolated linearly so that it stays >= 0."""
    count = max(1, round(len(x) * new / rate))
    middles = (np.arange(count) + 0.5) / new
    return np.asarray(np.interp(middles, np.arange(len(x)) / rate, x))


def correlation(a: NDArray[np.float64], b: NDArray[np.float64]) -> float | None:
    """Return the correlation of two strengths, -1 to 1; None if one is constant."""
    if len(a) < 2 or a.std() < 1e-12 or b.std() < 1e-12:
        return None
    return float(np.corrcoef(a, b)[0, 1])
