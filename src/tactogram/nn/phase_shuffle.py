"""Phase shuffle: shifts of each item's activations by a few samples, so that a critic cannot use phase.

References
----------
- Donahue, C., McAuley, J. & Puckette, M. (2019). Adversarial audio synthesis. ICLR. Sec. 3.3.
"""

from __future__ import annotations

from typing import Any

import torch
from torch import Tensor, nn
from torch.autograd import Function

from tactogram.errors import ParameterError


class PhaseShuffle(nn.Module):
    """Move each item by a whole number of samples drawn from -``reach`` to ``reach``.

    One draw per item keeps its axes aligned. Ends are filled by reflection. It also shifts in evaluation mode, as in
    the publication. ``reach`` is 2 in Saga et al. 2020, Table IV; 0 shifts nothing.
    """

    def __init__(self, reach: int) -> None:
        super().__init__()
        self.reach = reach

    def forward(self, x: Tensor) -> Tensor:
        """Return ``x``, shape (item, axis, channel, time), moved; draws from torch's own generator."""
        if self.reach == 0:
            return x
        return shift(x, torch.randint(-self.reach, self.reach + 1, (len(x),)))


def shift(x: Tensor, shifts: Tensor) -> Tensor:
    """Return item k of ``x``, (item, axis, channel, time), moved by ``shifts[k]`` samples, later if positive.

    ``y[t] = x[r(t - shift)]`` with ``r`` the reflection about the first and the last sample. ``shifts``, int64,
    (item,), are on the CPU and shorter than ``time``.
    """
    if int(shifts.abs().max()) >= x.shape[-1]:
        raise ParameterError(
            f"phase shuffle moves by up to {int(shifts.abs().max())} samples, of {x.shape[-1]}; shorten it"
        )
    moved: Tensor = _Shift.apply(x, tuple(shifts.tolist()))  # type: ignore[no-untyped-call]
    return moved


class _Shift(Function):
    @staticmethod
    def forward(ctx: Any, x: Tensor, shifts: tuple[int, ...]) -> Tensor:
        ctx.shifts = shifts
        y = torch.empty_like(x)
        time = x.shape[-1]
        for to, by, k in zip(y, x, shifts, strict=True):
            if k >= 0:
                to[..., k:] = by[..., : time - k]
                to[..., :k] = by[..., 1 : k + 1].flip(-1)
            else:
                to[..., :k] = by[..., -k:]
                to[..., k:] = by[..., k - 1 : -1].flip(-1)
        return y

    @staticmethod
    def backward(ctx: Any, grad: Tensor) -> tuple[Tensor, None]:
        return _Adjoint.apply(grad, ctx.shifts), None  # type: ignore[no-untyped-call]


class _Adjoint(Function):
    @staticmethod
    def forward(ctx: Any, grad: Tensor, shifts: tuple[int, ...]) -> Tensor:
        ctx.shifts = shifts
        x = torch.empty_like(grad)
        time = grad.shape[-1]
        for to, by, k in zip(x, grad, shifts, strict=True):
            if k >= 0:
                to[..., : time - k] = by[..., k:]
                to[..., time - k :] = 0
                to[..., 1 : k + 1] += by[..., :k].flip(-1)
            else:
                to[..., -k:] = by[..., :k]
                to[..., :-k] = 0
                to[..., k - 1 : -1] += by[..., k:].flip(-1)
        return x

    @staticmethod
    def backward(ctx: Any, grad: Tensor) -> tuple[Tensor, None]:
        return _Shift.apply(grad, ctx.shifts), None  # type: ignore[no-untyped-call]
