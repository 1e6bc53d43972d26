"""The measures of two sets of signals, by the name they have in results."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Protocol

from tactogram.evaluation.measures.amplitude import amplitude_distance
from tactogram.evaluation.measures.coherence import coherence_distance
from tactogram.evaluation.measures.envelope import envelope_spectrum_distance, modulation_spectrum_distance
from tactogram.evaluation.measures.spectral import (
    level_difference_db,
    log_spectral_distance,
    weighted_log_spectral_distance,
)
from tactogram.signal import Signal


class SignalMeasure(Protocol):
    """Distance of two sets of signals of one kind: symmetric, 0 on itself."""

    def __call__(self, one: Sequence[Signal], other: Sequence[Signal], /) -> float | None:
        """Return the distance, >= 0; None where it is not defined for signals of this kind."""
        ...


@dataclass(frozen=True)
class Measure:
    """A measure and what is to be said of it in a table.

    Parameters
    ----------
    function : SignalMeasure
        Lower is better.
    unit : str
        Of what it returns; ``"1"`` for a pure number.
    title : str
        For people to read.
    source : str
        Where it comes from.
    multiaxis : bool
        Whether it needs more than one axis; it returns None for one.
    """

    function: SignalMeasure
    unit: str
    title: str
    source: str
    multiaxis: bool = False


SIGNAL_MEASURES: Mapping[str, Measure] = {
    "log_spectral_distance_db": Measure(
        log_spectral_distance, "dB", "log-spectral distance", "Gray & Markel 1976"
    ),
    "weighted_log_spectral_distance_db": Measure(
        weighted_log_spectral_distance,
        "dB",
        "perceptually weighted log-spectral distance",
        "Gray & Markel 1976; threshold: Verrillo 1963",
    ),
    "level_difference_db": Measure(level_difference_db, "dB", "level difference", "this project"),
    "envelope_spectrum_distance_db": Measure(
        envelope_spectrum_distance, "dB", "envelope spectrum distance", "Randall & Antoni 2011"
    ),
    "modulation_spectrum_distance_db": Measure(
        modulation_spectrum_distance,
        "dB",
        "modulation spectrum distance",
        "Dau et al. 1997; McDermott & Simoncelli 2011",
    ),
    "amplitude_distance": Measure(
        amplitude_distance, "rms", "amplitude distribution distance", "2-Wasserstein; Villani 2009"
    ),
    "coherence_distance": Measure(
        coherence_distance, "1", "coherence distance between the axes", "Carter et al. 1973", multiaxis=True
    ),
}
"""By JSON name, the unit in it. Lower is better for all of them."""
