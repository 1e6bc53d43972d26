"""Metronome for a stroking hand: one beat per stroke, at the length of a stroke over its speed."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from tactogram.errors import ParameterError
from tactogram.signal import Signal

OUT_HZ, BACK_HZ = 1200.0, 800.0
"""Tone of a stroke away from the body and of one back."""
CLICK_S = 0.03
AUDIO_RATE = 48_000.0


def interval_s(stroke_mm: float, speed_mm_s: float) -> float:
    """Return the time between beats: the duration of one stroke, turns included."""
    if not (stroke_mm > 0 and speed_mm_s > 0):
        raise ParameterError(f"stroke and speed must be > 0, got {stroke_mm:g} mm and {speed_mm_s:g} mm/s")
    return stroke_mm / speed_mm_s


def click_track(
    interval_s: float, seconds: float, *, back_and_forth: bool = True, rate: float = AUDIO_RATE
) -> Signal:
    """Return the beats as a sound, peak 0.5, unit 1, one axis: the first at 0 s.

    With ``back_and_forth`` every other beat is lower.
    """
    if not (interval_s > 0 and seconds > 0):
        raise ParameterError(f"interval and seconds must be > 0, got {interval_s:g} and {seconds:g}")
    samples = np.zeros(max(1, round(seconds * rate)), np.float32)
    length = min(CLICK_S, interval_s / 2)
    t = np.arange(round(length * rate)) / rate
    fade = 0.5 * np.sin(np.pi * t / length) ** 2
    for number in range(int(np.ceil(seconds / interval_s))):
        tone = BACK_HZ if back_and_forth and number % 2 else OUT_HZ
        # Rounding the interval itself would let the beat drift from the clock.
        first = round(number * interval_s * rate)
        click = (fade * np.sin(2 * np.pi * tone * t)).astype(np.float32)[: len(samples) - first]
        samples[first : first + len(click)] = click
    return Signal(samples, rate, "1", ("mono",))


def _nothing(signal: Signal | None = None) -> None:
    """Play nothing."""


@dataclass
class Metronome:
    """Beat during a take; silent by default.

    ``play`` starts to play a Signal and returns at once, ``hush`` stops it and never raises.
    """

    play: Callable[[Signal], None] = _nothing
    hush: Callable[[], None] = _nothing

    def start(self, interval_s: float, seconds: float, *, back_and_forth: bool) -> None:
        """Beat every ``interval_s``, for at most ``seconds``: the whole track, as exact as the sound card's clock."""
        self.play(click_track(interval_s, seconds, back_and_forth=back_and_forth))

    def stop(self) -> None:
        """Stop beating."""
        self.hush()
