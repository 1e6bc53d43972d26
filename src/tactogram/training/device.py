"""Compute device of a training: Lightning Fabric chooses device and precision."""

from __future__ import annotations

import re
from collections.abc import Iterator
from contextlib import contextmanager
from typing import Any

from tactogram.errors import ParameterError
from tactogram.recipe import TrainingSettings


@contextmanager
def memory_checked(what: str) -> Iterator[None]:
    """Turn an error for lack of memory, on the processor or a GPU, into one line.

    Raises
    ------
    ParameterError
        Naming ``what``.
    """
    try:
        yield
    except (MemoryError, RuntimeError) as error:
        line = str(error).partition("\n")[0]
        if not isinstance(error, MemoryError) and not re.search("memory|Storage size", line):
            raise
        raise ParameterError(
            f"{what} needs more memory than there is ({line}); lower the sizes in config"
        ) from error


def make_fabric(training: TrainingSettings, *, accelerator: str = "auto", devices: int = 1) -> Any:
    """Return a launched ``lightning_fabric.Fabric`` for a recipe's precision.

    Parameters
    ----------
    training : TrainingSettings
        Its ``precision`` is used.
    accelerator : str
        Fabric's name: ``auto`` takes a GPU if there is one.
    devices : int
        Each trains on its own batches, and gradients are averaged.

    Raises
    ------
    ParameterError
        If this machine has no such device.
    """
    from lightning_fabric import Fabric

    try:
        fabric = Fabric(accelerator=accelerator, devices=devices, precision=training.precision)
    except (ValueError, RuntimeError) as error:
        line = str(error).split("\n")[0]
        raise ParameterError(f"accelerator {accelerator}, devices {devices}: {line}") from error
    fabric.launch()
    return fabric
