"""Lightning Fabric's strategy for several processes: gradients are averaged after each backward pass."""

from __future__ import annotations

from datetime import timedelta
from typing import Any

import torch
import torch.distributed as dist
from lightning_fabric.strategies.ddp import DDPStrategy
from torch import Tensor, nn


class AveragingStrategy(DDPStrategy):
    """Averages gradients over the processes after each backward pass, of any number of networks.

    `torch.nn.parallel.DistributedDataParallel` wants each network to go forward once and then backward, all weights
    included. A GAN does neither: it goes through its critic several times and around the wrapper for a gradient
    penalty, and skips the critic's gradients for its generator.
    """

    def __init__(self) -> None:
        super().__init__(timeout=timedelta(days=1))  # the others wait while the first prepares recordings
        self.weights: list[nn.Parameter] = []

    def setup_module(self, module: nn.Module) -> Any:
        """Give a network the first process's weights."""
        for tensor in (*module.parameters(), *module.buffers()):
            dist.broadcast(tensor.detach(), 0)
        self.weights += module.parameters()
        return module

    def backward(self, tensor: Tensor, module: nn.Module | None, *args: Any, **kwargs: Any) -> None:
        """Compute gradients, and replace those of all networks by their means."""
        super().backward(tensor, module, *args, **kwargs)
        for weight in self.weights:
            if weight.requires_grad:
                grad = torch.zeros_like(weight) if weight.grad is None else weight.grad
                weight.grad = self.all_reduce(grad, reduce_op="mean")
