"""One file per published table or figure, found by looking: ``run(jobs, folder, *, paper)`` gives its figures.

``jobs`` has the jobs that an experiment calls (``simulate``, ``crossval``, ``train``, ``evaluate``); they stand
above experiments and are handed down. ``paper`` asks for the published size instead of one for two cores.
The result holds ``text``, the table as one reads it, published beside ours.
"""
