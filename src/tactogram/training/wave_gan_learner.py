"""Learner of conditional WaveGANs: crops of recordings, a critic with gradient penalty, signals of any length.

References
----------
- Saga, S. et al. (2020). Machine learning-based classification and generation of vibrotactile information. Int. J.
  Adv. Networks and Services 13(3-4), 115-124. Tables III and IV.
- Gulrajani, I. et al. (2017). Improved training of Wasserstein GANs. NeurIPS 30. Algorithm 1.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from functools import partial
from types import MappingProxyType
from typing import Annotated, Any, ClassVar, Generic, Self, TypeVar

import numpy as np
import torch
from numpy.typing import NDArray
from pydantic import Field, PositiveInt, model_validator
from torch import Tensor, nn

from tactogram.features.signal_crops import SignalCrops
from tactogram.model import Example, Model, ModelConfig, SignalKind
from tactogram.nn import WaveDiscriminator, gradient_penalty
from tactogram.nn.adversarial_networks import AdversarialNetworks
from tactogram.nn.initial_weights import bare
from tactogram.nn.latent_pieces import crossfaded_pieces, uniform_latents
from tactogram.training.seeds import child_rng, torch_seeded

Beta = Annotated[float, Field(ge=0, lt=1)]


class WaveGANConfig(ModelConfig):
    """Settings that these models share; defaults are those of Saga et al. 2020."""

    latent: int = Field(default=100, gt=0)
    """Uniform random numbers in -1 to 1 per signal. Saga et al., Table III, "Uniform(-1,1)", "100+C"."""
    points: int = Field(default=16, gt=0)
    """Samples per axis after the generator's dense layer. Saga et al., Table III, "(n, 3, 16, 1024)"."""
    channels: tuple[PositiveInt, ...] = Field(default=(1024, 512, 256, 128, 64), min_length=1)
    """Channels after the dense layer and before each transposed convolution; backwards, those of the discriminator.
    Saga et al., Table III."""
    kernel: int = Field(default=25, gt=1)
    """Along time only. Saga et al., Table III, "(1, 25, …)"."""
    stride: int = Field(default=4, gt=1)
    """Saga et al., Table III, "Stride = (1, 4)"."""
    leak: float = Field(default=0.2, ge=0, lt=1)
    """Slope of LeakyReLU below 0. Saga et al., Table III."""
    phase_shuffle: int = Field(default=2, ge=0)
    """Saga et al., Table IV."""
    batch_size: int = Field(default=64, gt=1)
    """Saga et al., Table IV."""
    penalty: float = Field(default=10.0, ge=0, allow_inf_nan=False)
    """Weight of the gradient penalty. Gulrajani et al. 2017, Algorithm 1; Saga et al., Table IV, "WGAN-GP λ"."""
    betas: tuple[Beta, Beta] = (0.5, 0.9)
    """β1 and β2 of Adam. Saga et al., Table IV."""
    overlap: float = Field(default=0.125, gt=0, le=0.5)
    """Crossfade between the pieces of a longer signal, or of a recording joined to itself, as a share of the networks'
    length. Ours."""

    @property
    def latents(self) -> int:
        """Random numbers per signal."""
        return self.latent

    @property
    def length(self) -> int:
        """Samples per axis of the networks' signals: 16,384 as published."""
        return self.points * math.prod([self.stride] * len(self.channels))

    @property
    def overlap_samples(self) -> int:
        """Samples of a crossfade."""
        return round(self.overlap * self.length)

    @model_validator(mode="after")
    def _fits(self) -> Self:
        if self.kernel < self.stride:
            raise ValueError(f"kernel {self.kernel} must not be shorter than stride {self.stride}")
        if self.phase_shuffle >= self.points * self.stride:
            raise ValueError(f"phase_shuffle {self.phase_shuffle} is as long as what it moves; lower it")
        return self

    def discriminator(self, *, axes: int, labels: int) -> WaveDiscriminator:
        """Return the discriminator of Table III: the generator's layers backwards, with phase shuffle between them."""
        return WaveDiscriminator(
            channels=self.channels,
            points=self.points,
            kernel=self.kernel,
            stride=self.stride,
            leak=self.leak,
            phase_shuffle=self.phase_shuffle,
            axes=axes,
            labels=labels,
        )


ConfigT = TypeVar("ConfigT", bound=WaveGANConfig)
LabelledCrops = tuple[NDArray[np.float32], NDArray[np.float32]]
NO_LATENTS: Mapping[int, Tensor] = MappingProxyType({})


