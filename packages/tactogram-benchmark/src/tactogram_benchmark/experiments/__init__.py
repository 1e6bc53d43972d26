"""Experiments behind published tables and figures, one file each, found by looking.

An experiment is a module with ``run(folder, *, paper, progress)``. ``folder`` receives its artifacts, ``paper`` selects
the published size instead of one for two cores, and further keyword arguments with a default are its options; ``on``
and ``processes`` say where independent trainings run, as of `run_tasks`, by default one after the other. The result is
a dict of figures; its ``text`` is the table for readers, with published figures beside ours. It names its store as
``data`` and ``data_sha256``, or several as mappings with ``name``, ``sha256`` and ``simulated``.
"""
