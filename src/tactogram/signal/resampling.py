"""Resampling of whole signals; in a module of its own since it needs no scipy, and playing starts with it."""

from __future__ import annotations

import numpy as np
import soxr
from numpy.typing import NDArray

from tactogram.errors import ParameterError
from tactogram.signal.signal import Signal, check_rate

MOST_SAMPLES = 2**30
_LONGEST_PAD = 100_000
"""Range of the search for a padding that is a whole number of samples at both rates."""


def resample(signal: Signal, rate: float) -> Signal:
    """Return ``signal`` at another rate, band-limited (soxr, very high quality).

    Content below 0.45 of the lower of the two rates keeps its level; content that the new rate cannot represent is
    removed. Sample 0 stays at the same instant. The ends are continued by point reflection, so that a constant and a
    slope continue; faster changes are uncertain there for some samples of the lower rate. The result has
    ``round(len(signal) * rate / signal.rate)`` samples; the rate (Hz, or per mm over displacement) need not be whole.
    """
    check_rate(rate)
    if rate == signal.rate:
        return signal
    ratio = rate / signal.rate
    length = round(len(signal) * ratio)
    if length < 1:
        raise ParameterError.must(
            "rate", f"leave at least one sample, got {rate:g} for {len(signal)} samples at {signal.rate:g}"
        )
    if length > MOST_SAMPLES:
        raise ParameterError.must(
            "rate", f"leave at most {MOST_SAMPLES} samples, got {rate:g} for {length:.3g}"
        )
    pad = _whole_pad(ratio)
    x = _extended(signal.samples, pad)
    y = soxr.resample(np.ascontiguousarray(x.T), signal.rate, rate, quality="VHQ").T
    start = round(pad * ratio)
    return signal.with_samples(y[:, start : start + length], rate=rate)


def _extended(samples: NDArray[np.float32], pad: int) -> NDArray[np.float64]:
    """Return the samples with ``pad`` more on both sides, reflected in the end points so that the slope continues."""
    x = samples.astype(np.float64)
    if x.shape[1] == 1:
        return np.pad(x, ((0, 0), (pad, pad)), mode="edge")
    return np.pad(x, ((0, 0), (pad, pad)), mode="reflect", reflect_type="odd")


def _whole_pad(ratio: float) -> int:
    """Return a number of samples that is (nearly) whole at both rates and longer than soxr's kernel."""
    least = int(np.ceil(200 * max(1.0, 1 / ratio)))
    pads = np.arange(least, least + _LONGEST_PAD)
    error = np.abs(pads * ratio - np.round(pads * ratio))
    good = np.flatnonzero(error < 1e-7)
    return int(pads[good[0] if len(good) else np.argmin(error)])
