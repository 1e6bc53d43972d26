from .config import (
    Config as Config,
)
from .fabric_evaluation import (
    MODELS as MODELS,
    compare_fabrics as compare_fabrics,
    fabric_windows as fabric_windows,
    summary as summary,
)
from .learner import (
    FrictGANLearner as FrictGANLearner,
    build as build,
)
