"""Training loop, the same for every model: batches, steps, checkpoints, and the services that log its losses."""

from __future__ import annotations

import copy
from collections.abc import Callable, Sequence
from itertools import islice
from typing import Any, Protocol

import numpy as np
import torch

from tactogram.errors import RunError, StoppedError
from tactogram.model import Example, Model, Stage
from tactogram.recipe import Recipe
from tactogram.training.forecast import FEWEST_STEPS, forecast_text
from tactogram.training.run import BEGINNING, Run, TrainingPosition
from tactogram.training.seeds import child_seed, torch_seeded

OnStep = Callable[[TrainingPosition, Stage, dict[str, float]], None]
OnStage = Callable[[TrainingPosition, Stage], None]


def fit(
    learner: Model,
    examples: Sequence[Example],
    *,
    seed: int,
    start: TrainingPosition = BEGINNING,
    fabric: Any = None,
    on_stage: OnStage = lambda position, stage: None,
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
    on_stage : function
        Called before each stage that is begun or continued, with the position.
    on_step : function
        Called after each step with the new position, the stage and its losses, e.g. to log and save.
    """
    for stage_index, stage in enumerate(learner.stages(examples)):
        if stage_index < start.stage:
            continue
        done = start.step if stage_index == start.stage else 0
        on_stage(TrainingPosition(stage_index, done), stage)
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
            on_step(TrainingPosition(stage_index, step), stage, losses)


def mean_over_processes(losses: dict[str, float], fabric: Any) -> dict[str, float]:
    """Return the means of losses over all processes."""
    if fabric is None or fabric.world_size == 1:
        return losses
    values = fabric.all_reduce(torch.tensor(list(losses.values()), device=fabric.device))
    return dict(zip(losses, values.tolist(), strict=True))


def steps_done(stages: Sequence[Stage], position: TrainingPosition) -> int:
    """Return the number of finished steps of all stages."""
    return sum(stage.steps for stage in stages[: position.stage]) + position.step


class TrainingLogger(Protocol):
    """Methods of Fabric's loggers that a training uses."""

    def log_hyperparams(self, params: dict[str, Any]) -> None:
        """Log the recipe."""

    def log_metrics(self, metrics: dict[str, float], step: int) -> None:
        """Log values after a number of steps of all stages."""

    def finalize(self, status: str) -> None:
        """End: ``status`` is ``success``, or why not."""


def run_training(
    learner: Model,
    examples: Sequence[Example],
    recipe: Recipe,
    *,
    run: Run | None = None,
    start: TrainingPosition = BEGINNING,
    fabric: Any = None,
    logger: TrainingLogger | None = None,
    trial: Callable[[], Model] | None = None,
    task: str = "",
    progress: Callable[..., None] = lambda *_: None,
    stop: Callable[[], bool] = lambda: False,
) -> None:
    """Fit ``learner``; log to ``logger`` and ``run`` and save to ``run`` where there are any, and show progress.

    ``fabric``, of the processes that train together, must come with ``run``. ``trial`` makes another learner as
    ``learner`` was at first; with it the time of the training is measured, and shown before the first update.

    Raises
    ------
    StoppedError
        If ``stop`` ended it, after the checkpoint of that step.
    """
    every = recipe.training
    stages = learner.stages(examples)

    def on_stage(position: TrainingPosition, stage: Stage) -> None:
        nonlocal trial
        if trial is None or stage.steps - position.step < FEWEST_STEPS:
            return
        tried, trial = trial(), None
        tried.load_state(copy.deepcopy(learner.state()))
        with torch_seeded(recipe.seed, "forecast"):
            text = forecast_text(tried, examples, stages[position.stage :], done=position.step)
        progress(f"{task}forecast", 1, 1, text)

    def on_step(position: TrainingPosition, stage: Any, losses: dict[str, float]) -> None:
        last = position.step == stage.steps
        due = position.step % every.log_every == 0 or last
        if logger is not None and due:
            values = {f"{stage.name}/{name}": value for name, value in losses.items()}
            logger.log_metrics(values, step=steps_done(stages, position))
        if run is not None and fabric.is_global_zero:
            if due:
                run.log(position, losses)
            if position.step % every.checkpoint_every == 0 or last:
                run.save_checkpoint(learner, position)
        note = " ".join(f"{name} {loss:.3g}" for name, loss in losses.items()) if len(losses) < 4 else ""
        progress(f"{task}{stage.name}", position.step, stage.steps, note)
        if run is not None and fabric.broadcast(stop()):
            if fabric.is_global_zero:
                run.save_checkpoint(learner, position)
            fabric.barrier()
            raise StoppedError(
                f"stopped after step {position.step} of {stage.steps} of {stage.name}; all of it is in "
                f"{run.folder}: `tactogram train --resume {run.folder}` continues it"
            )

    fit(learner, examples, seed=recipe.seed, start=start, fabric=fabric, on_stage=on_stage, on_step=on_step)
