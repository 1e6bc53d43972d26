from .config import (
    Config as Config,
)
from .learner import (
    build as build,
)
from .surfaces import (
    clusters_of as clusters_of,
    tree_of as tree_of,
)
