"""Processes of one training: what they average and agree on."""

from __future__ import annotations

import os
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Any, TypeVar

import torch
import torch.distributed as dist

from tactogram.errors import ParameterError

T = TypeVar("T")


@dataclass(frozen=True)
class Processes:
    """A process among those that train together on ``lightning_fabric.Fabric``; without one, it is alone."""

    fabric: Any = None

    @property
    def count(self) -> int:
        """Number of processes."""
        return 1 if self.fabric is None else int(self.fabric.world_size)

    @property
    def number(self) -> int:
        """Number of this process, from 0 on."""
        return 0 if self.fabric is None else int(self.fabric.global_rank)

    @property
    def first(self) -> bool:
        """Whether this is the process that writes the run."""
        return self.number == 0

    def mean(self, values: Mapping[str, float]) -> dict[str, float]:
        """Return the means over all processes of values of the same names."""
        if self.count == 1:
            return dict(values)
        total = torch.tensor(list(values.values()), dtype=torch.float32, device=self.fabric.device)
        dist.all_reduce(total)
        return dict(zip(values, (total / self.count).tolist(), strict=True))

    def any(self, flag: bool) -> bool:
        """Return whether ``flag`` is true in any process."""
        return self.mean({"flag": float(flag)})["flag"] > 0

    def agreed(self, value: T) -> T:
        """Return the first process's ``value``."""
        if self.count == 1:
            return value
        agreed: T = self.fabric.broadcast(value)
        return agreed

    def share_on_machine(self) -> tuple[int, int]:
        """Return the number of this process among those of its machine, and how many these are."""
        if self.count == 1:
            return 0, 1
        return int(self.fabric.local_rank), int(self.fabric.strategy.num_processes)

    def agreed_on_machine(self, make: Callable[[], T]) -> T:
        """Return what ``make`` returns in the first process of this machine."""
        number, _ = self.share_on_machine()
        made: list[Any] = [make() if number == 0 else None]
        if self.count > 1:
            own, made = made[0], [None] * self.count
            dist.all_gather_object(made, own)
        value: T = made[self.number - number]
        return value

    def barrier(self) -> None:
        """Wait for all processes."""
        if self.count > 1:
            self.fabric.barrier()

    def leave(self) -> None:
        """End the work together: what follows, such as a validation by the first process, is done alone."""
        if self.count > 1:
            self.fabric.barrier()
            dist.destroy_process_group()


ALONE = Processes()


def started_by_torchrun() -> bool:
    """Return whether this is one of several processes that ``torchrun`` started."""
    return "TORCHELASTIC_RUN_ID" in os.environ and "WORLD_SIZE" in os.environ


def is_first_process() -> bool:
    """Return whether this process is the only one of a training, or the first that torchrun or Fabric started."""
    return os.environ.get("RANK" if started_by_torchrun() else "LOCAL_RANK", "0") == "0"


def devices_and_nodes(devices: int, nodes: int) -> tuple[int, int]:
    """Return the processes per machine and the machines: those of torchrun, where it started this process.

    Raises `ParameterError` if others are wanted than torchrun started, or several machines without it.
    """
    if devices < 1 or nodes < 1:
        raise ParameterError(f"devices and nodes must be >= 1, got {devices} and {nodes}")
    if not started_by_torchrun():
        if nodes > 1:
            raise ParameterError(
                f"a training on {nodes} machines is started by torchrun, on each of them: torchrun --nnodes {nodes} "
                f"--nproc-per-node {devices} --rdzv-backend c10d --rdzv-endpoint HOST:29400 -m tactogram train …"
            )
        return devices, nodes
    each, all_of_them = int(os.environ["LOCAL_WORLD_SIZE"]), int(os.environ["WORLD_SIZE"])
    started = each, all_of_them // each
    if (devices, nodes) not in ((1, 1), started):
        raise ParameterError(
            f"devices and nodes must be {started[0]} and {started[1]}, as torchrun started, got {devices} and {nodes}; "
            "omit them"
        )
    return started
