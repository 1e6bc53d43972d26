"""Batch normalisation over the whole batch, where several processes each have an equal share of it.

`torch.nn.SyncBatchNorm` runs on GPUs alone, and has no second derivative, which gradient penalties need.
"""

from __future__ import annotations

from typing import Any

import torch
import torch.distributed as dist
from torch import Tensor, nn
from torch.nn.modules.batchnorm import _BatchNorm


class SynchronisedBatchNorm(_BatchNorm):
    """Batch normalisation whose means and variances in training are those of all processes' rows."""

    def _check_input_dim(self, input: Tensor) -> None:
        """Accept any number of dimensions."""

    def forward(self, input: Tensor) -> Tensor:
        """Return ``input``, (batch, channel, …), normalised; the batch has as many rows in every process."""
        if not (self.training and dist.is_initialized()):
            return super().forward(input)
        x = input.to(torch.promote_types(input.dtype, torch.float32))
        over = [0, *range(2, x.dim())]
        own = torch.stack(torch.var_mean(x, over, correction=0))  # variance and mean; C
        number, none = dist.get_rank(), x.new_zeros((dist.get_world_size(), *own.shape))
        each = _summed(torch.cat((none[:number], own[None], none[number + 1 :])))  # process, 2, C
        mean = each[:, 1].mean(0)
        variance = each[:, 0].mean(0) + (each[:, 1] - mean).square().mean(0)
        self._follow(mean.detach(), variance.detach(), x.numel() // x.shape[1] * len(each))
        shape = (1, -1, *[1] * (x.dim() - 2))
        x = (x - mean.view(shape)) * (variance.view(shape) + self.eps).rsqrt()
        if self.affine:
            x = x * self.weight.view(shape) + self.bias.view(shape)
        return x.to(input.dtype)

    @torch.no_grad()
    def _follow(self, mean: Tensor, variance: Tensor, count: int) -> None:
        """Update the running statistics, as `torch.nn.BatchNorm2d` does."""
        if self.running_mean is None or self.running_var is None or self.num_batches_tracked is None:
            return
        self.num_batches_tracked.add_(1)
        share = 1 / self.num_batches_tracked.item() if self.momentum is None else self.momentum
        self.running_mean.lerp_(mean, share)
        self.running_var.lerp_(variance * (count / max(1, count - 1)), share)


def synchronise(network: nn.Module) -> None:
    """Replace each batch normalisation in ``network`` by a `SynchronisedBatchNorm` of the same weights."""
    for parent in list(network.modules()):
        for name, child in parent.named_children():
            if type(child) in (nn.BatchNorm1d, nn.BatchNorm2d, nn.BatchNorm3d):
                replaced = SynchronisedBatchNorm.__new__(SynchronisedBatchNorm)
                replaced.__dict__ = vars(child)
                setattr(parent, name, replaced)


class _Sum(torch.autograd.Function):
    """Sum over all processes; its gradient is such a sum, too."""

    @staticmethod
    def forward(ctx: Any, x: Tensor) -> Tensor:
        total = x.clone()
        dist.all_reduce(total)
        return total

    @staticmethod
    def backward(ctx: Any, gradient: Tensor) -> Any:
        return _summed(gradient.contiguous())


def _summed(x: Tensor) -> Tensor:
    total: Tensor = _Sum.apply(x)  # type: ignore[no-untyped-call]
    return total
