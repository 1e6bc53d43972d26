"""Coherence distance between axes: blind to level and phase."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.lib.stride_tricks import sliding_window_view
from numpy.typing import NDArray
from scipy import fft
from scipy.signal import get_window

from tactogram.evaluation.measures.measure import Measure, check_alike, once_per_set, stacks
from tactogram.evaluation.measures.spectra import BAND_HZ, SEGMENT_S, check_band
from tactogram.signal import Signal

NEGLIGIBLE = 1e-6
"""Power added to each axis, as a share of its strongest bin: below this, nothing is coherent."""


def coherence_distance(
    one: Sequence[Signal], other: Sequence[Signal], *, band: tuple[float, float] = BAND_HZ
) -> float | None:
    """Return the root mean square difference between two sets' coherences, over frequency and pairs of axes.

    Magnitude-squared coherence abs(S_xy)^2 / (S_xx S_yy) of each pair of axes (`coherence`), 0..1. Blind to
    level, to the phase between axes, to the spectrum and to everything within one axis.

    Both sets need signals of at least 0.25 s, of equal length and number (`segments`): the coherence of independent
    axes is 1/K on average when estimated from K segments. ``band`` is in Hz. The result is in 0..1; None for signals
    with one axis.

    References
    ----------
    G. C. Carter, C. H. Knapp, A. H. Nuttall, "Estimation of the magnitude-squared coherence function via
    overlapped fast Fourier transform processing", IEEE Trans. Audio Electroacoust. 21 (1973) 337-344.
    """
    axes = len(check_alike(one, other, shortest_s=SEGMENT_S).axes)
    if axes == 1:
        return None
    frequency, first = coherence(one)
    _, second = coherence(other)
    difference = (first - second)[np.triu_indices(axes, 1)][:, check_band(frequency, band)]
    return float(np.sqrt(np.mean(difference**2)))


@once_per_set
def coherence(signals: Sequence[Signal]) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Return frequencies, Hz, and the magnitude-squared coherence of all pairs of axes, shape (axis, axis, frequency).

    Cross spectra (Hann segments of 0.25 s, half overlapping) are averaged over all segments of all signals, each
    signal divided by its own power, so that strong and weak signals count the same.
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


MEASURE = Measure(
    "coherence_distance",
    coherence_distance,
    "1",
    title="coherence distance between the axes",
    source="Carter et al. 1973",
    multiaxis=True,
    rank=70,
)
