"""Flow model: a velocity network, its optimiser, and the average of its weights, which generates.

References
----------
- Lipman, Y. et al. (2023). Flow matching for generative modeling. ICLR.
- Liu, X., Gong, C. & Liu, Q. (2023). Flow straight and fast: learning to generate and transfer data with rectified
  flow. ICLR.
- Liu, X. et al. (2024). InstaFlow: one step is enough for high-quality diffusion-based text-to-image generation. ICLR.
- Hairer, E., Nørsett, S. P. & Wanner, G. (1993). Solving ordinary differential equations I. Springer. Sec. III.5.
- Esser, P. et al. (2024). Scaling rectified flow transformers for high-resolution image synthesis. ICML. Sec. 3.1.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from copy import deepcopy
from functools import cached_property
from itertools import pairwise
from typing import Any

import torch
from torch import Tensor, nn

from tactogram.model import Model, Stage
from tactogram.models.texture_flow.config import Config
from tactogram.nn import MovingAverage
from tactogram.nn.initial_weights import bare
from tactogram.training.seeds import torch_seeded

LARGEST_GRADIENT = 1.0
"""Norm that gradients are limited to."""
Velocity = Callable[[Tensor, Tensor], Tensor]
"""Maps values, (batch, …), and times, (batch,), to velocities, (batch, …)."""
DENSITY = 1.5
"""Exponent of the times of the solver's steps: above 1 they are denser near the noise, where paths bend most."""


class FlowModel:
    """A flow from noise to data, (batch, channel, row, column), with a label, (batch, label).

    A label of zeros is no condition.
    """

    def __init__(self, network: nn.Module, config: Config, *, device: torch.device) -> None:
        self.config, self.device = config, device
        self.network: Any = network.to(device)
        self.average = MovingAverage(network, config.moving_average)
        self.teacher: Any = None
        """Of a straightened flow, the average before."""
        self.backward: Callable[[Tensor], None] = Tensor.backward

    @cached_property
    def optimiser(self) -> Any:
        """AdamW. Made for training only: a process's first optimiser imports torch's compiler."""
        return torch.optim.AdamW(self.network.parameters(), lr=self.config.learning_rate, betas=(0.9, 0.99))

    def setup(self, fabric: Any) -> None:
        """Hand the network and its optimiser to Lightning Fabric."""
        self.network, self.optimiser = fabric.setup(self.network, self.optimiser)
        self.backward, self.device = fabric.backward, fabric.device
        self.average.network.to(self.device)

    def optimiser_state(self) -> Any:
        return self.optimiser.state_dict()

    def load_optimisers(self, state: Any) -> None:
        self.optimiser.load_state_dict(state)

    @property
    def stages(self) -> tuple[Stage, ...]:
        """Training, and straightening if it is wanted."""
        last = (
            (Stage("straighten", self.config.straightening_steps),) if self.config.straightening_steps else ()
        )
        return Stage("train", self.config.steps), *last

    def step(self, stage: Stage, number: int, data: Tensor, label: Tensor) -> float:
        """Return the loss of batch ``number`` of a stage; of ``data``, straightening needs only the shape."""
        if stage.name == "straighten":
            return self.straighten(number, stage.steps, torch.randn(data.shape), label)
        return self.update(number, stage.steps, data, label)

    def update(self, number: int, steps: int, data: Tensor, label: Tensor) -> float:
        """Return the loss of batch ``number`` of ``steps``, after a step of the optimiser and of the average."""
        label = label.to(self.device)
        loss = flow_loss(lambda x, time: self.network(x, time, label).float(), data.to(self.device))
        return self._descend(number, steps, loss)

    def straighten(self, number: int, steps: int, noise: Tensor, label: Tensor) -> float:
        """Return the loss of batch ``number`` of ``steps`` as `update` does; it learns to flow in a single step.

        With the first batch the average becomes the teacher, and network and a new average begin with its weights.
        """
        if number == 0:
            self.teacher = self.average.network
            bare(self.network).load_state_dict(self.teacher.state_dict())
            self.average = MovingAverage(bare(self.network), self.config.moving_average)
        label = label.to(self.device)
        loss = straightening_loss(
            lambda x, time: self.network(x, time, label).float(),
            guided(self.teacher, label, self.config.guidance),
            noise.to(self.device),
            self.config.solver_steps,
        )
        return self._descend(number, steps, loss)

    def _descend(self, number: int, steps: int, loss: Tensor) -> float:
        rate = min(1, (number + 1) / self.config.warm_up) * (1 + math.cos(math.pi * number / steps)) / 2
        for group in self.optimiser.param_groups:
            group["lr"] = rate * self.config.learning_rate
        self.optimiser.zero_grad()
        self.backward(loss)
        torch.nn.utils.clip_grad_norm_(self.network.parameters(), LARGEST_GRADIENT)
        self.optimiser.step()
        self.average.update(bare(self.network))
        return loss.item()

    @torch.no_grad()
    def loss(self, data: Tensor, label: Tensor) -> float:
        """Return the loss of the average, before it was straightened, at fixed noises and times."""
        label = label.to(self.device)
        network = self.average.network if self.teacher is None else self.teacher
        with torch_seeded(0, "validate"):
            return flow_loss(lambda x, t: network(x, t, label), data.to(self.device)).item()

    @torch.inference_mode()
    def sample(self, noise: Tensor, label: Tensor) -> Tensor:
        """Return data that ``noise`` flows to, in the configuration's steps; in a single one if straightened."""
        noise, label = noise.to(self.device), label.to(self.device)
        if self.config.straightening_steps:
            return solve(lambda x, time: self.average.network(x, time, label), noise, 1)
        return solve(
            guided(self.average.network, label, self.config.guidance), noise, self.config.solver_steps
        )

    def start_from(self, weights: Mapping[str, Tensor]) -> None:
        """Begin with the weights of another network; `RuntimeError` if they do not fit."""
        bare(self.network).load_state_dict(weights)
        self.average.network.load_state_dict(weights)

    def state(self) -> dict[str, Any]:
        """Return average, network and teacher, without the optimiser."""
        teacher = {} if self.teacher is None else {"teacher": self.teacher.state_dict()}
        return {"average": self.average.state(), "network": self.network.state_dict(), **teacher}

    def load_state(self, state: Mapping[str, Any]) -> None:
        """Continue from `state`; without the network, which a run that is shipped omits, from the average."""
        self.average.load_state(state["average"])
        self.network.load_state_dict(state.get("network", state["average"]["weights"]))
        if "teacher" in state:
            self.teacher = deepcopy(self.average.network)
            self.teacher.load_state_dict(state["teacher"])


