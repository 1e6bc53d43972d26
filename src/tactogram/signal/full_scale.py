"""A sensor's signal as a display's drive: what is compared with where no model stands between the two."""

from __future__ import annotations

import numpy as np

from tactogram.errors import ParameterError
from tactogram.signal.filters import resample
from tactogram.signal.signal import Signal


def straight_to_display(
    signal: Signal, *, rate: float, axes: tuple[str, ...], seconds: float = 1.0
) -> Signal:
    """Return the middle of a sensor's signal, standardised and brought to a display's full scale.

    The rule: the first axis alone; its middle ``seconds``; mean 0 and variance 1 (Hatori & Takemura 2023, Sec. III-B);
    the display's rate; then divided by its largest magnitude, which becomes 1. How strong it was is thereby lost: a
    display knows no volt of a strain gauge. The publication does not say how large it was made (Sec. V-A).

    Parameters
    ----------
    signal : Signal
        Over time, at least ``seconds`` long.
    rate : float, Hz
        Of the display's signals.
    axes : tuple of str
        Of the display's signals: each gets the same samples.
    seconds : float

    Returns
    -------
    Signal
        Unit 1, largest magnitude 1; 0 throughout where the sensor's signal is constant.

    Raises
    ------
    ParameterError
        If the signal is too short.
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
