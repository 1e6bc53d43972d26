"""Forecast of the time that a training takes on this machine."""

from __future__ import annotations

import time
from collections.abc import Callable, Sequence
from itertools import islice

import numpy as np

from tactogram.model import Example, Model, Stage

TRIED_STEPS = 5
"""Steps of each stage that are timed; the first, which allocates memory, is left out."""
FEWEST_STEPS = 100
"""A stage of fewer steps is not forecast: it would be over soon after its trial."""
LONGEST_TRIAL_S = 5.0
"""A stage is not tried for longer than its second step needs to end, s."""


def forecast_text(
    trial: Model,
    examples: Sequence[Example],
    stages: Sequence[Stage],
    *,
    done: int = 0,
    clock: Callable[[], float] = time.monotonic,
) -> str:
    """Return how long ``stages``, of which the first has ``done`` steps, will take, as measured by steps of ``trial``.

    ``trial`` has the state of the learner that is trained, and is of no use afterwards. Short stages are not forecast;
    "" if all are short.
    """
    times = []
    for stage in stages:
        left, done = stage.steps - done, 0
        if left >= FEWEST_STEPS:
            seconds = left * _step_seconds(trial, examples, stage, clock)
            times.append(f"{stage.name} {'at most' if stage.skippable else 'about'} {duration_text(seconds)}")
    return f"{', '.join(times)} on this machine" if times else ""


def _step_seconds(
    trial: Model, examples: Sequence[Example], stage: Stage, clock: Callable[[], float]
) -> float:
    """Return the mean time of a step, batch included, after the first."""
    times = [clock()]
    for batch in islice(trial.batches(stage, examples, seed=0), TRIED_STEPS):
        trial.step(stage, batch)
        times.append(clock())
        if len(times) > 2 and times[-1] - times[0] > LONGEST_TRIAL_S:
            break
    steps = np.diff(times)
    return float(np.mean(steps[1:] if len(steps) > 1 else steps)) if len(steps) else 0.0


def duration_text(seconds: float) -> str:
    """Return a time with its unit: ``8 s``, ``12 min``, ``3.5 h``."""
    if seconds < 90:
        return f"{max(1, round(seconds))} s"
    return f"{seconds / 60:.0f} min" if seconds < 5400 else f"{seconds / 3600:.1f} h"
