from .raters.scoring import (
    draw_people as draw_people,
    score_together as score_together,
    score_vibrations as score_vibrations,
)
from .sets import (
    SETS as SETS,
    make as make,
    simulated_sets as simulated_sets,
    tasks as tasks,
)
from .tactile_images import (
    FAMILIES as FAMILIES,
    tactile_image as tactile_image,
)
from .workflows.demo import (
    demo as demo,
)
from .workflows.simulate import (
    simulate_to_store as simulate_to_store,
)
