"""Paired distances between a signal and its reconstruction: for codecs and inversion only.

These compare sample by sample, after `align`. They are meaningless for generators: a new draw of the *same* texture
has different samples and scores like another texture. Use `signal_measures` for generators.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray
from scipy import fft
from scipy.stats import norm

from tactogram.errors import ParameterError
from tactogram.evaluation.measures.sets import check_alike
from tactogram.signal import Signal
from tactogram.signal.perception import spqi_threshold_db

BLOCK_S = 0.064
"""Length of the blocks of ST-SIM and SPQI, s: the published 512 samples at 8 kHz."""

BLOCK_SAMPLES = 512
"""Samples of a published block: sets the scale of its orthonormal transform, which the threshold refers to."""

SUPPORT_DB = 12.0
"""ST-SIM: softness of the threshold, dB (standard deviation of a normal distribution)."""

TINY = float(np.finfo(np.float64).eps)


def align(distorted: Signal, reference: Signal, *, within_s: float = 0.05) -> tuple[Signal, Signal]:
    """Return both cut to their best overlap, of equal length.

    The delay, in whole samples up to ``within_s`` seconds, maximises their cross-correlation, summed over axes (Knapp
    and Carter 1976, without weighting). They may differ in length.
    """
    rate = check_alike([distorted], [reference]).rate
    most = round(within_s * rate) if within_s >= 0 else -1
    n, m = len(distorted), len(reference)
    if not 0 <= most < min(n, m):
        raise ParameterError(
            f"within_s must be >= 0 and below the {min(n, m) / rate:.3g} s of the signals, got {within_s:g}"
        )
    points = fft.next_fast_len(n + m, real=True)
    x, y = (fft.rfft(s.samples.astype(np.float64), points, axis=1) for s in (distorted, reference))
    correlation = fft.irfft(np.sum(x * y.conj(), axis=0), points)
    delays = np.arange(-most, most + 1)
    delay = int(delays[correlation[delays].argmax()])
    start_x, start_y = max(delay, 0), max(-delay, 0)
    length = min(n - start_x, m - start_y)
    return distorted.cut(start_x, start_x + length), reference.cut(start_y, start_y + length)


def signal_to_noise_ratio_db(distorted: Signal, reference: Signal) -> float:
    """Return the signal-to-noise ratio of two aligned signals, dB. For codecs and inversion only.

    10 log10(sum y^2 / sum (x - y)^2) over samples and axes, y the reference. Infinite for an exact copy, minus infinite
    for any error on silence.
    """
    x, y = _pair(distorted, reference)
    error, energy = float(np.sum((x - y) ** 2)), float(np.sum(y**2))
    if error == 0:
        return np.inf
    return float(10 * np.log10(energy / error)) if energy > 0 else -np.inf


def st_sim(distorted: Signal, reference: Signal, *, full_scale: float = 1.0, eta: float = 2 / 3) -> float:
    """Return the spectral-temporal similarity of two aligned signals. For codecs and inversion only.

    t^eta s^(1 - eta). t is the mean over blocks of sum(x y) / sum(y^2) of the blocks' samples, each block
    without its mean and divided by its standard deviation; s is the same of their spectral supports, Phi((L - T)
    / 12 dB), where L is the level of a DCT component in dB, T the threshold at its frequency
    (`tactogram.signal.perception.spqi_threshold_db`) and Phi the normal distribution. Mean over axes.

    Differs from the publication: the rate is the signals' own (blocks of 64 ms, the threshold at true
    frequencies, levels as at 8 kHz; the public implementation assumes 8 kHz for any signal). A negative t
    counts as 0, since the power of a negative number would be complex. Blocks that are constant, or have
    nothing near the threshold, in both signals score 1.

    The signals last at least 64 ms. ``full_scale``, > 0, is the threshold's 0 dB in their unit: the published curve has
    no unit and refers to its authors' scaling. ``eta``, 0..1, is the weight of time against spectrum. The result is >=
    0; 1 for a copy, slightly above 1 where the distorted signal has more above the threshold.

    References
    ----------
    R. Hassen and E. Steinbach, IEEE Trans. Haptics 2020, IEEE Xplore document 8943164. The paper was
    not available: formula and constants are those documented for the public package vibromaf 0.0.8.
    """
    if not 0 < eta < 1:
        raise ParameterError(f"eta must be between 0 and 1, got {eta}")
    x, y = _blocks(distorted, reference)
    first, second = (
        norm.cdf(_felt_spectrum(blocks, reference.rate, full_scale), scale=SUPPORT_DB) for blocks in (y, x)
    )
    spectral = _similarity(first, second).mean(axis=-1)
    temporal = np.maximum(_similarity(_standardised(y), _standardised(x)).mean(axis=-1), 0.0)
    return float(np.mean(temporal**eta * spectral ** (1 - eta)))


def spqi(distorted: Signal, reference: Signal, *, full_scale: float = 1.0) -> float:
    """Return the spectral perceptual quality index of two aligned signals. For codecs and inversion only.

    Mean over blocks of 64 ms and axes of (1 - tanh(0.3 E + 2)) / 2, where E = 10 log10(sum over components of
    abs(X - Y) / sum of Y) dB, and X, Y are the powers of the DCT components relative to the threshold
    (`tactogram.signal.perception.spqi_threshold_db`). Blind to sign and, as far as the DCT is, to phase within a
    block. The rate is the signals' own, as in `st_sim`.

    The result is in 0..1; 1 for a copy.

    References
    ----------
    A. Noll, M. Hofbauer, E. Muschter, S.-C. Li, E. Steinbach, "Automated quality assessment for compressed
    vibrotactile signals using multi-method assessment fusion", IEEE Haptics Symposium 2022. The formula
    and its constants are those documented for the authors' public package vibromaf 0.0.8.
    """
    x, y = (
        10 ** (_felt_spectrum(blocks, reference.rate, full_scale) / 10)
        for blocks in _blocks(distorted, reference)
    )
    error = np.sum(np.abs(x - y), axis=-1) / (np.sum(y, axis=-1) + TINY)
    score = (1 - np.tanh(0.3 * 10 * np.log10(np.maximum(error, 1e-30)) + 2)) / 2
    return float(np.mean(score))


def _pair(distorted: Signal, reference: Signal) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    check_alike([distorted], [reference])
    if len(distorted) != len(reference):
        raise ParameterError(
            f"signals must be equally long, got {len(distorted)} and {len(reference)} samples; align them"
        )
    return distorted.samples.astype(np.float64), reference.samples.astype(np.float64)


def _blocks(distorted: Signal, reference: Signal) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Return both in blocks, float64, shape (axis, block, time), without the remainder."""
    x, y = _pair(distorted, reference)
    length = round(BLOCK_S * reference.rate)
    if length < 2 or x.shape[1] < length:
        raise ParameterError(
            f"signals must last at least {BLOCK_S:g} s and have two samples in that time, "
            f"got {reference.seconds:.3g} s at {reference.rate:g} Hz"
        )
    whole = x.shape[1] // length * length
    first, second = (z[:, :whole].reshape(len(z), -1, length) for z in (x, y))
    return first, second


