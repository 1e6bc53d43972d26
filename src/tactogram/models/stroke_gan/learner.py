"""Learner of the GAN: the paper's order of updates, and signals of any length from labels that may be mixed."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import AbstractContextManager, nullcontext
from functools import partial
from typing import Any

import numpy as np
import torch
from numpy.typing import NDArray
from torch import Tensor

from tactogram.errors import ParameterError
from tactogram.features.signal_crops import SignalCrops
from tactogram.model import Condition, Example, SignalKind, Stage, check_condition, material_weights
from tactogram.models.stroke_gan.config import Config
from tactogram.models.stroke_gan.networks import Generator, discriminator
from tactogram.models.stroke_gan.scaling import Scaling
from tactogram.nn import gradient_penalty
from tactogram.nn.bare_and_fixed import bare, fixed
from tactogram.nn.latent_pieces import crossfaded_pieces, given_latent, uniform_latents
from tactogram.signal import Signal
from tactogram.training.seeds import child_rng, torch_seeded


class StrokeGANLearner:
    """The generator and the discriminator of Saga et al., Sec. III, with their optimisers.

    Parameters
    ----------
    config : Config
    kind : SignalKind
        Rate, unit, axes and materials of the training signals.
    seed : int
        Decides the initial weights.
    device : str or torch.device
    """

    def __init__(
        self, config: Config, kind: SignalKind, *, seed: int, device: str | torch.device = "cpu"
    ) -> None:
        if not kind.materials:
            raise ParameterError("stroke_gan needs recordings with a material, got none")
        self.config, self.kind, self.materials = config, kind, kind.materials
        self.device = torch.device(device)
        self.scaling = Scaling(kind, config.within_range)
        size = {"axes": len(kind.axes), "labels": len(kind.materials)}
        with torch_seeded(seed, "weights"):
            networks = Generator(config, **size), discriminator(config, **size)
        self.generator: Any = networks[0].to(self.device)
        self.discriminator: Any = networks[1].to(self.device)
        self.optimisers: list[Any] = [
            torch.optim.Adam(network.parameters(), lr=config.learning_rate, betas=config.betas)
            for network in networks
        ]
        self.backward: Callable[[Tensor], None] = Tensor.backward
        self.autocast: Callable[[], AbstractContextManager[Any]] = nullcontext

    def setup(self, fabric: Any) -> None:
        self.generator, self.optimisers[0] = fabric.setup(self.generator, self.optimisers[0])
        self.discriminator, self.optimisers[1] = fabric.setup(self.discriminator, self.optimisers[1])
        self.backward, self.autocast = fabric.backward, fabric.autocast
        self.device = fabric.device

    # -- training ----------------------------------------------------------------------------------------

    def stages(self, examples: Sequence[Example]) -> tuple[Stage, ...]:
        present = {example.material for example in examples}
        if missing := [name for name in self.materials if name not in present]:
            raise ParameterError(f"no training recording of {', '.join(missing)}; leave it out of the data")
        config, crops = self.config, len(self._crops(examples).epoch())
        steps = config.steps or math.ceil(config.epochs * crops / (config.batch_size * config.critic_updates))
        return Stage("fit", 1), Stage("train", steps)

    def batches(
        self, stage: Stage, examples: Sequence[Example], *, seed: int, start: int = 0
    ) -> Iterator[Any]:
        if stage.name == "fit":
            yield examples
            return
        crops = self._crops(examples)
        count = self.config.batch_size * self.config.critic_updates
        step = start
        while True:
            yield self._prepared(crops.draw(step * count, count, partial(child_rng, seed)))
            step += 1

    def _crops(self, examples: Sequence[Example]) -> SignalCrops:
        config = self.config
        repetitions = config.repetitions if config.repetition == "repeat" else None
        return SignalCrops(examples, config.length, round(config.overlap * config.length), repetitions)

    def _prepared(
        self, crops: Sequence[tuple[Example, NDArray[np.float32]]]
    ) -> tuple[NDArray[np.float32], NDArray[np.float32]]:
        """Return crops as the networks see them, (crop, axis, time), and their labels, (crop, C)."""
        classes = [self.materials.index(str(example.material)) for example, _ in crops]
        x = np.stack([self.scaling.scaled(crop) for _, crop in crops])
        return x, np.eye(len(self.materials), dtype=np.float32)[classes]

    def step(self, stage: Stage, batch: Any) -> dict[str, float]:
        if stage.name == "fit":
            for example in batch:
                self.kind.check(example.signal)
            return self.scaling.fit(batch)
        size = self.config.batch_size
        real, label = (torch.from_numpy(part).to(self.device) for part in batch)
        figures: dict[str, Tensor] = {}
        for update in range(self.config.critic_updates):
            part = slice(update * size, (update + 1) * size)
            figures |= self._update_discriminator(real[part], label[part])
        for update in range(self.config.generator_updates):
            start = update % self.config.critic_updates * size
            figures |= self._update_generator(label[start : start + size])
        return {name: value.item() for name, value in figures.items()}

    def _update_discriminator(self, real: Tensor, label: Tensor) -> dict[str, Tensor]:
        """Gulrajani et al. 2017, Algorithm 1, lines 4 to 9."""
        with torch.no_grad():
            made = self._make(label)
        scores = self.discriminator(torch.cat((real, made)), label.repeat(2, 1)).float()
        wasserstein = scores[: len(real)].mean() - scores[len(real) :].mean()
        with self.autocast():  # Fabric's wrapper lets no gradient be taken but by its own backward
            critic = bare(self.discriminator)
            penalty = gradient_penalty(lambda x: critic(x, label).float(), real, made)
        self._descend(1, self.config.penalty * penalty - wasserstein)
        return {"wasserstein": wasserstein, "penalty": penalty}

    def _update_generator(self, label: Tensor) -> dict[str, Tensor]:
        """Gulrajani et al. 2017, Algorithm 1, lines 11 and 12."""
        with fixed(self.discriminator):
            loss = -self.discriminator(self._make(label), label).float().mean()
        self._descend(0, loss)
        return {"generator_loss": loss}

    def _make(self, label: Tensor) -> Tensor:
        """Return a signal per row of ``label``, of a latent from torch's own generator."""
        latent = torch.rand(len(label), self.config.latent) * 2 - 1
        made: Tensor = self.generator(latent.to(self.device), label)
        return made.float()

    def _descend(self, which: int, loss: Tensor) -> None:
        self.optimisers[which].zero_grad()
        self.backward(loss)
        self.optimisers[which].step()

    @torch.no_grad()
    def validate(self, examples: Sequence[Example]) -> dict[str, float]:
        """Return the critic's estimate of the Wasserstein distance from generated to unseen crops.

        Well above that of the training crops it says that the critic, and so the generator, knows them by heart.
        """
        if not examples:
            return {}
        crops = self._crops(examples).draw(0, max(len(examples), 16), partial(child_rng, 0))
        x, label = (torch.from_numpy(part).to(self.device) for part in self._prepared(crops))
        with torch_seeded(0, "validate"):
            real = bare(self.discriminator)(x, label).mean()
            made = bare(self.discriminator)(self._make(label), label).mean()
        return {"wasserstein_unseen": (real - made).item()}

    def state(self) -> dict[str, Any]:
        return {
            "materials": list(self.materials),
            "domain": self.scaling.state(),
            "generator": self.generator.state_dict(),
            "discriminator": self.discriminator.state_dict(),
            "optimisers": [optimiser.state_dict() for optimiser in self.optimisers],
        }

    def load_state(self, state: Mapping[str, Any]) -> None:
        if tuple(state["materials"]) != self.materials:
            raise ParameterError(
                f"state is of {', '.join(state['materials'])}; expected {', '.join(self.materials)}"
            )
        self.scaling.load_state(state["domain"])
        self.generator.load_state_dict(state["generator"])
        self.discriminator.load_state_dict(state["discriminator"])
        for optimiser, kept in zip(self.optimisers, state.get("optimisers") or (), strict=False):
            optimiser.load_state_dict(kept)

    # -- use ---------------------------------------------------------------------------------------------

    def generate(self, condition: Condition, *, seconds: float | None = None, seed: int) -> Signal:
        """Return a signal; one longer than the networks' is pieces of new latents, crossfaded.

        ``material`` weights go in as they are: {a: 1, b: 0.3} and {a: 0.7, b: 0.3} are the paper's two ways of
        mixing. ``latent``, float array of shape (latent,) in -1 to 1, is that of the first piece.
        """
        check_condition(condition, needs=("material",), takes=("latent",))
        label = torch.tensor(material_weights(condition, self.materials), dtype=torch.float32)
        given = given_latent(condition, self.config.latent)
        length = self.config.length if seconds is None else max(1, round(seconds * self.kind.rate))
        made = crossfaded_pieces(
            lambda first, count: self._pieces(first, count, label, given, seed),
            self.kind,
            length=length,
            overlap=round(self.config.overlap * self.config.length),
        )
        return self.scaling.unscaled(made)

    @torch.inference_mode()
    def _pieces(
        self, first: int, count: int, label: Tensor, given: Mapping[int, Tensor], seed: int
    ) -> NDArray[np.float32]:
        """Return pieces ``first`` to ``first + count``, float32, (piece, axis, time); each has its own seed."""
        rng = partial(child_rng, seed, "latent")
        latents = uniform_latents(first, count, self.config.latent, given=given, rng=rng)
        made = bare(self.generator)(latents.to(self.device), label.expand(count, -1).to(self.device))
        result: NDArray[np.float32] = made.float().cpu().numpy()
        return result


def build(
    config: Config, kind: SignalKind, *, seed: int, device: str | torch.device = "cpu"
) -> StrokeGANLearner:
    """Return an untrained model for signals of ``kind``."""
    return StrokeGANLearner(config, kind, seed=seed, device=device)
