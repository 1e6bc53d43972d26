"""Compute device of a training: Lightning Fabric chooses device and precision."""

from __future__ import annotations

import logging
import os
import re
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from functools import cached_property
from typing import Any, TypeVar

from tactogram.errors import ParameterError, RunError
from tactogram.main_script import start_worker
from tactogram.recipe import TrainingSettings

T = TypeVar("T")


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
        line = first_line(error)
        if not isinstance(error, MemoryError) and not re.search("memory|Storage size", line):
            raise
        raise ParameterError(
            f"{what} needs more memory than there is ({line}); lower the sizes in config"
        ) from error


class OneProcess:
    """The only process of a training: Fabric, which takes seconds to import, once a network is handed to it."""

    is_global_zero, global_rank, world_size = True, 0, 1

    def __init__(self, make: Callable[[], Any]) -> None:
        self._make = make

    def __getattr__(self, name: str) -> Any:
        return getattr(self._fabric, name)

    @cached_property
    def _fabric(self) -> Any:
        return self._make()

    def broadcast(self, value: T) -> T:
        """Return a value as the first process has it."""
        return value

    def barrier(self) -> None:
        """Wait for the other processes: there are none."""


def make_fabric(training: TrainingSettings, *, accelerator: str = "auto", devices: int = 1) -> Any:
    """Return a launched ``lightning_fabric.Fabric`` for a recipe's precision, or a `OneProcess` that makes it.

    Of ``training`` its ``precision`` is used. ``accelerator`` is Fabric's name: ``auto`` takes a GPU if there is one.
    ``devices``: processes of this machine, each with its device, of which Fabric starts the further ones; each trains
    on its share of a batch, and gradients are averaged.

    Raises `ParameterError` if this machine has no such device; `RunError` if the processes cannot connect.
    """
    if devices < 1:
        raise ParameterError.must("devices", "be >= 1", devices)
    if devices == 1 and accelerator in ("auto", "cpu"):
        return OneProcess(lambda: _launched(training, accelerator, devices))
    return _launched(training, accelerator, devices)


def _launched(training: TrainingSettings, accelerator: str, devices: int) -> Any:
    from lightning_fabric import Fabric
    from lightning_fabric.utilities.exceptions import MisconfigurationException

    from tactogram.training.averaging import AveragingStrategy

    logging.getLogger("lightning_fabric").setLevel(
        logging.WARNING
    )  # it announces processes and number formats
    precision: Any = chosen_precision(training.precision, accelerator)
    strategy = AveragingStrategy() if devices > 1 else "auto"
    try:
        fabric = Fabric(accelerator=accelerator, devices=devices, strategy=strategy, precision=precision)
    except (ValueError, RuntimeError, MisconfigurationException) as error:
        raise ParameterError(f"accelerator {accelerator}, devices {devices}: {first_line(error)}") from error
    if is_first_process():
        os.environ["TACTOGRAM_FIRST_PROCESS"] = str(os.getpid())
    else:
        start_worker(parent_id=int(os.environ.get("TACTOGRAM_FIRST_PROCESS", os.getppid())))
    try:
        fabric.launch()
    except (RuntimeError, OSError) as error:
        raise RunError(
            f"the {devices} processes of the training cannot connect: {first_line(error)}"
        ) from error
    return fabric


def is_first_process() -> bool:
    """Return whether this process is the only one of a training, or the first of those that Fabric started."""
    return os.environ.get("LOCAL_RANK", "0") == "0"


def chosen_precision(precision: str, accelerator: str = "auto") -> str:
    """Return Fabric's name of the number format on this machine (`TrainingSettings.precision`)."""
    import torch

    if precision != "auto":
        return precision
    if accelerator != "cpu" and torch.cuda.is_available():
        fast = torch.cuda.is_bf16_supported(including_emulation=False)
    else:
        fast = bool(torch.cpu.get_capabilities().get("amx_bf16"))
    return "bf16-mixed" if fast else "32-true"


def first_line(error: Exception) -> str:
    """Return the first line of an error's message."""
    return str(error).partition("\n")[0]
