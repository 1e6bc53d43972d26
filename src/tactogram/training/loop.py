"""Training loop, the same for every model."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from itertools import islice
from typing import Any

import numpy as np
import torch

from tactogram.errors import RunError
from tactogram.model import Example, Model, Stage
from tactogram.training.seeds import child_seed, torch_seeded


@dataclass(frozen=True)
class TrainingPosition:
    """Position in a training: ``step`` finished steps of stage number ``stage``."""

    stage: int = 0
    step: int = 0


BEGINNING = TrainingPosition()

OnStep = Callable[[TrainingPosition, Stage, dict[str, float]], None]


def fit(
    learner: Model,
    examples: Sequence[Example],
    *,
    seed: int,
    start: TrainingPosition = BEGINNING,
    fabric: Any = None,
    on_step: OnStep = lambda position, stage, losses: None,
) -> None:
    """Train ``learner`` on ``examples`` from ``start`` to the end of its last stage.

    Batch k and the random numbers of step k depend on ``seed``, stage and k alone, so that a resumed training equals an
    uninterrupted one.

    Raises `RunError` if a loss is not finite.

    Parameters
    ----------
    examples : sequence of Example
        The training part.
    start : TrainingPosition
        Position of the state of ``learner``.
    fabric : lightning_fabric.Fabric, optional
        Of the processes that train together. A learner's batches are shares of the same ones in all of them; the random
        numbers of a step are others in each, except in a stage of one step, which every process computes alone.
    on_step : function
        Called after each step with the new position, the stage and its losses, e.g. to log and save.
    """
    for place, stage in enumerate(learner.stages(examples)):
        if place < start.stage:
            continue
        done = start.step if place == start.stage else 0
        batches = learner.batches(
            stage, examples, seed=child_seed(seed, "batches", stage.name, 0), start=done
        )
        for step, batch in enumerate(islice(batches, stage.steps - done), start=done + 1):
            number = fabric.global_rank if fabric is not None and stage.steps > 1 else 0
            with torch_seeded(seed, "step", stage.name, number, step):
                losses = mean_over_processes(learner.step(stage, batch), fabric)
            if not all(np.isfinite(loss) for loss in losses.values()):
                shown = ", ".join(f"{name} {loss:g}" for name, loss in losses.items())
                raise RunError(
                    f"training diverged at step {step} of {stage.name}: {shown}; lower the learning rate"
                )
            on_step(TrainingPosition(place, step), stage, losses)


def mean_over_processes(losses: dict[str, float], fabric: Any) -> dict[str, float]:
    """Return the means of losses over all processes."""
    if fabric is None or fabric.world_size == 1:
        return losses
    values = fabric.all_reduce(torch.tensor(list(losses.values()), device=fabric.device))
    return dict(zip(losses, values.tolist(), strict=True))
