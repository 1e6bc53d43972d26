from .checkpoint_selection import (
    SelectionRule as SelectionRule,
    choose as choose,
    smoothed as smoothed,
)
from .figures import (
    confusion_figure as confusion_figure,
)
from .generation.comparison import (
    CEILING as CEILING,
    FLOOR as FLOOR,
    MODEL as MODEL,
    GenerationResult as GenerationResult,
    PiecePlan as PiecePlan,
    describe_measures as describe_measures,
    plan_pieces as plan_pieces,
)
from .generation.protocol import (
    evaluate_generation as evaluate_generation,
)
from .generation.spectrogram_figures import (
    spectrograms_figure as spectrograms_figure,
)
from .measures.distances.log_spectral_distance_db import (
    log_spectral_distance as log_spectral_distance,
)
from .measures.downstream import (
    classifier_features as classifier_features,
    linear_discriminant as linear_discriminant,
)
from .measures.intervals import (
    margin_of as margin_of,
    mean_interval as mean_interval,
    wilson as wilson,
)
from .measures.measure import (
    signal_measures as signal_measures,
)
from .mixing.placement import (
    OVERALL as OVERALL,
    IndistinctEndsError as IndistinctEndsError,
    positions as positions,
)
from .pictures.distances import (
    MEASURES as MEASURES,
    ImageQuality as ImageQuality,
    ImageSpread as ImageSpread,
    PictureWeights as PictureWeights,
)
from .pictures.figures import (
    COLOURS as COLOURS,
    GeneratorRow as GeneratorRow,
    generated_figure as generated_figure,
)
from .ratings.prediction import (
    one_rater_error as one_rater_error,
    split_half_error as split_half_error,
)
from .ratings.reproduction import (
    NEAREST as NEAREST,
    STRAIGHT as STRAIGHT,
    LabelFidelity as LabelFidelity,
    label_fidelity as label_fidelity,
    reproduction as reproduction,
)
from .report import (
    Block as Block,
    ReportFigure as ReportFigure,
    ReportSection as ReportSection,
    ReportSound as ReportSound,
    ReportTable as ReportTable,
    ReportText as ReportText,
    save_figure as save_figure,
    write_report as write_report,
)
