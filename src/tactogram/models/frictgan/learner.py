"""Training of FrictGAN in the paper's order of updates; friction over displacement, or played at a finger's speed."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from dataclasses import asdict
from functools import partial
from typing import Any

import numpy as np
import torch
import torch.nn.functional as F
from torch import Tensor

from tactogram.errors import ParameterError
from tactogram.features.registered_pairs import FrictionBatch, Part, RegisteredPairs, scaled
from tactogram.model import (
    Condition,
    Example,
    Model,
    SignalKind,
    Stage,
    check_condition,
)
from tactogram.models.frictgan.config import Config
from tactogram.models.frictgan.fabric_evaluation import evaluate_fabrics, summary
from tactogram.models.frictgan.journey import journey, spliced
from tactogram.models.frictgan.networks import LEAST, Critic, Generator, magnitudes_of
from tactogram.nn.adversarial_networks import AdversarialNetworks
from tactogram.nn.initial_weights import bare, fixed
from tactogram.signal import Image, Signal
from tactogram.signal.displacement import played
from tactogram.signal.resampling import resample
from tactogram.training.seeds import child_generator, child_rng, torch_seeded

MEASURED = 512
"""Most windows that the scale of the magnitudes is measured on."""
EVALUATED = 64
"""Most windows that `validate` uses."""
AT_ONCE = 4
"""Windows that are generated at once."""


class FrictGANLearner(AdversarialNetworks, Model):
    """Generator and critic of FrictGAN, Sec. 3; a photograph gives one spectrogram per axis."""

    config: Config
    kind: SignalKind
    divides_batches = True
    saved = ("scale", "mm_per_pixel", "generator", "critic=discriminator")

    def __init__(
        self, config: Config, kind: SignalKind, *, seed: int, device: str | torch.device = "cpu"
    ) -> None:
        Model.__init__(self, config, kind, seed=seed, device=device)
        self.windows, self.spectrogram = config.photo_windows(), config.spectrogram()
        self.scale = torch.ones(len(kind.axes), config.bins, 1)
        self.mm_per_pixel: float | None = None
        self.training_examples: Sequence[Example] = ()
        with torch_seeded(seed, "weights"):
            generator, critic = (net(config, axes=len(kind.axes)) for net in (Generator, Critic))
        rates = (config.learning_rate, config.critic_learning_rate or config.learning_rate)
        # RMSprop: Sec. 4; alpha and eps as TensorFlow's, which the authors used.
        optimiser = partial(torch.optim.RMSprop, alpha=0.9, eps=1e-7)
        AdversarialNetworks.__init__(self, generator, critic, rates=rates, optimiser=optimiser, device=device)

    def setup(self, fabric: Any) -> None:
        AdversarialNetworks.setup(self, fabric)
        Model.setup(self, fabric)

    def stages(self, examples: Sequence[Example]) -> tuple[Stage, ...]:
        pairs, self.training_examples = self.pairs(examples), examples
        steps = self.config.steps or self.config.epochs * math.ceil(len(pairs) / self.config.batch_size)
        return Stage("fit", 1), Stage("train", steps)

    def pairs(self, examples: Sequence[Example], part: Part | None = "train") -> RegisteredPairs:
        """Return the pairs of ``part`` in ``examples``; under protocol ``examples`` all pairs are in every part."""
        for example in examples:
            self.kind.check(example.signal)
            mean = float(example.signal.samples.mean())
            if self.config.nonnegative and mean <= 0:
                raise ParameterError(
                    f"recording {example.id} has a mean of {mean:.3g}, a coefficient of friction is never below 0: "
                    "set prepare.stream=friction, or config.nonnegative=false"
                )
        if self.config.protocol == "examples":
            part = None
        return RegisteredPairs(examples, self.windows, part=part, mm_per_pixel=self.mm_per_pixel)

    def batches(
        self, stage: Stage, examples: Sequence[Example], *, seed: int, start: int = 0
    ) -> Iterator[Any]:
        if stage.name == "fit":
            yield (examples,)
            return
        pairs = self.pairs(examples)
        count = self.config.batch_size * (self.config.critic_updates if self.config.adversarial else 1)
        for number, places in enumerate(grouped(pairs.order(seed), count, skip=start), start=start):
            own = self.share.places(places, self.config.batch_size)
            batch = pairs.batch(own.tolist(), seed=number)
            yield batch.photo, batch.friction, number / stage.steps

    def step(self, stage: Stage, batch: Any) -> dict[str, float]:
        if stage.name == "fit":
            return self._fit(batch[0])
        photos, frictions = (part.to(self.device) for part in batch[:2])
        real = self.as_learned(frictions)
        self.generator.train(), self.discriminator.train()
        self.lower_rates(batch[2], constant=self.config.constant)
        figures: dict[str, Tensor] = {}
        size = self.share.size(self.config.batch_size)
        for first in range(0, len(photos), size):
            part = slice(first, first + size)
            if self.config.adversarial:
                figures |= self._update_critic(photos[part], real[part])
        figures |= self._update_generator(photos[part], real[part])
        return {name: float(value) for name, value in figures.items()}

    def _update_critic(self, photo: Tensor, real: Tensor) -> dict[str, Tensor]:
        """Arjovsky et al. 2017, Algorithm 1, lines 3 to 7; or the code's cross-entropy, also clipped."""
        with torch.no_grad():
            generated = self._make(photo)
        scores = self.discriminator(photo, real).float(), self.discriminator(photo, generated).float()
        if self.config.loss == "wasserstein":
            loss = scores[1].mean() - scores[0].mean()  # eq. (2)
            figures = {"wasserstein": -loss.detach()}
        else:
            loss = _cross_entropy(scores[0], 1.0) + _cross_entropy(scores[1], 0.0)
            figures = {"critic_loss": loss.detach()}
        self.descend(1, loss)
        with torch.no_grad():
            for weight in self.discriminator.parameters():
                weight.clamp_(-self.config.clip, self.config.clip)
        return figures

    def _update_generator(self, photo: Tensor, real: Tensor) -> dict[str, Tensor]:
        """Algorithm 1, lines 9 to 11, with the L1 distance of eq. (3)."""
        generated = self._make(photo)
        distance = (generated - real).abs().mean()
        loss, figures = self.config.l1 * distance, {"l1": distance.detach()}
        if self.config.adversarial:
            with fixed(self.discriminator):
                score = self.discriminator(photo, generated).float()
            verdict = -score.mean() if self.config.loss == "wasserstein" else _cross_entropy(score, 1.0)
            loss = loss + self.config.adversarial * verdict
            figures["adversarial"] = verdict.detach()
        self.descend(0, loss)
        return figures

    def _make(self, photo: Tensor) -> Tensor:
        """Return spectrograms on the networks' scale, with noise from torch's own generator."""
        noise = torch.randn(len(photo), self.config.noise).to(photo) if self.config.noise else None
        generated: Tensor = self.generator(photo, noise).float()
        return generated

    def _fit(self, examples: Sequence[Example]) -> dict[str, float]:
        """Store the scale of the photographs, and measure that of the magnitudes."""
        pairs = self.pairs(examples)
        self.mm_per_pixel = pairs.mm_per_pixel
        figures = {"pairs": float(len(pairs)), "registered_share": float(np.mean(pairs.registered))}
        if self.config.scale != "none":
            places = np.unique(np.linspace(0, len(pairs) - 1, MEASURED).astype(int)).tolist()
            total = torch.zeros_like(self.scale)
            for first in range(0, len(places), 32):
                batch = pairs.batch(places[first : first + 32])
                total += self.spectrogram.encode(batch.friction).mean(-1, keepdim=True).sum(0)
            self.scale = (total / len(places)).clamp_min(1e-6)
        return figures

    def as_learned(self, friction: Tensor) -> Tensor:
        """Return spectrograms on the networks' scale."""
        parts = self.spectrogram.encode(friction) / self.scale.to(friction.device)
        return torch.log1p(parts / LEAST) if self.config.scale == "log" else parts

    def _outside(self, inside: Tensor) -> Tensor:
        """Return the magnitudes of network outputs, on the processor."""
        return magnitudes_of(inside.float().cpu(), self.scale, self.config)

    def validate(self, examples: Sequence[Example]) -> dict[str, float]:
        """Return ``l1`` of the magnitudes of unseen windows, and the paper's ``mse`` of friction.

        The ``l1`` is relative to each frequency's mean, with ``scale = "none"`` absolute. Both signals of the ``mse``
        have the same initial phases; see `fabric_evaluation.FabricResult`.
        """
        if not examples and self.config.protocol != "examples":
            examples = self.training_examples  # other windows of the same photographs
        if not examples:
            return {}
        part: Part | None = "validation" if self.config.shares[1] else "test"
        pairs = self.pairs(examples, part)
        places = np.unique(np.linspace(0, len(pairs) - 1, EVALUATED).astype(int)).tolist()
        generated, real = self.spectra(pairs.batch(places))
        squared = (self.spectrogram.decode(generated) - self.spectrogram.decode(real)).square().mean()
        return {"l1": float(((generated - real) / self.scale).abs().mean()), "mse": float(squared)}

    def spectra(self, batch: FrictionBatch, *, seed: int = 0) -> tuple[Tensor, Tensor]:
        """Return generated and recorded magnitudes of pairs, each float32, (pair, axis, bin, frame)."""
        return self.mixed(batch.photo, seed=seed), self.spectrogram.encode(batch.friction)

    def mixed(
        self, photo: Tensor, other: Tensor | None = None, share: float = 0.0, *, seed: int = 0
    ) -> Tensor:
        """Return the magnitudes generated from photographs, or from a mix with ``other`` ones (`Generator.forward`)."""
        pieces = []
        for first in range(0, len(photo), AT_ONCE):
            part = slice(first, first + AT_ONCE)
            noise = torch.stack([self._noise(seed, first + k) for k in range(len(photo[part]))])
            second = None if other is None else other[part]
            pieces.append(self._magnitude(photo[part], noise, second, share))
        return torch.cat(pieces)

    @torch.inference_mode()
    def _magnitude(
        self, photo: Tensor, noise: Tensor, other: Tensor | None = None, share: float = 0.0
    ) -> Tensor:
        network = bare(self.generator).eval()
        magnitude: Tensor = network(
            photo.to(self.device),
            noise.to(self.device) if self.config.noise else None,
            other=None if other is None else other.to(self.device),
            share=share,
        )
        return self._outside(magnitude)

    def _noise(self, seed: int, number: int) -> Tensor:
        return torch.randn(self.config.noise, generator=child_generator(seed, "noise", number))

    def evaluate_as_published(self, examples: Sequence[Example]) -> dict[str, Any]:
        """Return the paper's squared error per fabric, and distances independent of phase; see `fabric_evaluation`."""
        figures = evaluate_fabrics(self, examples, part="test" if self.config.window_protocol else None)
        return {
            "mean": summary(figures),
            "per_material": {name: asdict(each) for name, each in figures.items()},
        }

    def generate(self, condition: Condition, *, seconds: float | None = None, seed: int) -> Signal:
        """Return the friction of a finger that moves over a photograph from its left edge, along its middle.

        A run over displacement returns one window over displacement. With ``speed_mm_s`` it is played at that speed,
        over time, for any number of ``seconds``: the finger turns round at the photograph's edges. ``seconds`` without
        a speed is refused, since a displacement has none. For a run over time, ``seconds`` is the length, and a speed
        is refused.
        """
        check_condition(condition, needs=("image",), takes=("speed_mm_s", "latent"))
        speed = condition.get("speed_mm_s")
        over_displacement = self.kind.domain == "displacement"
        if speed is not None and not over_displacement:
            raise ParameterError(
                "speed_mm_s: this run's signals are over time, at the speeds of its recordings; omit it"
            )
        if speed is not None and not (np.isfinite(speed) and speed > 0):
            raise ParameterError.must("speed_mm_s", "be > 0", speed)
        if seconds is not None and over_displacement and speed is None:
            raise ParameterError(
                "seconds of a signal over displacement need a speed: give speed_mm_s, or omit them"
            )
        image = condition["image"]
        if not isinstance(image, Image):
            raise ParameterError.must("image", "be a photograph (Image)", type(image).__name__)
        if self.mm_per_pixel is not None:
            image = scaled(image, self.mm_per_pixel)
        rate = self.rate_of(image)
        # Samples per s, or per mm over displacement.
        travel = rate if not over_displacement or speed is None else rate * speed
        count = self.windows.samples if seconds is None else max(1, round(seconds * travel))
        samples = self._along(image, count + 1, self._latent(condition), seed)
        signal = Signal(samples, rate, self.kind.unit, self.kind.axes, self.kind.domain)
        if speed is not None:
            signal = played(signal, float(speed), self.config.playback_rate)
            length_s = count / travel if seconds is None else seconds
            return self._nonnegative(signal.cut(0, max(1, round(length_s * signal.rate))))
        return self._nonnegative(resample(signal.cut(0, count), self.kind.rate))

    def rate_of(self, image: Image) -> float:
        """Return the rate of the network's signals: samples per mm if photographs are registered."""
        if self.kind.domain == "time" or self.mm_per_pixel is None:
            return self.kind.rate
        return self.windows.samples / (self.windows.pixels * self.mm_per_pixel)

    def _along(self, image: Image, count: int, latent: Tensor | None, seed: int) -> np.ndarray:
        """Return at least ``count`` samples, float32, (axis, time): one phase recovery for all windows."""
        half = (self.config.frames - 1) // 2
        number = max(0, math.ceil((count - self.windows.samples) / (half * self.config.hop)))
        places = journey(
            image.pixels.shape[1], self.windows.pixels, half / (self.config.frames - 1), number + 1
        )
        pieces = []
        for first in range(0, len(places), AT_ONCE):
            some = places[first : first + AT_ONCE]
            cut = [self.windows.window(image, left)[:, :: -1 if back else 1] for left, back in some]
            noise = [self._noise(seed, first + k) for k in range(len(some))]
            if first == 0 and latent is not None:
                noise[0] = latent
            pieces.append(self._magnitude(self.windows.tensor(cut), torch.stack(noise)))
        long = spliced(torch.cat(pieces), half)
        spectrogram = self.config.model_copy(update={"frames": long.shape[-1]}).spectrogram()
        recovered = spectrogram.decode(long, seed=int(child_rng(seed, "phase").integers(2**31)))
        return np.asarray(recovered.numpy())

    def _nonnegative(self, signal: Signal) -> Signal:
        """Return the signal clipped at 0, below which resampling may go."""
        if not self.config.nonnegative:
            return signal
        return signal.with_samples(np.maximum(signal.samples, 0))

    def _latent(self, condition: Condition) -> Tensor | None:
        if condition.get("latent") is None:
            return None
        latent = np.asarray(condition["latent"], np.float32)
        if latent.shape != (self.config.noise,) or not np.isfinite(latent).all() or not self.config.noise:
            raise ParameterError.must(
                "latent",
                f"be {self.config.noise} finite numbers, as drawn from N(0, 1), got shape {latent.shape}",
            )
        return torch.from_numpy(latent)


def grouped(places: Iterator[int], count: int, *, skip: int = 0) -> Iterator[list[int]]:
    """Yield ``places``, ``count`` at a time, without the first ``skip`` groups."""
    for _ in range(skip * count):
        next(places)
    while True:
        yield [next(places) for _ in range(count)]


build = FrictGANLearner


def _cross_entropy(scores: Tensor, target: float) -> Tensor:
    return F.binary_cross_entropy_with_logits(scores, torch.full_like(scores, target))
