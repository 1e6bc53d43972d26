"""Options for work on several processes or machines."""

from tactogram.workflows.request import Option

ON = Option("engine: ray starts Ray on this machine, ray:ADDRESS takes a cluster", "ray[:ADDRESS]")
PROCESSES = Option("processes of this machine (default: one per core; on a GPU one)", "N", least=1)
SWEEP_ON = Option("engine of a sweep: Ray on this machine, or ray:ADDRESS for a cluster", "ray[:ADDRESS]")
