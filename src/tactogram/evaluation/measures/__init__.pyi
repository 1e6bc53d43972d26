from .distances.amplitude_distance import (
    amplitude_distance as amplitude_distance,
)
from .distances.coherence_distance import (
    coherence as coherence,
    coherence_distance as coherence_distance,
)
from .distances.envelope_spectrum_distance_db import (
    envelope_spectrum_distance as envelope_spectrum_distance,
)
from .distances.level_difference_db import (
    level_difference_db as level_difference_db,
)
from .distances.log_spectral_distance_db import (
    log_spectral_distance as log_spectral_distance,
)
from .distances.modulation_spectrum_distance_db import (
    modulation_spectrum_distance as modulation_spectrum_distance,
)
from .distances.weighted_log_spectral_distance_db import (
    weighted_log_spectral_distance as weighted_log_spectral_distance,
)
from .downstream import (
    Classify as Classify,
    Fit as Fit,
    classifier_features as classifier_features,
    linear_discriminant as linear_discriminant,
    transfer_accuracy as transfer_accuracy,
)
from .embedding import (
    Manifold as Manifold,
    frechet_distance as frechet_distance,
    precision_recall_density_coverage as precision_recall_density_coverage,
    two_sample_accuracy as two_sample_accuracy,
)
from .intervals import (
    Accuracy as Accuracy,
    margin_of as margin_of,
    mean_interval as mean_interval,
    wilson as wilson,
)
from .measure import (
    Measure as Measure,
    SignalMeasure as SignalMeasure,
    segments as segments,
    signal_measures as signal_measures,
)
from .memorisation import (
    Memorisation as Memorisation,
    memorisation as memorisation,
    nearness as nearness,
)
