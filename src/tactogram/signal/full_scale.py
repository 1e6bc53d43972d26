"""Sensor signals as display drives: the comparison without a model in between."""

from __future__ import annotations

import numpy as np

from tactogram.errors import ParameterError
from tactogram.signal.resampling import resample
from tactogram.signal.signal import Signal


def straight_to_display(
    signal: Signal, *, rate: float, axes: tuple[str, ...], seconds: float = 1.0
) -> Signal:
    """Return the middle of a sensor's signal, standardised and scaled to a display's full scale.

    The rule: the first axis alone; its middle ``seconds``; mean 0 and variance 1 (Hatori & Takemura 2023, Sec. III-B);
    the display's rate (Hz); then divided by its largest magnitude, which becomes 1; the same samples on each of
    ``axes``. This loses the strength, which in volts of a strain gauge means nothing to a display. The publication does
    not state its scale (Sec. V-A). A constant signal becomes 0 throughout.
    """
    length = round(seconds * signal.rate)
    if length > len(signal):
        raise ParameterError(
            f"a display's signal of {seconds:g} s needs as much of a sensor's, got {signal.seconds:g} s"
        )
    start = (len(signal) - length) // 2
    x = signal.samples[0, start : start + length].astype(np.float64)
    spread = x.std()
    standard = (x - x.mean()) / spread if spread > 0 else np.zeros_like(x)
    one = Signal(standard.astype(np.float32), signal.rate, "1", axes[:1])
    if one.rate != rate:
        one = resample(one, rate)
    peak = float(np.abs(one.samples).max())
    scaled = one.samples / peak if peak > 0 else one.samples
    return Signal(np.repeat(scaled, len(axes), axis=0), rate, "1", axes)
