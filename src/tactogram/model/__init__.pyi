from .batch_share import (
    WHOLE_BATCH as WHOLE_BATCH,
    BatchShare as BatchShare,
)
from .conditions import (
    CONDITIONS as CONDITIONS,
    Condition as Condition,
    check_condition as check_condition,
    check_state as check_state,
    contactor_number as contactor_number,
    material_weights as material_weights,
    some_of as some_of,
)
from .examples import (
    Example as Example,
    ImageExample as ImageExample,
    ItemRatings as ItemRatings,
)
from .exported import (
    ExportedNetwork as ExportedNetwork,
    Port as Port,
)
from .kinds import (
    ImageKind as ImageKind,
    Kind as Kind,
    SignalKind as SignalKind,
    unit_scores as unit_scores,
)
from .limits import (
    Limit as Limit,
    limits_of as limits_of,
    limits_within as limits_within,
    word_limits as word_limits,
)
from .protocols import (
    CheckpointSelector as CheckpointSelector,
    Classifier as Classifier,
    DescriptionPredictor as DescriptionPredictor,
    Embedder as Embedder,
    FeatureReporter as FeatureReporter,
    FigureReporter as FigureReporter,
    Generator as Generator,
    Learner as Learner,
    LimitReporter as LimitReporter,
    MotionPredictor as MotionPredictor,
    NetworkExporter as NetworkExporter,
    NoiselessGenerator as NoiselessGenerator,
    NoveltyReporter as NoveltyReporter,
    OutcomeReporter as OutcomeReporter,
    PhotographClassifier as PhotographClassifier,
    PictureGenerator as PictureGenerator,
    Predictor as Predictor,
    PublishedEvaluator as PublishedEvaluator,
    RatedGenerator as RatedGenerator,
    SelectionReporter as SelectionReporter,
    SharedLearner as SharedLearner,
    SpreadReporter as SpreadReporter,
    Stage as Stage,
    TextureMapModel as TextureMapModel,
    WindowClassifier as WindowClassifier,
    WindowConfig as WindowConfig,
    feature_description as feature_description,
    window_of as window_of,
)
