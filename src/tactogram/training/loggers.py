"""Loggers of other programs: losses and validation of a training, for TensorBoard or Weights & Biases."""

from __future__ import annotations

import os
from collections.abc import Mapping
from pathlib import Path
from typing import Any, Protocol
from uuid import uuid4

from tactogram.extras import imported
from tactogram.signal.io.atomic import write_text


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
