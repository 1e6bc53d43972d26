"""Training loop, the same for every model, and the services that its losses are logged to."""

from __future__ import annotations

import os
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from itertools import islice
from pathlib import Path
from typing import Any, Protocol
from uuid import uuid4

import numpy as np
import torch

from tactogram.errors import RunError
from tactogram.extras import imported
from tactogram.model import Example, Model, Stage
from tactogram.signal.io.atomic import write_text
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


class TrainingLogger(Protocol):
    """Methods of Fabric's loggers that a training uses."""

    def log_hyperparams(self, params: dict[str, Any]) -> None:
        """Log the recipe."""

    def log_metrics(self, metrics: dict[str, float], step: int) -> None:
        """Log values after a number of steps of all stages."""

    def finalize(self, status: str) -> None:
        """End: ``status`` is ``success``, or why not."""


def make_logger(name: str, folder: Path, *, start: int) -> TrainingLogger:
    """Return the logger ``tensorboard`` or ``wandb`` for the run in ``folder``.

    TensorBoard's events are in the folder ``tensorboard`` of the run; Weights & Biases receives the run under the
    folder's name, in the project ``tactogram`` or that of its variable ``WANDB_PROJECT``.

    ``start``: finished steps of all stages; what a killed training logged after them is replaced.

    Raises `MissingExtraError` if its package is not installed.
    """
    check_logger(name)
    if name == "tensorboard":
        from lightning_fabric.loggers.tensorboard import TensorBoardLogger

        return TensorBoardLogger(folder, name="", version="tensorboard", purge_step=start or None)
    return WandbLogger(folder)


def check_logger(name: str) -> None:
    """Raise a `MissingExtraError` if a logger's package is not installed."""
    package = {"tensorboard": "tensorboardX", "wandb": "wandb"}[name]
    imported(package, extra="loggers", what=f"the logger {name}")


class WandbLogger:
    """Weights & Biases, which Fabric has no logger for; its variables, such as ``WANDB_MODE=offline``, hold."""

    def __init__(self, folder: Path) -> None:
        wandb = imported("wandb", extra="loggers", what="the logger wandb")
        known = folder / "wandb-id.txt"
        id = known.read_text() if known.exists() else uuid4().hex
        self._run: Any = wandb.init(
            project=os.environ.get("WANDB_PROJECT", "tactogram"),
            name=folder.resolve().name,
            id=id,
            dir=folder,
            resume="allow",
        )
        write_text(known, id)

    def log_hyperparams(self, params: dict[str, Any]) -> None:
        """Log the recipe."""
        self._run.config.update(params, allow_val_change=True)

    def log_metrics(self, metrics: Mapping[str, float], step: int) -> None:
        """Log values after a number of steps."""
        self._run.log(dict(metrics), step=step)

    def finalize(self, status: str) -> None:
        """End."""
        self._run.finish(exit_code=0 if status == "success" else 1)
