"""Resampling of whole signals; in a module of its own since it needs no scipy, and playing starts with it."""

from __future__ import annotations

import numpy as np
import soxr
from numpy.typing import NDArray

from tactogram.errors import ParameterError
from tactogram.signal.signal import Signal, check_rate

MOST_SAMPLES = 2**30
MOST_GROWTH, ALWAYS = 1000, 2**25
"""Samples of a result over those that it is made of, and how many it may always have."""
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
    check_growth(length, len(signal), f"at {rate:g} instead of {signal.rate:g}")
    pad = _whole_pad(ratio)
    x = _extended(signal.samples, pad)
    y = soxr.resample(np.ascontiguousarray(x.T), signal.rate, rate, quality="VHQ").T
    start = round(pad * ratio)
    return signal.with_samples(y[:, start : start + length], rate=rate)


def check_growth(count: float, made_of: int, how: str) -> None:
    """Refuse to make so many samples of a few, as one wrong rate, time stamp or coordinate asks for."""
    most = min(MOST_SAMPLES, max(ALWAYS, MOST_GROWTH * made_of))
    if not count <= most:
        raise ParameterError(
            f"{made_of} samples would become {count:.3g} {how}, at most {most} may; is a rate, a time stamp or a "
            "coordinate wrong?"
        )


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
