from .data.convert import (
    convert as convert,
    list_formats as list_formats,
    reading_parameters as reading_parameters,
)
from .data.sources import (
    SIGNAL_FORMATS as SIGNAL_FORMATS,
)
from .data.stores import (
    add_signal as add_signal,
    list_sets as list_sets,
)
from .evaluation.crossval import (
    crossval as crossval,
)
from .evaluation.evaluate import (
    evaluate as evaluate,
)
from .evaluation.mixing_ladder import (
    mix_ladder as mix_ladder,
    mixing_ladder as mixing_ladder,
    recorded as recorded,
)
from .evaluation.picture_report import (
    compare_pictures as compare_pictures,
)
from .evaluation.pictures import (
    evaluate_pictures as evaluate_pictures,
)
from .evaluation.ratings import (
    evaluate_reproduction as evaluate_reproduction,
    predicted_ratings as predicted_ratings,
)
from .evaluation.reference_models import (
    EVALUATION_SPEED_MM_S as EVALUATION_SPEED_MM_S,
    HOLDING_RECORDINGS as HOLDING_RECORDINGS,
    EvaluationSettings as EvaluationSettings,
    ReferenceModels as ReferenceModels,
    classifier_of as classifier_of,
    felt as felt,
    tactile_kind as tactile_kind,
)
from .evaluation.run_evaluation import (
    evaluate_run as evaluate_run,
)
from .evaluation.word_signals import (
    WordGenerationResult as WordGenerationResult,
    generate_rated_surfaces as generate_rated_surfaces,
)
from .generation.clone import (
    clone as clone,
)
from .generation.cloned_strokes import (
    live_map as live_map,
)
from .generation.generate import (
    SIMULATED as SIMULATED,
    Reading as Reading,
    condition_facts as condition_facts,
    generate as generate,
    limits as limits,
    motion_of as motion_of,
    run_provenance as run_provenance,
    with_materials as with_materials,
    write_made as write_made,
)
from .generation.photographs import (
    description_text as description_text,
)
from .generation.text_understanding import (
    Understanding as Understanding,
    understand as understand,
)
from .generation.word_scores import (
    ask as ask,
    some_words as some_words,
)
from .progress import (
    VARIABLE as VARIABLE,
    ProgressCallback as ProgressCallback,
    never as never,
    silent as silent,
)
from .recognition.classify import (
    classify as classify,
)
from .recognition.score import (
    score as score,
)
from .recognition.search import (
    search as search,
)
from .recognition.spectral_search import (
    find_similar as find_similar,
)
from .rendering.render import (
    levels_of as levels_of,
    list_displays as list_displays,
    render as render,
)
from .results_table import (
    evaluation_results as evaluation_results,
    numbers_of as numbers_of,
    table as table,
)
from .training.execution import (
    train_plan as train_plan,
)
from .training.loaded_run import (
    LoadedRun as LoadedRun,
    load_run as load_run,
    model_of as model_of,
    test_part as test_part,
)
from .training.model_choice import (
    model_choice as model_choice,
)
from .training.plan import (
    TrainingPlan as TrainingPlan,
    TrainingRequest as TrainingRequest,
    check_training as check_training,
)
from .training.rated_examples import (
    RatingData as RatingData,
)
from .training.recipe_fields import (
    RecipeField as RecipeField,
    assignments as assignments,
    recipe_fields as recipe_fields,
    text_of as text_of,
)
from .training.run_comparison import (
    compare_runs as compare_runs,
)
from .training.run_lock import (
    is_training as is_training,
)
from .training.surface_index import (
    SurfaceIndex as SurfaceIndex,
    calibration_text as calibration_text,
    prediction_limit as prediction_limit,
    surface_vector as surface_vector,
)
from .training.train import (
    train as train,
)
from .workers.tasks import (
    Outcome as Outcome,
    absolute as absolute,
    in_order as in_order,
    run_tasks as run_tasks,
)
