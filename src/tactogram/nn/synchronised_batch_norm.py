"""Batch normalisation over the whole batch, where several processes each have an equal share of it.

`torch.nn.SyncBatchNorm` runs on GPUs alone, and has no second derivative, which gradient penalties need.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import torch
import torch.distributed as dist
import torch.nn.functional as F
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
        plain = torch.promote_types(input.dtype, torch.float32)
        ones = torch.ones(self.num_features, dtype=plain, device=input.device)
        weight, bias = (self.weight, self.bias) if self.affine else (ones, ones - 1)
        y: Tensor
        y, mean, variance = _Normalisation.apply(input, weight, bias, self.eps)  # type: ignore[no-untyped-call]
        self._follow(mean, variance, _rows(input))
        return y

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


class _Normalisation(torch.autograd.Function):
    """Normalised rows, mean and variance by torch's fused kernels: those of one process, and messages in between."""

    @staticmethod
    def forward(ctx: Any, x: Tensor, weight: Tensor, bias: Tensor, eps: float) -> tuple[Tensor, ...]:
        _, own_mean, scale = torch.native_batch_norm(x, weight, bias, None, None, True, 0.0, eps)
        mean, variance = _of_all(torch.stack((scale.pow(-2) - eps, own_mean)), _gathered)
        ctx.save_for_backward(x, weight, bias, mean, variance)
        ctx.eps = eps
        ctx.mark_non_differentiable(mean, variance)
        return F.batch_norm(x, mean, variance, weight, bias, eps=eps), mean, variance

    @staticmethod
    def backward(ctx: Any, gradient: Tensor, *_: Tensor) -> tuple[Tensor | None, ...]:
        x, weight, bias, mean, variance = ctx.saved_tensors
        if torch.is_grad_enabled():  # the gradient will be differentiated, too
            needed = ctx.needs_input_grad[:3]
            inputs = [each for each, need in zip((x, weight, bias), needed, strict=True) if need]
            y = _composed(x, weight, bias, ctx.eps)
            found = iter(torch.autograd.grad(y, inputs, gradient, create_graph=True))
            return (*(next(found) if need else None for need in needed), None)
        of_x, of_weight, of_bias = torch.ops.aten.native_batch_norm_backward(
            gradient, x, weight, mean, variance, None, None, False, ctx.eps, [True] * 3
        )
        # Mean and variance depend on the rows of all processes, and all losses on them.
        totals = torch.stack((of_weight, of_bias))
        dist.all_reduce(totals)
        total_weight, total_bias = totals / _rows(x)
        scale = (variance + ctx.eps).rsqrt()
        slope = weight * scale.square() * total_weight
        zeros, offset = torch.zeros_like(mean), weight * scale * total_bias - slope * mean
        of_x -= F.batch_norm(x, zeros, zeros + 1, slope, offset, eps=0.0)
        return of_x, of_weight, of_bias, None


def _composed(x: Tensor, weight: Tensor, bias: Tensor, eps: float) -> Tensor:
    """Return the normalised rows by steps that can be differentiated any number of times, and are slower."""
    rows = x.to(torch.promote_types(x.dtype, torch.float32))
    shape = (1, -1, *[1] * (x.dim() - 2))
    own = torch.var_mean(rows, [0, *range(2, x.dim())], correction=0)
    mean, variance = _of_all(torch.stack(own), _summed_parts)
    rows = (rows - mean.view(shape)) * (variance.view(shape) + eps).rsqrt()
    return (rows * weight.view(shape) + bias.view(shape)).to(x.dtype)


def _of_all(own: Tensor, gathered: Callable[[Tensor], Tensor]) -> tuple[Tensor, Tensor]:
    """Return mean and variance of all rows from those of each process, (variance or mean, channel)."""
    each = gathered(own)  # process, variance or mean, channel
    mean = each[:, 1].mean(0)
    return mean, each[:, 0].mean(0) + (each[:, 1] - mean).square().mean(0)


def _gathered(own: Tensor) -> Tensor:
    each = [torch.empty_like(own) for _ in range(dist.get_world_size())]
    dist.all_gather(each, own)
    return torch.stack(each)


def _summed_parts(own: Tensor) -> Tensor:
    """Return what `_gathered` does, as a sum, which can be differentiated."""
    number, none = dist.get_rank(), own.new_zeros((dist.get_world_size(), *own.shape))
    return _summed(torch.cat((none[:number], own[None], none[number + 1 :])))


def _rows(x: Tensor) -> int:
    """Return the number of values of a channel in all processes."""
    return x.numel() // x.shape[1] * dist.get_world_size()


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
