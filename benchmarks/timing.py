"""Times of a job beside a plain one that is run in turn with it, so that other load weighs on both."""

from __future__ import annotations

import time
from collections.abc import Callable
from typing import Any

import numpy as np


def seconds_of(job: Callable[[], object], clock: Callable[[], float] = time.process_time) -> float:
    """Return how long a job takes, by default of processors."""
    start = clock()
    job()
    return clock() - start


def beside(plain: Callable[[], object], job: Callable[[], object], repetitions: int) -> dict[str, Any]:
    """Return the median and sd of the ratio to the plain job, and the job's median time, after a call of each."""
    plain(), job()
    times = np.array([(seconds_of(plain), seconds_of(job)) for _ in range(repetitions)])
    ratios = times[:, 1] / times[:, 0]
    return {
        "ratio": round(float(np.median(ratios)), 3),
        "ratio_sd": round(float(np.std(ratios)), 3),
        "seconds": round(float(np.median(times[:, 1])), 4),
    }
