"""Lightning Fabric's strategy for several processes: gradients are averaged after each backward pass."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import torch
import torch.distributed as dist
from lightning_fabric.strategies.ddp import DDPStrategy
from torch import Tensor, nn


class AveragingStrategy(DDPStrategy):
    """Averages gradients over processes, of any number of networks and passes through them.

    `torch.nn.parallel.DistributedDataParallel` wants each network to go forward once and then backward, all weights
    included. A GAN does neither: it goes through its critic several times and around the wrapper for a gradient
    penalty, and skips the critic's gradients for its generator. Averaging after the backward pass suits any order, is
    done before gradients are limited or a scaler looks at them, and costs the overlap of computing and sending.
    """

    def __init__(self) -> None:
        super().__init__()
        self.networks: list[_Averaged] = []

    def setup_module(self, module: nn.Module) -> Any:
        """Give a network the first process's weights."""
        for tensor in (*module.parameters(), *module.buffers()):
            dist.broadcast(tensor.detach(), 0)
        self.networks.append(_Averaged(module))
        return module

    def backward(self, tensor: Tensor, module: nn.Module | None, *args: Any, **kwargs: Any) -> None:
        """Compute gradients, and average those of every network that the pass went through."""
        super().backward(tensor, module, *args, **kwargs)
        for network in self.networks:
            network.average()


class _Averaged:
    """Weights of a network, and whether the current backward pass reached any."""

    def __init__(self, network: nn.Module) -> None:
        self.weights: Sequence[nn.Parameter] = [p for p in network.parameters() if p.requires_grad]
        self.reached = False
        for weight in self.weights:
            weight.register_post_accumulate_grad_hook(self._reach)  # type: ignore[no-untyped-call]

    def _reach(self, weight: Tensor) -> None:
        self.reached = True

    @torch.no_grad()
    def average(self) -> None:
        """Replace the gradients by their means, in one message; those that no process has stay None."""
        if not self.reached:
            return
        self.reached = False
        parts = [w.new_zeros(w.numel()) if w.grad is None else w.grad.flatten() for w in self.weights]
        present = parts[0].new_tensor([float(weight.grad is not None) for weight in self.weights])
        message = torch.cat((*parts, present))
        dist.all_reduce(message)
        *means, count = torch.split(message / dist.get_world_size(), [*map(len, parts), len(self.weights)])
        for weight, mean, some in zip(self.weights, means, count.tolist(), strict=True):
            if some:
                weight.grad = mean.view_as(weight)
