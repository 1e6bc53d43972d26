"""Interface between models and the rest of the package: conditions, examples and protocols.

A model implements `Learner`, and `Generator`, `Classifier` or `Predictor`; the other protocols are optional.
"""

from tactogram.model.batch_share import WHOLE_BATCH as WHOLE_BATCH
from tactogram.model.batch_share import BatchShare as BatchShare
from tactogram.model.conditions import CONDITIONS as CONDITIONS
from tactogram.model.conditions import Condition as Condition
from tactogram.model.conditions import check_condition as check_condition
from tactogram.model.conditions import check_state as check_state
from tactogram.model.conditions import contactor_number as contactor_number
from tactogram.model.conditions import material_weights as material_weights
from tactogram.model.conditions import some_of as some_of
from tactogram.model.examples import Example as Example
from tactogram.model.examples import ImageExample as ImageExample
from tactogram.model.examples import ItemRatings as ItemRatings
from tactogram.model.exported import ExportedNetwork as ExportedNetwork
from tactogram.model.exported import Port as Port
from tactogram.model.kinds import ImageKind as ImageKind
from tactogram.model.kinds import Kind as Kind
from tactogram.model.kinds import SignalKind as SignalKind
from tactogram.model.kinds import unit_scores as unit_scores
from tactogram.model.limits import Limit as Limit
from tactogram.model.limits import limits_of as limits_of
from tactogram.model.limits import limits_within as limits_within
from tactogram.model.limits import word_limits as word_limits
from tactogram.model.protocols import CheckpointSelector as CheckpointSelector
from tactogram.model.protocols import Classifier as Classifier
from tactogram.model.protocols import DescriptionPredictor as DescriptionPredictor
from tactogram.model.protocols import Embedder as Embedder
from tactogram.model.protocols import FeatureReporter as FeatureReporter
from tactogram.model.protocols import FigureReporter as FigureReporter
from tactogram.model.protocols import Generator as Generator
from tactogram.model.protocols import Learner as Learner
from tactogram.model.protocols import LimitReporter as LimitReporter
from tactogram.model.protocols import MotionPredictor as MotionPredictor
from tactogram.model.protocols import NetworkExporter as NetworkExporter
from tactogram.model.protocols import NoiselessGenerator as NoiselessGenerator
from tactogram.model.protocols import NoveltyReporter as NoveltyReporter
from tactogram.model.protocols import OutcomeReporter as OutcomeReporter
from tactogram.model.protocols import PhotographClassifier as PhotographClassifier
from tactogram.model.protocols import PictureGenerator as PictureGenerator
from tactogram.model.protocols import Predictor as Predictor
from tactogram.model.protocols import PublishedEvaluator as PublishedEvaluator
from tactogram.model.protocols import RatedGenerator as RatedGenerator
from tactogram.model.protocols import SelectionReporter as SelectionReporter
from tactogram.model.protocols import SharedLearner as SharedLearner
from tactogram.model.protocols import SpreadReporter as SpreadReporter
from tactogram.model.protocols import Stage as Stage
from tactogram.model.protocols import TextureMapModel as TextureMapModel
from tactogram.model.protocols import WindowClassifier as WindowClassifier
from tactogram.model.protocols import WindowConfig as WindowConfig
from tactogram.model.protocols import feature_description as feature_description
from tactogram.model.protocols import window_of as window_of
