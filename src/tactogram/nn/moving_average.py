"""Exponential moving average of a network's weights, steadier than the last weights.

References
----------
- Yazıcı, Y. et al. (2019). The unusual effectiveness of averaging in GAN training. ICLR.
"""

from __future__ import annotations

from copy import deepcopy

import torch
from torch import nn

from tactogram.model import Saved


class MovingAverage(Saved):
    """A copy of a network, not yet wrapped by Fabric, with the average of its weights.

    ``decay`` is the share of the average that remains at each update, 0 to 1. It starts lower, ``(1 + n) / (10 + n)``
    at update n, so that the initial weights soon lose influence.
    """

    saved = ("updates", "weights=network")

    def __init__(self, network: nn.Module, decay: float) -> None:
        self.network = deepcopy(network).requires_grad_(False)
        self.decay, self.updates = decay, 0

    @torch.no_grad()
    def update(self, network: nn.Module) -> None:
        """Move the average towards the weights of ``network``."""
        self.updates += 1
        decay = min(self.decay, (1 + self.updates) / (10 + self.updates))
        now = network.state_dict()
        for name, average in self.network.state_dict().items():
            average.lerp_(now[name], 1 - decay)
