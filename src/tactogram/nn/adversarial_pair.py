"""Generator and discriminator with their optimisers, schedule and choice of weights."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from contextlib import AbstractContextManager, nullcontext
from copy import deepcopy
from functools import cached_property
from typing import Any

import torch
from torch import Tensor, nn

from tactogram.features.photo_pairs import WeakPairs
from tactogram.nn.bare_and_fixed import bare, fixed
from tactogram.nn.photo_translation import row_statistics_distance

EVALUATED = 256
"""Maximum number of validation pairs used to choose weights."""


class AdversarialPair:
    """Generator and discriminator, each with Adam; the generator's best weights if there is a validation part.

    ``constant`` is the share of the training after which the learning rate falls linearly, to 0 at its end; 1 keeps it.
    """

    def __init__(
        self,
        generator: nn.Module,
        discriminator: nn.Module,
        *,
        learning_rate: float,
        betas: tuple[float, float],
        epsilon: float = 1e-8,
        device: torch.device,
        constant: float = 1.0,
    ) -> None:
        self.generator: Any = generator.to(device)
        self.discriminator: Any = discriminator.to(device)
        self.learning_rate, self.betas, self.epsilon = learning_rate, betas, epsilon
        self.constant, self.device = constant, device
        self.backward: Callable[[Tensor], None] = Tensor.backward
        self.autocast: Callable[[], AbstractContextManager[Any]] = nullcontext
        self.chosen_by = "row_statistics"
        self.distance: Callable[[Tensor, Tensor], Tensor] = row_statistics_distance
        self.chosen = "last step"
        """Distance by which the stored weights were chosen; ``chosen_by`` names the current ``distance``."""
        self.best, self.best_weights = float("inf"), dict[str, Tensor]()

    @cached_property
    def optimisers(self) -> list[Any]:
        """Adam for each network. Made for training only: a process's first optimiser imports torch's compiler."""
        return [
            torch.optim.Adam(network.parameters(), lr=self.learning_rate, betas=self.betas, eps=self.epsilon)
            for network in (self.generator, self.discriminator)
        ]

    def setup(self, fabric: Any) -> None:
        """Hand networks and optimisers to Lightning Fabric."""
        self.generator, self.optimisers[0] = fabric.setup(self.generator, self.optimisers[0])
        self.discriminator, self.optimisers[1] = fabric.setup(self.discriminator, self.optimisers[1])
        self.backward, self.autocast, self.device = fabric.backward, fabric.autocast, fabric.device

    @property
    def bare_generator(self) -> nn.Module:
        """The generator without Fabric's wrapper."""
        network: nn.Module = bare(self.generator)
        return network

    def train(self, done: float) -> None:
        """Set both networks to training mode, and the learning rates after a share ``done`` of the training."""
        falling = 1 - max(0.0, done - self.constant) / (1 - self.constant) if self.constant < 1 else 1.0
        for network, optimiser in zip((self.generator, self.discriminator), self.optimisers, strict=True):
            network.train()
            for group in optimiser.param_groups:
                group["lr"] = self.learning_rate * falling

    def descend_generator(self, loss: Tensor) -> None:
        """Update the generator."""
        self._descend(0, loss)

    def descend_discriminator(self, loss: Tensor) -> None:
        """Update the discriminator."""
        self._descend(1, loss)

    def _descend(self, which: int, loss: Tensor) -> None:
        self.optimisers[which].zero_grad()
        self.backward(loss)
        self.optimisers[which].step()

    def fixed_discriminator(self) -> AbstractContextManager[None]:
        """Skip the gradients of the discriminator's weights, which the generator's loss does not need."""
        return fixed(self.discriminator)

    # -- choice of weights ---------------------------------------------------------------------------------

    def validation_distance(self, make: Callable[[Tensor], Tensor], pairs: WeakPairs) -> float:
        """Return the mean distance of the pictures of ``make`` from the pictures paired with the photographs."""
        count = min(len(pairs), EVALUATED)
        places = torch.linspace(0, len(pairs) - 1, count).round().long().numpy()
        total = 0.0
        for begin in range(0, count, 32):
            batch = pairs.batch(places[begin : begin + 32])
            made = make(batch.photo).float().cpu()
            total += self.distance(made, batch.picture).item() * len(made)
        return total / count

    def choose(self, make: Callable[[Tensor], Tensor], pairs: WeakPairs | None) -> dict[str, float]:
        """Store the generator's weights if they are the best so far on ``pairs``; return the distance by name."""
        if pairs is None:
            return {}
        figure = self.validation_distance(make, pairs)
        if self.chosen != self.chosen_by:  # another distance before, whose figures are not comparable
            self.chosen, self.best = self.chosen_by, float("inf")
        if figure <= self.best:
            self.best, self.best_weights = figure, deepcopy(self.bare_generator.state_dict())
        return {f"{self.chosen_by}_unseen": figure}

    def settle(self) -> None:
        """Continue with the best weights, if any were stored."""
        if self.best_weights:
            self.bare_generator.load_state_dict(self.best_weights)
            self.best_weights = {}

    # -- state -------------------------------------------------------------------------------------------

    def state(self) -> dict[str, Any]:
        """Return the weights and the best so far; the optimisers are in `optimiser_state`."""
        return {
            "generator": self.bare_generator.state_dict(),
            "discriminator": bare(self.discriminator).state_dict(),
            "chosen_by": self.chosen,
            "best": None if self.best == float("inf") else self.best,
            "best_weights": dict(self.best_weights),
        }

    def optimiser_state(self) -> list[Any]:
        """Return the state of both optimisers."""
        return [optimiser.state_dict() for optimiser in self.optimisers]

    def load_state(self, state: Mapping[str, Any], optimisers: list[Any] | None = None) -> None:
        """Continue from `state` and `optimiser_state`."""
        self.bare_generator.load_state_dict(state["generator"])
        self.discriminator.load_state_dict(state["discriminator"])
        self.best = float("inf") if state["best"] is None else state["best"]
        self.chosen = state["chosen_by"]
        self.best_weights = dict(state["best_weights"])
        if optimisers:
            for optimiser, values in zip(self.optimisers, optimisers, strict=True):
                optimiser.load_state_dict(values)
