"""Envelope spectrum distance: blind to phase and level."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from tactogram.evaluation.measures.measure import Measure, check_alike, once_per_set, stacks
from tactogram.evaluation.measures.spectra import (
    MODULATION_HZ,
    SHORTEST_S,
    check_felt,
    envelopes,
    mean_modulation_db,
    modulation_edges,
    modulation_power,
    modulation_window,
)
from tactogram.signal import Signal
from tactogram.signal.perception import FELT_HZ


def envelope_spectrum_distance(one: Sequence[Signal], other: Sequence[Signal]) -> float:
    """Return the root mean square difference in dB between two mean envelope spectra, over bands and axes.

    The Hilbert envelope of a signal within 20-1000 Hz is divided by its mean; the power spectrum of that, summed
    in half octaves of 2-100 Hz, is averaged over the set in dB. A modulation of depth m at one frequency has
    10 log10(m^2 / 2) dB; less than `MODULATION_FLOOR_DB` counts as that. Blind to level and to the phase of
    carrier and modulation. Narrow bands fluctuate by themselves, so a change in bandwidth registers slightly.

    Signals last at least 0.5 s, better 1 s or more, and have equal length (`segments`): the logarithm of an average of
    few windows is up to 2.5 dB too low.

    References
    ----------
    Envelope spectra: R. B. Randall, J. Antoni, "Rolling element bearing diagnostics: a tutorial", Mech. Syst.
    Signal Process. 25 (2011) 485-520. Bands and floor are this project's choice.
    """
    kind = check_alike(one, other, shortest_s=SHORTEST_S)
    check_felt(kind.rate)
    window = modulation_window(one, other)
    first, second = (_envelope_spectrum_db(members, window) for members in (one, other))
    return float(np.sqrt(np.mean((first - second) ** 2)))


@once_per_set
def _envelope_spectrum_db(signals: Sequence[Signal], window: float) -> NDArray[np.float64]:
    edges = modulation_edges(signals[0].rate, window, MODULATION_HZ[1], per_octave=2)
    power = []
    for stack in stacks(signals):
        envelope, rate = envelopes(stack, signals[0].rate, *FELT_HZ, np.ones_like)
        power.append(modulation_power(envelope, rate, window, edges))
    return mean_modulation_db(np.concatenate(power))


MEASURE = Measure(
    "envelope_spectrum_distance_db",
    envelope_spectrum_distance,
    "dB",
    title="envelope spectrum distance",
    source="Randall & Antoni 2011",
    rank=40,
)
