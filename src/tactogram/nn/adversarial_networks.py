"""Generator and discriminator with an optimiser each."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from contextlib import AbstractContextManager, nullcontext
from functools import cached_property
from typing import Any

import torch
from torch import Tensor, nn


class AdversarialNetworks:
    """Two networks and their updates; ``rates`` are the learning rates of generator and discriminator.

    ``optimiser`` makes one from parameters and ``lr``.
    """

    def __init__(
        self,
        generator: nn.Module,
        discriminator: nn.Module,
        *,
        rates: tuple[float, float],
        optimiser: Callable[..., Any],
        device: str | torch.device,
    ) -> None:
        self.device, self.rates, self._optimiser = torch.device(device), rates, optimiser
        self.generator: Any = generator.to(self.device)
        self.discriminator: Any = discriminator.to(self.device)
        self.backward: Callable[[Tensor], None] = Tensor.backward
        self.autocast: Callable[[], AbstractContextManager[Any]] = nullcontext

    @cached_property
    def optimisers(self) -> list[Any]:
        """One for each network. Made for training only: a process's first optimiser imports torch's compiler."""
        networks = (self.generator, self.discriminator)
        return [
            self._optimiser(network.parameters(), lr=rate)
            for network, rate in zip(networks, self.rates, strict=True)
        ]

    def setup(self, fabric: Any) -> None:
        """Hand networks and optimisers to Lightning Fabric."""
        self.generator, self.optimisers[0] = fabric.setup(self.generator, self.optimisers[0])
        self.discriminator, self.optimisers[1] = fabric.setup(self.discriminator, self.optimisers[1])
        self.backward, self.autocast, self.device = fabric.backward, fabric.autocast, fabric.device

    def descend(self, which: int, loss: Tensor) -> None:
        """Update the generator (0) or the discriminator (1)."""
        self.optimisers[which].zero_grad()
        self.backward(loss)
        self.optimisers[which].step()

    def scale_rates(self, factor: float) -> None:
        """Set the learning rates to ``factor`` times the initial ones."""
        for optimiser, rate in zip(self.optimisers, self.rates, strict=True):
            for group in optimiser.param_groups:
                group["lr"] = rate * factor

    def lower_rates(self, done: float, *, constant: float) -> None:
        """Let the learning rates fall linearly after a share ``constant`` of the training, to 0 at its end."""
        self.scale_rates(min(1.0, (1 - done) / (1 - constant)) if constant < 1 else 1.0)

    def optimiser_state(self) -> list[Any]:
        """Return the state of both optimisers."""
        return [optimiser.state_dict() for optimiser in self.optimisers]

    def load_optimisers(self, states: Sequence[Any] | None) -> None:
        """Continue from `optimiser_state`, if there is one."""
        for optimiser, values in zip(self.optimisers, states, strict=True) if states else ():
            optimiser.load_state_dict(values)
