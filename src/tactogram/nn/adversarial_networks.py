"""Generator and discriminator: optimisers, schedule, choice of weights by validation pictures, and their losses.

References
----------
- Goodfellow, I. et al. (2014). Generative adversarial nets. NeurIPS 27. Sec. 3: the non-saturating form.
- Mao, X. et al. (2017). Least squares generative adversarial networks. ICCV.
- Gulrajani, I., Ahmed, F., Arjovsky, M., Dumoulin, V. & Courville, A. (2017). Improved training of
  Wasserstein GANs. NeurIPS 30. Eq. 3 and Algorithm 1.
- Wang, T.-C. et al. (2018). High-resolution image synthesis … with conditional GANs. CVPR. Eq. 4.
- Neshov, N. et al. (2026). Visual-to-tactile cross-modal generation … Sensors 26, 426. Sec. 3.1.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from contextlib import AbstractContextManager, nullcontext
from copy import deepcopy
from functools import cached_property, partial
from typing import Any, Literal

import torch
import torch.nn.functional as F
from torch import Tensor, nn

from tactogram.features.photo_pairs import WeakPairs
from tactogram.model import Saved
from tactogram.nn.initial_weights import bare, fixed
from tactogram.nn.photo_translation import row_statistics_distance

EVALUATED = 256
"""Maximum number of validation pairs used to choose weights."""
LossKind = Literal["cross-entropy", "least-squares"]


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


class AdversarialPair(AdversarialNetworks, Saved):
    """Generator and discriminator, each with Adam; the generator's best weights if there is a validation part.

    ``constant`` is the share of the training after which the learning rate falls linearly, to 0 at its end; 1 keeps it.
    """

    saved = ("generator=bare_generator", "discriminator", "chosen_by=chosen", "best", "best_weights")

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
        self.best: float | None = None
        self.best_weights: dict[str, Tensor] = {}

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
            generated = make(batch.photo).float().cpu()
            total += self.distance(generated, batch.picture).item() * len(generated)
        return total / count

    def choose(self, make: Callable[[Tensor], Tensor], pairs: WeakPairs | None) -> dict[str, float]:
        """Store the generator's weights if they are the best so far on ``pairs``; return the distance by name."""
        if pairs is None:
            return {}
        figure = self.validation_distance(make, pairs)
        if self.chosen != self.chosen_by:  # another distance before, whose figures are not comparable
            self.chosen, self.best = self.chosen_by, None
        if self.best is None or figure <= self.best:
            self.best, self.best_weights = figure, deepcopy(self.bare_generator.state_dict())
        return {f"{self.chosen_by}_unseen": figure}

    def settle(self) -> None:
        """Continue with the best weights, if any were stored."""
        if self.best_weights:
            self.bare_generator.load_state_dict(self.best_weights)
            self.best_weights = {}


def adversarial_loss(scores: Sequence[Tensor], *, real: bool, kind: LossKind = "cross-entropy") -> Tensor:
    """Return the loss of ``scores``, one tensor of any shape per discriminator, against ``real``, summed over them.

    ``cross-entropy``: -log of the sigmoid of a score (real), or of that of its negative, mean over patches. A
    generator that minimises it with ``real=True`` maximises log D(G) rather than minimising log(1 - D(G)): the
    non-saturating form. ``least-squares``: (score - 1)^2, or score^2.
    """
    losses = []
    for score in scores:
        target = torch.ones_like(score) if real else torch.zeros_like(score)
        if kind == "cross-entropy":
            losses.append(F.binary_cross_entropy_with_logits(score, target))
        else:
            losses.append(F.mse_loss(score, target))
    return torch.stack(losses).sum()


def feature_matching_loss(made: Sequence[Sequence[Tensor]], real: Sequence[Sequence[Tensor]]) -> Tensor:
    """Return the mean distance of the features of generated pictures from those of real ones.

    ``1/N_D sum_k 1/(L+1) sum_l |D_k^(l)(real) - D_k^(l)(made)|_1``, the norm a mean over the features' values as in
    pix2pixHD; over all layers but the last, which is the score. Features are those of a `MultiScaleDiscriminator`; no
    gradient flows into the real ones.
    """
    distances = [
        torch.stack([F.l1_loss(a, b.detach()) for a, b in zip(ours[:-1], theirs[:-1], strict=True)]).mean()
        for ours, theirs in zip(made, real, strict=True)
    ]
    return torch.stack(distances).mean()


def gradient_penalty(
    critic: Callable[[Tensor], Tensor], real: Tensor, made: Tensor, share: Tensor | None = None
) -> Tensor:
    """Return the mean of ``(|grad critic(z)| - 1)^2`` at points z between ``real`` and ``made``, (item, …).

    Not weighted by the paper's lambda. ``share``, (item,), places each point from ``made`` (0) to ``real`` (1); by
    default it is uniform from torch's own generator. ``critic`` maps (item, …) to (item,) or (item, 1).
    """
    if share is None:
        share = torch.rand(len(real)).to(real.device)
    share = share.view(-1, *[1] * (real.dim() - 1))
    between = torch.lerp(made.detach(), real.detach(), share).requires_grad_()
    (slope,) = torch.autograd.grad(critic(between).sum(), between, create_graph=True)
    length: Tensor = torch.linalg.vector_norm(slope.flatten(1), dim=1)
    return (length - 1).square().mean()
