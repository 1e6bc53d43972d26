"""Tasks on several processes of this machine, or on Ray."""

from tactogram.workflows.workers.outcome import Outcome as Outcome
from tactogram.workflows.workers.page import followed as followed
from tactogram.workflows.workers.tasks import run_tasks as run_tasks
