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
from .kinds import (
    ImageKind as ImageKind,
    Kind as Kind,
    Limit as Limit,
    SignalKind as SignalKind,
    limits_of as limits_of,
    limits_within as limits_within,
    unit_scores as unit_scores,
    word_limits as word_limits,
)
from .model import (
    ExportedNetwork as ExportedNetwork,
    Model as Model,
    ModelConfig as ModelConfig,
    Port as Port,
    Stage as Stage,
)
from .state import (
    Saved as Saved,
)
