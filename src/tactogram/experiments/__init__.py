"""One file per published table or figure, found by looking: ``run(jobs, folder, *, paper)`` gives its figures.

``jobs`` has the jobs that an experiment calls (``simulate``, ``crossval``, ``train``, ``evaluate``, ``generate``,
``judge_pictures``, ``compare_pictures``, ``mixing_ladder``, ``recorded``, ``load_run``, ``score`` and more: see
``jobs.reproduce.Jobs``); they stand above experiments and are handed down. ``paper`` asks for the published size
instead of one for two cores. Further keyword arguments with a default are options of the experiment. The result holds
``text``, the table as one reads it, published beside ours.
"""
