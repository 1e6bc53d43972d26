from .config import (
    Config as Config,
)
from .fabric_evaluation import (
    compare_fabrics as compare_fabrics,
    fabric_windows as fabric_windows,
    summary as summary,
)
from .learner import (
    FrictGANLearner as FrictGANLearner,
    build as build,
)
from .texture_free import (
    MODELS as MODELS,
)
