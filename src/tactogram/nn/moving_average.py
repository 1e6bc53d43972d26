"""Exponential moving average of a network's weights, steadier than the last weights.

References
----------
- Yazıcı, Y. et al. (2019). The unusual effectiveness of averaging in GAN training. ICLR.
"""

from __future__ import annotations

from collections.abc import Mapping
from copy import deepcopy
from typing import Any

import torch
from torch import nn


class MovingAverage:
    """A copy of a network, not yet wrapped by Fabric, with the average of its weights.

    ``decay`` is the share of the average that remains at each update, 0 to 1. It starts lower, ``(1 + n) / (10 + n)``
    at update n, so that the initial weights soon lose influence.
    """

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

    def state(self) -> dict[str, Any]:
        """Return average and count."""
        return {"updates": self.updates, "weights": self.network.state_dict()}

    def load_state(self, state: Mapping[str, Any]) -> None:
        """Continue from `state`."""
        self.network.load_state_dict(state["weights"])
        self.updates = state["updates"]
