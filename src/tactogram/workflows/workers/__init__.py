"""Tasks on several processes of this machine, or on Ray.

Starting a worker imports this package: `kept`, which needs more, is imported by its own name.
"""

from tactogram.workflows.workers.tasks import (
    Outcome as Outcome,
    absolute as absolute,
    in_order as in_order,
    run_tasks as run_tasks,
)
