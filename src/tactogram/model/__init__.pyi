from .batch_share import (
    WHOLE_BATCH as WHOLE_BATCH,
    BatchShare as BatchShare,
)
from .conditions import (
    Condition as Condition,
    ConditionOption as ConditionOption,
    ConditionType as ConditionType,
    check_condition as check_condition,
    check_options as check_options,
    check_state as check_state,
    check_values as check_values,
    condition_options as condition_options,
    condition_types as condition_types,
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