def _felt_spectrum(blocks: NDArray[np.float64], rate: float, full_scale: float) -> NDArray[np.float64]:
    """Return the level of each DCT component re the threshold, dB, scaled as in a block of 512 samples."""
    if not full_scale > 0:
        raise ParameterError(f"full_scale must be > 0, got {full_scale}")
    length = blocks.shape[-1]
    component = np.abs(fft.dct(blocks / full_scale, norm="ortho", axis=-1)) * np.sqrt(BLOCK_SAMPLES / length)
    frequency = np.arange(length) * rate / (2 * length)
    level: NDArray[np.float64] = 20 * np.log10(np.maximum(component, 1e-15)) - spqi_threshold_db(frequency)
    return level


def _standardised(blocks: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return each block without its mean and divided by its standard deviation; 0 for a constant block."""
    deviation = blocks - blocks.mean(axis=-1, keepdims=True)
    constant = np.ptp(blocks, axis=-1, keepdims=True) == 0
    return np.asarray(np.where(constant, 0.0, deviation / (blocks.std(axis=-1, keepdims=True) + TINY)))


def _similarity(reference: NDArray[np.float64], distorted: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return sum(x y) / sum(y^2) of each block; 1 where both are silent."""
    energy, other = np.sum(reference**2, axis=-1), np.sum(distorted**2, axis=-1)
    ratio = np.sum(reference * distorted, axis=-1) / (energy + TINY)
    return np.asarray(np.where((energy < TINY) & (other < TINY), 1.0, ratio))
