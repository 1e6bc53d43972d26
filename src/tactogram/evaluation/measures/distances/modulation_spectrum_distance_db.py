"""Modulation spectrum distance: blind to phase and level."""

from __future__ import annotations

from collections.abc import Callable, Sequence

import numpy as np
from numpy.typing import NDArray

from tactogram.evaluation.measures.measure import Measure, check_alike, once_per_set, stacks
from tactogram.evaluation.measures.spectra import (
    MODULATION_HZ,
    SHORTEST_S,
    SILENT,
    check_felt,
    envelopes,
    felt_floor_db,
    felt_weight,
    mean_modulation_db,
    modulation_edges,
    modulation_power,
    modulation_window,
)
from tactogram.signal import Signal

CENTRES_HZ = tuple(40.0 * 2.0**k for k in range(5))
"""Centres of the carrier bands, Hz. Each band reaches from half to twice its centre; together they
cover `FELT_HZ` and their powers add up to the signal's."""


def modulation_spectrum_distance(one: Sequence[Signal], other: Sequence[Signal]) -> float:
    """Return the root mean square difference in dB between two modulation spectra, over both frequencies and axes.

    Like `envelope_spectrum_distance`, but by carrier: the Hilbert envelope of each octave-wide band (`CENTRES_HZ`,
    half-cosine on a logarithmic scale) is divided by its mean, and its power is summed in octaves from 2 Hz to
    half the band's centre, 100 Hz at most. sqrt(sum w D^2 / sum w), where w is by how many dB a carrier band,
    weighted with the shape of the detection threshold, is above a floor 50 dB below the strongest, in whichever set
    has more: absent bands do not count. Blind to level, phase, and to correlation between bands.

    References
    ----------
    T. Dau, B. Kollmeier, A. Kohlrausch, J. Acoust. Soc. Am. 102 (1997) 2892-2905: modulation filter bank.
    J. H. McDermott, E. P. Simoncelli, "Sound texture perception via statistics of the auditory periphery",
    Neuron 71 (2011) 926-940: modulation power per band, normalised by the band's envelope. The carrier bands
    are ours: touch has no cochlea.
    """
    kind = check_alike(one, other, shortest_s=SHORTEST_S)
    check_felt(kind.rate)
    window = modulation_window(one, other)
    centres = tuple(c for c in CENTRES_HZ if c * np.sqrt(2) <= kind.rate / 2) or CENTRES_HZ[:1]
    first, second = (_modulation_spectrum(members, window, centres) for members in (one, other))
    weight_db = 10 * np.log10(felt_weight(np.array(centres), kind.unit))
    levels = np.maximum(first[1], second[1]) + weight_db  # axis, carrier
    # Only a relative floor: like the measure, the weight is blind to level.
    weight = np.maximum(levels - felt_floor_db("1", levels), 0)
    squares = np.stack(
        [np.sum((a - b) ** 2, axis=1) for a, b in zip(first[0], second[0], strict=True)], axis=1
    )
    counts = np.array([spectrum.shape[1] for spectrum in first[0]])
    return float(np.sqrt(np.sum(weight * squares) / np.sum(weight * counts)))


@once_per_set
def _modulation_spectrum(
    signals: Sequence[Signal], window: float, centres: Sequence[float]
) -> tuple[list[NDArray[np.float64]], NDArray[np.float64]]:
    """Return a set's mean modulation spectrum and levels by carrier.

    Spectra: one per carrier, shape (axis, modulation band), dB. Levels:
    mean square of the envelope, dB, shape (axis, carrier).
    """
    full_rate = signals[0].rate
    edges = [modulation_edges(full_rate, window, min(c / 2, MODULATION_HZ[1]), per_octave=1) for c in centres]
    power: list[list[NDArray[np.float64]]] = [[] for _ in centres]
    square = np.zeros((len(signals[0].axes), len(centres)))
    for stack in stacks(signals):
        for band, centre in enumerate(centres):
            envelope, rate = envelopes(stack, full_rate, centre / 2, centre * 2, _half_cosine(centre))
            power[band].append(modulation_power(envelope, rate, window, edges[band]))
            square[:, band] += np.mean(envelope**2, axis=-1).sum(axis=0)
    levels = 10 * np.log10(np.maximum(square / len(signals), SILENT))
    return [mean_modulation_db(np.concatenate(members)) for members in power], levels


def _half_cosine(centre: float) -> Callable[[NDArray[np.float64]], NDArray[np.float64]]:
    return lambda frequency: np.cos(np.pi / 2 * np.clip(np.log2(frequency / centre), -1, 1))


MEASURE = Measure(
    "modulation_spectrum_distance_db",
    modulation_spectrum_distance,
    "dB",
    title="modulation spectrum distance",
    source="Dau et al. 1997; McDermott & Simoncelli 2011",
    rank=50,
)