class WaveGANLearner(AdversarialNetworks, Model, Generic[ConfigT]):
    """Networks, critic updates, validation and signals; a model adds its generator, crops and generator updates.

    ``rates`` are the learning rates of generator and discriminator.
    """

    config: ConfigT
    kind: SignalKind
    divides_batches = True
    saved: ClassVar[tuple[str, ...]] = ("materials", "generator", "discriminator")

    def __init__(
        self,
        config: ConfigT,
        kind: SignalKind,
        *,
        rates: tuple[float, float],
        seed: int,
        device: str | torch.device = "cpu",
    ) -> None:
        Model.__init__(self, config, kind, seed=seed, device=device)
        with torch_seeded(seed, "weights"):
            networks = self.networks()
        adam = partial(torch.optim.Adam, betas=config.betas)
        AdversarialNetworks.__init__(self, *networks, rates=rates, optimiser=adam, device=device)

    def networks(self) -> tuple[nn.Module, nn.Module]:
        """Return generator and discriminator with initial weights from torch's own generator."""
        raise NotImplementedError

    def crops(self, examples: Sequence[Example]) -> SignalCrops:
        """Return the crops of ``examples``."""
        raise NotImplementedError

    def prepared(self, crops: Sequence[tuple[Example, NDArray[np.float32]]]) -> LabelledCrops:
        """Return crops as the networks see them, (crop, axis, time), and their labels, (crop, C)."""
        raise NotImplementedError

    def noise(self, count: int, seeds: tuple[int, int] | None = None) -> tuple[Tensor, ...]:
        """Return further inputs of the generator for ``count`` signals; none by default.

        Drawn from torch's own generator, or in use from ``seeds``: a signal's seed and the number of its first piece.
        """
        return ()

    @property
    def generating_network(self) -> nn.Module:
        """The network that generates signals in use."""
        network: nn.Module = bare(self.generator)
        return network

    def setup(self, fabric: Any) -> None:
        """Hand networks and optimisers to Lightning Fabric."""
        AdversarialNetworks.setup(self, fabric)
        Model.setup(self, fabric)

    def batch_of_step(self, crops: SignalCrops, step: int, *, seed: int, updates: int = 1) -> LabelledCrops:
        """Return this process's share of the batches of a step, one for each of ``updates``, prepared."""
        count = updates * self.config.batch_size
        numbers = self.share.places(np.arange(step * count, (step + 1) * count), self.config.batch_size)
        return self.prepared(crops.at(numbers.tolist(), partial(child_rng, seed)))

    def batch(self, examples: Sequence[Example], start: int, count: int, *, seed: int) -> LabelledCrops:
        """Return crops ``start`` to ``start + count``, prepared."""
        return self.prepared(self.crops(examples).draw(start, count, partial(child_rng, seed)))

    def update_discriminator(self, real: Tensor, label: Tensor) -> dict[str, Tensor]:
        """Gulrajani et al. 2017, Algorithm 1, lines 4 to 9."""
        with torch.no_grad():
            generated = self.make(label)
        scores = self.discriminator(torch.cat((real, generated)), label.repeat(2, 1)).float()
        wasserstein = scores[: len(real)].mean() - scores[len(real) :].mean()
        with self.autocast():  # Fabric's wrapper allows no gradient but by its own backward
            critic = bare(self.discriminator)
            penalty = gradient_penalty(lambda x: critic(x, label).float(), real, generated)
        self.descend(1, self.config.penalty * penalty - wasserstein)
        return {"wasserstein": wasserstein, "penalty": penalty}

    def make(self, label: Tensor) -> Tensor:
        """Return a signal per row of ``label``, with latents and noise from torch's own generator."""
        latent = torch.rand(len(label), self.config.latents) * 2 - 1
        signals: Tensor = self.generator(latent.to(self.device), label, *self.noise(len(label)))
        return signals.float()

    @torch.no_grad()
    def validate(self, examples: Sequence[Example]) -> dict[str, float]:
        """Return the critic's estimate of the Wasserstein distance from generated to unseen crops.

        If it is well above that of the training crops, the critic, and so the generator, has memorised them.
        """
        if not examples:
            return {}
        crops = self.batch(examples, 0, max(len(examples), 16), seed=0)
        x, label = (torch.from_numpy(part).to(self.device) for part in crops)
        with torch_seeded(0, "validate"):
            real = bare(self.discriminator)(x, label).mean()
            fake = bare(self.discriminator)(self.make(label), label).mean()
        return {"wasserstein_unseen": (real - fake).item()}

    def crossfaded(
        self, label: Tensor, length: int, *, seed: int, given: Mapping[int, Tensor] = NO_LATENTS
    ) -> NDArray[np.float32]:
        """Return ``length`` samples of the generator, (axis, time): pieces of new latents, crossfaded.

        ``given`` are the latents of some pieces, by number; each other piece has a seed of its own.
        """

        @torch.inference_mode()
        def pieces(first: int, count: int) -> NDArray[np.float32]:
            rng = partial(child_rng, seed, "latent")
            latents = uniform_latents(first, count, self.config.latents, given=given, rng=rng)
            labels = label.expand(count, -1).to(self.device)
            noise = self.noise(count, (seed, first))
            generated = self.generating_network(latents.to(self.device), labels, *noise)
            result: NDArray[np.float32] = generated.float().cpu().numpy()
            return result

        return crossfaded_pieces(pieces, self.kind, length=length, overlap=self.config.overlap_samples)
