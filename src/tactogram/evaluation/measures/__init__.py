"""Measures of how similar generated signals are to real ones: one function each, with its formula and source.

`signal_measures` returns the measures of two sets of signals; the others are of points in an embedding, of copies, of
labels and of pairs. ``docs/measures.md`` lists what each one detects and what it is blind to.
"""

from tactogram.evaluation.measures.distances.amplitude_distance import (
    amplitude_distance as amplitude_distance,
)
from tactogram.evaluation.measures.distances.coherence_distance import coherence as coherence
from tactogram.evaluation.measures.distances.coherence_distance import (
    coherence_distance as coherence_distance,
)
from tactogram.evaluation.measures.distances.envelope_spectrum_distance_db import (
    envelope_spectrum_distance as envelope_spectrum_distance,
)
from tactogram.evaluation.measures.distances.level_difference_db import (
    level_difference_db as level_difference_db,
)
from tactogram.evaluation.measures.distances.log_spectral_distance_db import (
    log_spectral_distance as log_spectral_distance,
)
from tactogram.evaluation.measures.distances.modulation_spectrum_distance_db import (
    modulation_spectrum_distance as modulation_spectrum_distance,
)
from tactogram.evaluation.measures.distances.weighted_log_spectral_distance_db import (
    weighted_log_spectral_distance as weighted_log_spectral_distance,
)
from tactogram.evaluation.measures.downstream import Classify as Classify
from tactogram.evaluation.measures.downstream import Fit as Fit
from tactogram.evaluation.measures.downstream import classifier_features as classifier_features
from tactogram.evaluation.measures.downstream import linear_discriminant as linear_discriminant
from tactogram.evaluation.measures.downstream import transfer_accuracy as transfer_accuracy
from tactogram.evaluation.measures.embedding import Manifold as Manifold
from tactogram.evaluation.measures.embedding import frechet_distance as frechet_distance
from tactogram.evaluation.measures.embedding import (
    precision_recall_density_coverage as precision_recall_density_coverage,
)
from tactogram.evaluation.measures.embedding import two_sample_accuracy as two_sample_accuracy
from tactogram.evaluation.measures.intervals import Accuracy as Accuracy
from tactogram.evaluation.measures.intervals import margin_of as margin_of
from tactogram.evaluation.measures.intervals import mean_interval as mean_interval
from tactogram.evaluation.measures.intervals import wilson as wilson
from tactogram.evaluation.measures.measure import Measure as Measure
from tactogram.evaluation.measures.measure import SignalMeasure as SignalMeasure
from tactogram.evaluation.measures.measure import signal_measures as signal_measures
from tactogram.evaluation.measures.memorisation import Memorisation as Memorisation
from tactogram.evaluation.measures.memorisation import memorisation as memorisation
from tactogram.evaluation.measures.memorisation import nearness as nearness
from tactogram.evaluation.measures.paired import align as align
from tactogram.evaluation.measures.paired import signal_to_noise_ratio_db as signal_to_noise_ratio_db
from tactogram.evaluation.measures.paired import spqi as spqi
from tactogram.evaluation.measures.paired import st_sim as st_sim
from tactogram.evaluation.measures.sets import segments as segments
