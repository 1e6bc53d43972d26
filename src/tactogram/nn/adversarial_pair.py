"""Generator and discriminator with their optimisers, schedule and choice of weights."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from contextlib import AbstractContextManager
from copy import deepcopy
from functools import partial
from typing import Any

import torch
from torch import Tensor, nn

from tactogram.features.photo_pairs import WeakPairs
from tactogram.nn.adversarial_networks import AdversarialNetworks
from tactogram.nn.bare_and_fixed import bare, fixed
from tactogram.nn.photo_translation import row_statistics_distance

EVALUATED = 256
"""Maximum number of validation pairs used to choose weights."""


class AdversarialPair(AdversarialNetworks):
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
        adam = partial(torch.optim.Adam, betas=betas, eps=epsilon)
        rates = (learning_rate, learning_rate)
        super().__init__(generator, discriminator, rates=rates, optimiser=adam, device=device)
        self.constant = constant
        self.chosen_by = "row_statistics"
        self.distance: Callable[[Tensor, Tensor], Tensor] = row_statistics_distance
        self.chosen = "last step"
        """Distance by which the stored weights were chosen; ``chosen_by`` names the current ``distance``."""
        self.best, self.best_weights = float("inf"), dict[str, Tensor]()

    @property
    def bare_generator(self) -> nn.Module:
        """The generator without Fabric's wrapper."""
        network: nn.Module = bare(self.generator)
        return network

    def train(self, done: float) -> None:
        """Set both networks to training mode, and the learning rates after a share ``done`` of the training."""
        self.generator.train(), self.discriminator.train()
        self.lower_rates(done, constant=self.constant)

    def fixed_discriminator(self) -> AbstractContextManager[None]:
        """Skip the gradients of the discriminator's weights, which the generator's loss does not need."""
        return fixed(self.discriminator)

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

    def state(self) -> dict[str, Any]:
        """Return the weights and the best so far; the optimisers are in `optimiser_state`."""
        return {
            "generator": self.bare_generator.state_dict(),
            "discriminator": bare(self.discriminator).state_dict(),
            "chosen_by": self.chosen,
            "best": None if self.best == float("inf") else self.best,
            "best_weights": dict(self.best_weights),
        }

    def load_state(self, state: Mapping[str, Any], optimisers: list[Any] | None = None) -> None:
        """Continue from `state` and `optimiser_state`."""
        self.bare_generator.load_state_dict(state["generator"])
        self.discriminator.load_state_dict(state["discriminator"])
        self.best = float("inf") if state["best"] is None else state["best"]
        self.chosen = state["chosen_by"]
        self.best_weights = dict(state["best_weights"])
        self.load_optimisers(optimisers)
