"""Cross-axis coherence distance of two sets of signals: blind to level and phase."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.lib.stride_tricks import sliding_window_view
from numpy.typing import NDArray
from scipy import fft
from scipy.signal import get_window

from tactogram.errors import ParameterError
from tactogram.evaluation.measures.sets import check_alike, stacks
from tactogram.evaluation.measures.spectral import BAND_HZ, SEGMENT_S
from tactogram.signal import Signal

NEGLIGIBLE = 1e-6
"""Power that is added to each axis, as a share of its strongest bin: where there is less, nothing is coherent."""


def coherence_distance(
    one: Sequence[Signal], other: Sequence[Signal], *, band: tuple[float, float] = BAND_HZ
) -> float | None:
    """Return the root mean square difference of two sets' coherences, over frequency and pairs of axes.

    Magnitude-squared coherence abs(S_xy)^2 / (S_xx S_yy) of each pair of axes (`coherence`), 0..1. Blind to
    level, to the phase between axes, to the spectrum and to everything within one axis.

    Parameters
    ----------
    one, other : sequence of Signal
        All of one rate, unit and set of axes, over time, at least 0.25 s long. Of equal length and number
        (`segments`): the coherence of independent axes is 1/K on average when estimated from K segments.
    band : (float, float), Hz
        What is compared; cut to what the rate holds.

    Returns
    -------
    float or None
        0..1; None where there is one axis only.

    Raises
    ------
    ParameterError
        If the signals are not of one kind, too short, or the band holds nothing.

    References
    ----------
    G. C. Carter, C. H. Knapp, A. H. Nuttall, "Estimation of the magnitude-squared coherence function via
    overlapped fast Fourier transform processing", IEEE Trans. Audio Electroacoust. 21 (1973) 337-344.
    """
    kind = check_alike(one, other, shortest_s=SEGMENT_S)
    axes = len(kind.axes)
    if axes == 1:
        return None
    frequency, first = coherence(one)
    _, second = coherence(other)
    kept = (frequency >= band[0]) & (frequency <= band[1])
    if not kept.any():
        raise ParameterError(
            f"band must hold a frequency below {frequency[-1]:g} Hz, got {band[0]:g} {band[1]:g}"
        )
    pairs = np.triu_indices(axes, 1)
    difference = (first - second)[pairs][:, kept]
    return float(np.sqrt(np.mean(difference**2)))


def coherence(signals: Sequence[Signal]) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Return the magnitude-squared coherence of all pairs of axes of a set.

    Cross spectra (Hann segments of 0.25 s, half overlapping) are averaged over all segments of all signals, each
    signal divided by its own power, so that a strong one counts no more than a weak one.

    Parameters
    ----------
    signals : sequence of Signal
        Of one kind, at least 0.25 s long.

    Returns
    -------
    frequency : float64 array, shape (frequency,), Hz
    coherence : float64 array, shape (axis, axis, frequency), 0..1
    """
    rate, axes = signals[0].rate, len(signals[0].axes)
    length = round(SEGMENT_S * rate)
    window = get_window("hann", length)
    spectra = np.zeros((axes, axes, length // 2 + 1), np.complex128)
    for stack in stacks(signals):
        frames = sliding_window_view(stack, length, axis=-1)[:, :, :: length - length // 2]
        z = fft.rfft((frames - frames.mean(axis=-1, keepdims=True)) * window, axis=-1)
        cross = np.einsum("saif,sbif->sabf", z, z.conj())
        power = np.einsum("saaf->s", cross).real[:, None, None, None]
        spectra += np.divide(cross, power, out=np.zeros_like(cross), where=power > 0).sum(axis=0)
    own = np.einsum("aaf->af", spectra).real
    own = own + NEGLIGIBLE * own.max(axis=1, keepdims=True)
    product = own[:, None] * own[None]
    shared = np.divide(np.abs(spectra) ** 2, product, out=np.zeros_like(product), where=product > 0)
    return fft.rfftfreq(length, 1 / rate), shared
