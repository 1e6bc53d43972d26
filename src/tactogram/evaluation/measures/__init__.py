"""Measures of how like generated signals are to real ones: one function each, with its formula and source.

`SIGNAL_MEASURES` holds those of two sets of signals; the others are of points in an embedding, of copies, of
labels and of pairs. ``docs/measures.md`` says what each sees and what it is blind to.
"""

from tactogram.evaluation.measures.amplitude import amplitude_distance as amplitude_distance
from tactogram.evaluation.measures.coherence import coherence as coherence
from tactogram.evaluation.measures.coherence import coherence_distance as coherence_distance
from tactogram.evaluation.measures.envelope import envelope_spectrum_distance as envelope_spectrum_distance
from tactogram.evaluation.measures.envelope import (
    modulation_spectrum_distance as modulation_spectrum_distance,
)
from tactogram.evaluation.measures.sets import segments as segments
from tactogram.evaluation.measures.signal_measures import SIGNAL_MEASURES as SIGNAL_MEASURES
from tactogram.evaluation.measures.signal_measures import Measure as Measure
from tactogram.evaluation.measures.signal_measures import SignalMeasure as SignalMeasure
from tactogram.evaluation.measures.spectral import level_difference_db as level_difference_db
from tactogram.evaluation.measures.spectral import log_spectral_distance as log_spectral_distance
from tactogram.evaluation.measures.spectral import (
    weighted_log_spectral_distance as weighted_log_spectral_distance,
)