class FlowLearner(Model):
    """Parts and state of a learner whose network is that of a `FlowModel`."""

    flow: FlowModel
    divides_batches = True

    def parts(self) -> Sequence[FlowModel]:
        return (self.flow,)

    def state(self) -> dict[str, Any]:
        return super().state() | self.flow.state()

    def load_state(self, state: Mapping[str, Any]) -> None:
        super().load_state(state)
        self.flow.load_state(state)


def guided(network: nn.Module, label: Tensor, strength: float) -> Velocity:
    """Return the velocity of a network with a condition of some strength (Ho & Salimans 2021)."""

    def velocity(x: Tensor, time: Tensor) -> Tensor:
        labelled: Tensor = network(x, time, label)
        if strength == 1:
            return labelled
        free: Tensor = network(x, time, torch.zeros_like(label))
        return free + strength * (labelled - free)

    return velocity


def flow_loss(velocity: Velocity, data: Tensor) -> Tensor:
    """Return the mean squared error of the velocity at random points between noise and ``data``, (batch, …).

    The errors of an element with a mean square above 1 are divided by it, so that it does not outweigh the others.
    Noise and times are drawn from torch's own generator, the times from the logit-normal distribution (Esser et al.).
    """
    noise = torch.randn(data.shape).to(data)
    time = torch.sigmoid(torch.randn(len(data))).to(data)
    share = time.view(-1, *[1] * (data.ndim - 1))
    error = velocity((1 - share) * noise + share * data, time) - (data - noise)
    return _mean_square(error, data)


def straightening_loss(velocity: Velocity, teacher: Velocity, noise: Tensor, steps: int) -> Tensor:
    """Return the mean squared error of one step from ``noise`` to where it flows in ``steps`` steps of ``teacher``.

    The distillation of a flow to a single step (Liu et al. 2023, Sec. 2; InstaFlow), with errors limited as in
    `flow_loss`. ``noise`` is (batch, …); no gradient reaches the teacher.
    """
    with torch.no_grad():
        data = solve(teacher, noise, steps)
    return _mean_square(velocity(noise, torch.zeros(len(noise)).to(noise)) - (data - noise), data)


def _mean_square(error: Tensor, data: Tensor) -> Tensor:
    inner = tuple(range(1, data.ndim))
    return (error.square().mean(inner) / data.square().mean(inner).clamp_min(1)).mean()


def solve(velocity: Velocity, noise: Tensor, steps: int) -> Tensor:
    """Return data, (batch, …), that ``noise`` flows to in ``steps`` steps, one evaluation of ``velocity`` each.

    The method is that of Adams and Bashforth, of second order and with unequal steps (Hairer et al., Sec. III.5): each
    step continues the change of the velocity over the one before. The first is Euler's. The times are denser near the
    noise.
    """
    x = noise
    earlier: tuple[float, Tensor] | None = None
    for begin, end in pairwise([(step / steps) ** DENSITY for step in range(steps + 1)]):
        slope = mean = velocity(x, torch.full((len(x),), begin).to(x))
        if earlier is not None:
            time, before = earlier
            mean = slope + (slope - before) * (end - begin) / (2 * (begin - time))
        earlier = begin, slope
        x = x + mean * (end - begin)
    return x
