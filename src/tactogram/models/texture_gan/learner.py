"""Learner of the texture GAN: whitened recordings in, signals of any length out, from labels that may be mixed."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import AbstractContextManager, nullcontext
from functools import partial
from types import MappingProxyType
from typing import Any

import numpy as np
import torch
from numpy.typing import NDArray
from torch import Tensor

from tactogram.errors import ParameterError
from tactogram.features.signal_crops import SignalCrops
from tactogram.model import Condition, Example, SignalKind, Stage, check_condition, material_weights
from tactogram.models.texture_gan.band_matching import match_bands
from tactogram.models.texture_gan.config import Config
from tactogram.models.texture_gan.excitation import split_bands, white_noise
from tactogram.models.texture_gan.labels import NUMBERS, Labels
from tactogram.models.texture_gan.networks import Generator, discriminator
from tactogram.models.texture_gan.texture_statistics import energy_distance, spread_within, statistics
from tactogram.models.texture_gan.whitening import Whitening
from tactogram.nn import MovingAverage, gradient_penalty
from tactogram.nn.bare_and_fixed import bare, fixed
from tactogram.nn.latent_pieces import crossfaded_pieces, given_latent, uniform_latents
from tactogram.signal import Signal
from tactogram.signal.band_levels import BandLevels
from tactogram.training.seeds import child_generator, child_rng, torch_seeded

MEASURED = 512
"""Crops that the spread of the texture statistics is measured on."""
MATCHED_LENGTHS = 4
"""Lengths of the networks, at most, of each recording that the bands are matched to."""

FIRST_HEARD = 1
"""The piece that a signal begins with: the filters settle on the one before."""


class TextureGANLearner:
    """Filters of each material, a generator and a critic behind them, and levels of bands.

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
            raise ParameterError("texture_gan needs recordings with a material, got none")
        self.config, self.kind, self.materials = config, kind, kind.materials
        self.device = torch.device(device)
        self.whitening = Whitening(config, kind)
        self.band_levels = BandLevels(kind.rate) if config.match_bands else None
        self.labels = Labels(config.conditions)
        self.spread = torch.ones(0)
        size = {"axes": len(kind.axes), "labels": len(kind.materials) + len(config.conditions)}
        with torch_seeded(seed, "weights"):
            networks = Generator(config, **size), discriminator(config, **size)
        self.generator: Any = networks[0].to(self.device)
        self.discriminator: Any = networks[1].to(self.device)
        self.average = MovingAverage(networks[0], config.moving_average) if config.moving_average else None
        self.rates = (config.generator_learning_rate, config.learning_rate)
        self.optimisers: list[Any] = [
            torch.optim.Adam(network.parameters(), lr=rate, betas=config.betas)
            for network, rate in zip(networks, self.rates, strict=True)
        ]
        self.backward: Callable[[Tensor], None] = Tensor.backward
        self.autocast: Callable[[], AbstractContextManager[Any]] = nullcontext

    def setup(self, fabric: Any) -> None:
        self.generator, self.optimisers[0] = fabric.setup(self.generator, self.optimisers[0])
        self.discriminator, self.optimisers[1] = fabric.setup(self.discriminator, self.optimisers[1])
        self.backward, self.autocast = fabric.backward, fabric.autocast
        self.device = fabric.device
        if self.average:
            self.average.network.to(self.device)

    # -- training ----------------------------------------------------------------------------------------

    def stages(self, examples: Sequence[Example]) -> tuple[Stage, ...]:
        present = {example.material for example in examples}
        if missing := [name for name in self.materials if name not in present]:
            raise ParameterError(f"no training recording of {', '.join(missing)}; leave it out of the data")
        match = (Stage("match", 1),) if self.band_levels else ()
        return Stage("fit", 1), Stage("train", self.config.steps), *match

    def batches(
        self, stage: Stage, examples: Sequence[Example], *, seed: int, start: int = 0
    ) -> Iterator[Any]:
        if stage.name != "train":
            yield examples
            return
        crops, count, step = self._crops(examples), self.config.batch_size, start
        while True:
            yield step, *self._prepared(crops.draw(step * count, count, partial(child_rng, seed)))
            step += 1

    def _crops(self, examples: Sequence[Example]) -> SignalCrops:
        length = self.config.length
        return SignalCrops(examples, length, round(self.config.overlap * length), lead=self.whitening.lead)

    def _prepared(
        self, crops: Sequence[tuple[Example, NDArray[np.float32]]]
    ) -> tuple[NDArray[np.float32], NDArray[np.float32]]:
        """Return crops as the networks see them, (crop, axis, time), and their labels, (crop, C)."""
        places = [self.materials.index(str(example.material)) for example, _ in crops]
        x = np.stack([self.whitening.whitened(crop, m) for (_, crop), m in zip(crops, places, strict=True)])
        classes = np.eye(len(self.materials), dtype=np.float32)[places]
        values = [self.labels.numbers(example.condition) for example, _ in crops]
        return x, np.hstack((classes, np.array(values, np.float32).reshape(len(crops), -1)))

    def step(self, stage: Stage, batch: Any) -> dict[str, float]:
        if stage.name == "fit":
            return self._fit(batch)
        if stage.name == "match" and self.band_levels:
            return self._match(batch, self.band_levels)
        number, *arrays = batch
        self._schedule(number / stage.steps)
        real, label = (torch.from_numpy(array).to(self.device) for array in arrays)
        figures = self._update_discriminator(real, label) if self.config.adversarial else {}
        figures |= self._update_generator(real, label)
        if self.average:
            self.average.update(bare(self.generator))
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

    def _update_generator(self, real: Tensor, label: Tensor) -> dict[str, Tensor]:
        """Gulrajani et al. 2017, Algorithm 1, lines 11 and 12, and the energy distance between statistics."""
        config, figures = self.config, dict[str, Tensor]()
        loss = torch.zeros((), device=self.device)
        made = self._make(label)
        if config.adversarial:
            with fixed(self.discriminator):
                figures["generator_loss"] = -self.discriminator(made, label).float().mean()
            loss = loss + config.adversarial * figures["generator_loss"]
        if config.statistics:
            spread = self.spread.to(self.device)
            ours, again, theirs = (statistics(x) / spread for x in (made, self._make(label), real))
            figures["statistics"] = energy_distance(theirs, ours, again)
            loss = loss + config.statistics * figures["statistics"]
        self._descend(0, loss)
        return figures

    def _make(self, label: Tensor) -> Tensor:
        """Return a signal per row of ``label``, of a latent and noise from torch's own generator."""
        latent = torch.rand(len(label), self.config.latents) * 2 - 1
        noise = self._bands(white_noise(len(label), len(self.kind.axes), self.config.length))
        made: Tensor = self.generator(latent.to(self.device), label, noise)
        return made.float()

    def _bands(self, white: Tensor) -> Tensor:
        """Return white noise, (batch, axis, time), as the generator takes it: (batch, axis, time, band)."""
        return split_bands(white.to(self.device), self.config.noise_bands)

    def _descend(self, which: int, loss: Tensor) -> None:
        self.optimisers[which].zero_grad()
        self.backward(loss)
        self.optimisers[which].step()

    def _schedule(self, done: float) -> None:
        """Set the learning rates when a share ``done`` of the training is."""
        for optimiser, rate in zip(self.optimisers, self.rates, strict=True):
            for group in optimiser.param_groups:
                group["lr"] = rate * (1 + math.cos(math.pi * done)) / 2

    def _fit(self, examples: Sequence[Example]) -> dict[str, float]:
        """Measure filters, numeric conditions, and the spread of the statistics within a material."""
        for example in examples:
            self.kind.check(example.signal)
        self.labels.fit(examples)
        figures = self.whitening.fit(examples)
        if self.config.statistics:
            x, label = self._prepared(self._crops(examples).draw(0, MEASURED, partial(child_rng, 0)))
            classes = torch.from_numpy(label[:, : len(self.materials)]).argmax(1)
            self.spread = spread_within(statistics(torch.from_numpy(x)), classes)
        return figures

    def _match(self, examples: Sequence[Example], levels: BandLevels) -> dict[str, float]:
        """Measure the bands of recordings, and of signals generated for their conditions."""

        def generated(place: int, condition: Condition, length: int, seed: int) -> NDArray[np.float32]:
            weights = np.eye(len(self.materials))[place]
            return self._signal(self.labels.label(weights, condition), weights, length, seed=seed).samples

        longest = MATCHED_LENGTHS * self.config.length
        match_bands(levels, examples, self.materials, longest=longest, generate=generated)
        return {"band_correction_db": levels.correction_db()}

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
            "whitening": self.whitening.state(),
            "conditions": self.labels.state(),
            "spread": self.spread,
            "bands": self.band_levels.state() if self.band_levels else None,
            "generator": self.generator.state_dict(),
            "discriminator": self.discriminator.state_dict(),
            "average": self.average.state() if self.average else None,
            "optimisers": [optimiser.state_dict() for optimiser in self.optimisers],
        }

    def load_state(self, state: Mapping[str, Any]) -> None:
        if tuple(state["materials"]) != self.materials:
            raise ParameterError(
                f"state is of {', '.join(state['materials'])}; expected {', '.join(self.materials)}"
            )
        self.whitening.load_state(state["whitening"])
        self.labels.load_state(state["conditions"])
        self.spread = state["spread"]
        if self.band_levels:
            self.band_levels.load_state(state["bands"])
        self.generator.load_state_dict(state["generator"])
        self.discriminator.load_state_dict(state["discriminator"])
        if self.average:
            self.average.load_state(state["average"])
        for optimiser, kept in zip(self.optimisers, state.get("optimisers") or (), strict=False):
            optimiser.load_state_dict(kept)

    # -- use ---------------------------------------------------------------------------------------------

    def generate(self, condition: Condition, *, seconds: float | None = None, seed: int) -> Signal:
        """Return a signal; one longer than the networks' is pieces of new latents, crossfaded.

        ``material`` weights go in as they are. ``latent``, float array of shape (latents,) in -1 to 1, is that of
        the piece that the signal begins with. A speed or a force is by default the median of the recordings; one
        beyond theirs counts as the nearest of theirs, and is refused without ``config.conditions``.
        """
        check_condition(condition, needs=("material",), takes=(*NUMBERS, "latent"))
        self.labels.check(condition)
        weights = material_weights(condition, self.materials)
        label = self.labels.label(weights, condition)
        length = self.config.length if seconds is None else max(1, round(seconds * self.kind.rate))
        given = given_latent(condition, self.config.latents, piece=FIRST_HEARD)
        if self.band_levels is None or not self.band_levels.measured:
            return self._signal(label, weights, length, seed=seed, given=given)
        signal = self._signal(label, weights, length + 2 * self.band_levels.reach, seed=seed, given=given)
        return signal.with_samples(self.band_levels.apply(signal.samples, weights).astype(np.float32))

    def _signal(
        self,
        label: Tensor,
        weights: NDArray[np.float64],
        length: int,
        *,
        seed: int,
        given: Mapping[int, Tensor] = MappingProxyType({}),
    ) -> Signal:
        """Return ``length`` samples from the networks through the filters."""
        white = crossfaded_pieces(
            lambda first, count: self._pieces(first, count, label, given, seed),
            self.kind,
            length=self.whitening.settle + length,
            overlap=round(self.config.overlap * self.config.length),
        )
        return self.whitening.coloured(white, weights)

    @torch.inference_mode()
    def _pieces(
        self, first: int, count: int, label: Tensor, given: Mapping[int, Tensor], seed: int
    ) -> NDArray[np.float32]:
        """Return pieces ``first`` to ``first + count``, float32, (piece, axis, time); each has its own seeds."""
        rng = partial(child_rng, seed, "latent")
        latents = uniform_latents(first, count, self.config.latents, given=given, rng=rng)
        shape = 1, len(self.kind.axes), self.config.length
        noise = [
            white_noise(*shape, generator=child_generator(seed, "noise", number))
            for number in range(first, first + count)
        ]
        network = self.average.network if self.average else bare(self.generator)
        labels = label.expand(count, -1).to(self.device)
        made = network(latents.to(self.device), labels, self._bands(torch.cat(noise)))
        result: NDArray[np.float32] = made.float().cpu().numpy()
        return result


def build(
    config: Config, kind: SignalKind, *, seed: int, device: str | torch.device = "cpu"
) -> TextureGANLearner:
    """Return an untrained model for signals of ``kind``."""
    return TextureGANLearner(config, kind, seed=seed, device=device)
