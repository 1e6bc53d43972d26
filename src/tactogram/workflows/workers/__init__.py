"""Tasks on several processes of this machine, or on Ray.

Starting a worker imports this package: `kept`, which needs more, is imported by its own name.
"""

from tactogram.workflows.workers.tasks import Outcome as Outcome
from tactogram.workflows.workers.tasks import absolute as absolute
from tactogram.workflows.workers.tasks import in_order as in_order
from tactogram.workflows.workers.tasks import run_tasks as run_tasks
