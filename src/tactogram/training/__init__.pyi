from .checkpoint import (
    load_state as load_state,
    save_state as save_state,
)
from .forecast import (
    duration_text as duration_text,
)
from .labelled_images import (
    as_floats as as_floats,
    square as square,
)
from .loop import (
    fit as fit,
)
from .run import (
    Run as Run,
    TrainingPosition as TrainingPosition,
    open_run as open_run,
)
from .seeds import (
    child_generator as child_generator,
    child_rng as child_rng,
    child_seed as child_seed,
    surface_seed as surface_seed,
    torch_seeded as torch_seeded,
)
