"""Training of the texture GAN on whitened recordings; signals of any length, from labels that may be mixed."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping, Sequence
from functools import partial
from typing import Any

import numpy as np
import torch
from numpy.typing import NDArray
from torch import Tensor, nn

from tactogram.features.signal_crops import SignalCrops
from tactogram.model import (
    Condition,
    Example,
    Limit,
    SignalKind,
    Stage,
    check_condition,
    limits_within,
    material_weights,
)
from tactogram.models.texture_gan.config import Config
from tactogram.models.texture_gan.networks import Generator, split_bands
from tactogram.models.texture_gan.texture_statistics import energy_distance, spread_within, statistics
from tactogram.models.texture_gan.whitening import Whitening
from tactogram.nn import MovingAverage, WaveDiscriminator
from tactogram.nn.initial_weights import bare, fixed
from tactogram.nn.labels import NUMBERS, Labels
from tactogram.nn.latent_pieces import given_latent
from tactogram.signal import Signal
from tactogram.signal.band_levels import BandLevels
from tactogram.training.seeds import child_generator, child_rng, child_seed
from tactogram.training.wave_gan_learner import NO_LATENTS, LabelledCrops, WaveGANLearner

MEASURED = 512
"""Crops that the spread of the texture statistics is measured on."""
MATCHED, MATCHED_LENGTHS = 16, 4
"""Most recordings of a material, and most of each, in lengths of the networks, that the bands are matched to."""
FIRST_HEARD = 1
"""The piece that a signal begins with: the filters settle on the one before."""


class TextureGANLearner(WaveGANLearner[Config]):
    """Filters of each material, a generator and a critic of whitened signals, and levels of bands."""

    saved = (
        *WaveGANLearner.saved,
        *("whitening", "conditions=labels", "spread", "bands=band_levels", "average"),
    )

    def __init__(
        self, config: Config, kind: SignalKind, *, seed: int, device: str | torch.device = "cpu"
    ) -> None:
        kind.require_materials("texture_gan")
        rates = (config.generator_learning_rate, config.learning_rate)
        super().__init__(config, kind, rates=rates, seed=seed, device=device)
        self.whitening = Whitening(config, kind)
        self.band_levels = BandLevels(kind.rate) if config.match_bands else None
        self.labels = Labels(config.conditions)
        self.spread = torch.ones(0)
        self.average = MovingAverage(self.generator, config.moving_average) if config.moving_average else None

    def networks(self) -> tuple[Generator, WaveDiscriminator]:
        size = {"axes": len(self.kind.axes), "labels": len(self.materials) + len(self.config.conditions)}
        return Generator(self.config, **size), self.config.discriminator(**size)

    @property
    def generating_network(self) -> nn.Module:
        return self.average.network if self.average else super().generating_network

    def setup(self, fabric: Any) -> None:
        super().setup(fabric)
        if self.average:
            self.average.network.to(self.device)

    def stages(self, examples: Sequence[Example]) -> tuple[Stage, ...]:
        self.kind.check_all_present(examples)
        match = (Stage("match", 1),) if self.band_levels else ()
        return Stage("fit", 1), Stage("train", self.config.steps), *match

    def batches(
        self, stage: Stage, examples: Sequence[Example], *, seed: int, start: int = 0
    ) -> Iterator[Any]:
        if stage.name != "train":
            yield examples
            return
        crops = self.crops(examples)
        for step in range(start, stage.steps):
            yield step, *self.batch_of_step(crops, step, seed=seed)

    def crops(self, examples: Sequence[Example]) -> SignalCrops:
        return SignalCrops(
            examples, self.config.length, self.config.overlap_samples, lead=self.whitening.lead
        )

    def prepared(self, crops: Sequence[tuple[Example, NDArray[np.float32]]]) -> LabelledCrops:
        places = [self.materials.index(str(example.material)) for example, _ in crops]
        x = np.stack([self.whitening.whitened(crop, m) for (_, crop), m in zip(crops, places, strict=True)])
        classes = np.eye(len(self.materials), dtype=np.float32)[places]
        values = [self.labels.numbers(example.condition) for example, _ in crops]
        return x, np.hstack((classes, np.array(values, np.float32).reshape(len(crops), -1)))

    def noise(self, count: int, seeds: tuple[int, int] | None = None) -> tuple[Tensor]:
        """Return white noise in bands, (batch, axis, time, band)."""
        shape = len(self.kind.axes), self.config.length
        if seeds is None:
            white = torch.randn(count, *shape)
        else:
            seed, first = seeds
            generators = (child_generator(seed, "noise", first + k) for k in range(count))
            white = torch.cat([torch.randn(1, *shape, generator=generator) for generator in generators])
        return (split_bands(white.to(self.device), self.config.noise_bands),)

    def step(self, stage: Stage, batch: Any) -> dict[str, float]:
        if stage.name == "fit":
            return self._fit(batch)
        if stage.name == "match" and self.band_levels:
            return self._match(batch, self.band_levels)
        number, *arrays = batch
        self.scale_rates((1 + math.cos(math.pi * number / stage.steps)) / 2)
        real, label = (torch.from_numpy(array).to(self.device) for array in arrays)
        figures = self.update_discriminator(real, label) if self.config.adversarial else {}
        figures |= self.update_generator(real, label)
        if self.average:
            self.average.update(bare(self.generator))
        return {name: value.item() for name, value in figures.items()}

    def update_generator(self, real: Tensor, label: Tensor) -> dict[str, Tensor]:
        """Gulrajani et al. 2017, Algorithm 1, lines 11 and 12, and the energy distance between statistics."""
        config, figures = self.config, dict[str, Tensor]()
        loss = torch.zeros((), device=self.device)
        generated = self.make(label)
        if config.adversarial:
            with fixed(self.discriminator):
                figures["generator_loss"] = -self.discriminator(generated, label).float().mean()
            loss = loss + config.adversarial * figures["generator_loss"]
        if config.statistics:
            spread = self.spread.to(self.device)
            ours, again, theirs = (statistics(x) / spread for x in (generated, self.make(label), real))
            figures["statistics"] = energy_distance(theirs, ours, again)
            loss = loss + config.statistics * figures["statistics"]
        self.descend(0, loss)
        return figures

    def _fit(self, examples: Sequence[Example]) -> dict[str, float]:
        """Measure filters, numeric conditions, and the spread of the statistics within a material."""
        for example in examples:
            self.kind.check(example.signal)
        self.labels.fit(examples)
        figures = self.whitening.fit(examples)
        if self.config.statistics:
            x, label = self.prepared(self.crops(examples).draw(0, MEASURED, partial(child_rng, 0)))
            classes = torch.from_numpy(label[:, : len(self.materials)]).argmax(1)
            self.spread = spread_within(statistics(torch.from_numpy(x)), classes)
        return figures

    def _match(self, examples: Sequence[Example], levels: BandLevels) -> dict[str, float]:
        """Measure the bands of recordings, and of signals generated for their conditions."""
        members = ([e for e in examples if e.material == name] for name in self.materials)
        levels.measure(self._to_match(levels, index, some) for index, some in enumerate(members))
        return {"band_correction_db": levels.correction_db()}

    def _to_match(
        self, levels: BandLevels, index: int, examples: Sequence[Example]
    ) -> tuple[list[NDArray[np.floating]], list[NDArray[np.floating]]]:
        """Return recordings of a material and a generated signal for each, all longer than the filters."""
        weights = np.eye(len(self.materials))[index]
        examples = [e for e in examples if len(e.signal) > 2 * levels.reach] or examples
        recorded, generated = list[NDArray[np.floating]](), list[NDArray[np.floating]]()
        for number, example in enumerate(examples[:: -(-len(examples) // MATCHED)]):
            x = example.signal.samples[:, : MATCHED_LENGTHS * self.config.length]
            length = max(x.shape[1], 2 * levels.reach + 1)
            recorded.append(np.pad(x, ((0, 0), (0, length - x.shape[1])), mode="wrap"))
            label, seed = self.labels.label(weights, example.condition), child_seed(0, "match", index, number)
            generated.append(self._signal(label, weights, length, seed=seed).samples)
        return recorded, generated

    def generate(self, condition: Condition, *, seconds: float | None = None, seed: int) -> Signal:
        """Return a signal; one longer than the networks' is made of pieces of new latents, crossfaded.

        ``material`` weights are not scaled. ``latent``, float array of shape (latents,) in -1 to 1, is that of the
        piece that the signal begins with. Speed and force default to the median of the recordings; beyond their range
        they count as the nearest recorded one, and are refused if not in ``config.conditions``.
        """
        check_condition(condition, needs=("material",), takes=(*NUMBERS, "latent"))
        self.labels.check(condition)
        weights = material_weights(condition, self.materials)
        label = self.labels.label(weights, condition)
        length = self.config.length if seconds is None else max(1, round(seconds * self.kind.rate))
        latents = given_latent(condition, self.config.latents, piece=FIRST_HEARD)
        if self.band_levels is None or not self.band_levels.measured:
            return self._signal(label, weights, length, seed=seed, given=latents)
        signal = self._signal(label, weights, length + 2 * self.band_levels.reach, seed=seed, given=latents)
        return signal.with_samples(self.band_levels.apply(signal.samples, weights).astype(np.float32))

    def limits(self, condition: Condition) -> list[Limit]:
        return limits_within(condition, self.labels.limited)

    def _signal(
        self,
        label: Tensor,
        weights: NDArray[np.float64],
        length: int,
        *,
        seed: int,
        given: Mapping[int, Tensor] = NO_LATENTS,
    ) -> Signal:
        """Return ``length`` samples from the networks through the filters."""
        white = self.crossfaded(label, self.whitening.settle + length, seed=seed, given=given)
        return self.whitening.coloured(white, weights)


build = TextureGANLearner
