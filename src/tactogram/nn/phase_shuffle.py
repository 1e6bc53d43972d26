"""Phase shuffle: shifts of each item's activations by a few samples, so that a critic cannot use phase.

References
----------
- Donahue, C., McAuley, J. & Puckette, M. (2019). Adversarial audio synthesis. ICLR. Sec. 3.3.
"""

from __future__ import annotations

import torch
import torch.nn.functional as F
from torch import Tensor, nn

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
    time, most = x.shape[-1], int(shifts.abs().max())
    if most >= time:
        raise ParameterError(f"phase shuffle moves by up to {most} samples, of {time}; shorten it")
    padded = F.pad(x.flatten(1, 2), (most, most), mode="reflect").view(*x.shape[:-1], time + 2 * most)
    return torch.stack(
        [item[..., most - k : most - k + time] for item, k in zip(padded, shifts.tolist(), strict=True)]
    )
