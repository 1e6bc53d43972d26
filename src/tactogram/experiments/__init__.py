"""One file per published table or figure, found by looking: ``run(jobs, folder, *, paper)`` gives its figures.

``jobs`` is `_jobs.Jobs`: jobs stand above experiments and are handed down. ``paper`` asks for the published size
instead of one for two cores. Further keyword arguments with a default are options of the experiment. The result holds
``text``, the table as one reads it, published beside ours.
"""
