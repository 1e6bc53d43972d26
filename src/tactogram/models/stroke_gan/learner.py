"""Generator (Table III) and training of Saga et al., Sec. III; signals of any length, from labels that may be mixed."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from dataclasses import replace
from itertools import pairwise
from typing import Any

import numpy as np
import torch
import torch.nn.functional as F
from numpy.typing import NDArray
from scipy.signal import lfilter
from torch import Tensor, nn

from tactogram.features.signal_crops import SignalCrops
from tactogram.model import Condition, Example, Saved, SignalKind, Stage, check_condition, material_weights
from tactogram.models.stroke_gan.config import Config
from tactogram.nn import WaveDiscriminator, glorot_linear, strided_conv_transpose
from tactogram.nn.initial_weights import fixed
from tactogram.nn.latent_pieces import given_latent
from tactogram.signal import Signal
from tactogram.signal.autoregressive_fit import fit_autoregressive
from tactogram.training.wave_gan_learner import LabelledCrops, WaveGANLearner

Array = NDArray[np.float64]
BINS = 1 << 16
"""Resolution of a signal's range: parts of its largest deviation."""


class Generator(nn.Module):
    """Latent and label to a signal of A axes, 3 in the paper; C labels, one per class.

    Each axis is convolved separately, with shared filters.
    """

    def __init__(self, config: Config, *, axes: int, labels: int) -> None:
        super().__init__()
        self.leak = config.leak
        self.shape = (axes, config.points, config.channels[0])
        self.dense = glorot_linear(config.latent + labels, axes * config.points * config.channels[0])
        self.layers = nn.ModuleList(
            strided_conv_transpose(coarse, fine, kernel=config.kernel, stride=config.stride)
            for coarse, fine in pairwise((*config.channels, 1))
        )

    def forward(self, latent: Tensor, label: Tensor) -> Tensor:
        """Return signals within -1 to 1: (batch, latent) and (batch, C) -> (batch, axis, time)."""
        h = self.dense(torch.cat((latent, label), 1))  # B, A * 16 * 1024
        h = h.unflatten(1, self.shape).flatten(0, 1).transpose(1, 2)  # B A, 1024, 16
        for layer in self.layers:
            h = layer(F.leaky_relu(h, self.leak))  # B A, C / 2, 4 T; the last B A, 1, 16384
        return torch.tanh(h.view(latent.shape[0], self.shape[0], -1))  # B, A, 16384


class Scaling(Saved):
    """One offset and one scale per axis for the whole data set.

    Per axis, so that a weak axis is not drowned by a strong one; the same for all materials, to keep their levels.
    The share ``within_range`` of the samples fits the range of tanh and the rest is clipped; 1 clips nothing. Before,
    an autoregressive filter of order ``whitening`` takes the mean spectrum of all recordings out.
    """

    saved = ("offset", "scale")

    def __init__(self, kind: SignalKind, within_range: float = 1.0, whitening: int = 0) -> None:
        self.kind, self.within_range, self.whitening = kind, within_range, whitening
        self.offset = np.zeros(len(kind.axes))
        self.scale = np.ones(len(kind.axes))
        self.taps = np.ones((len(kind.axes), 1))

    def _named(self) -> list[tuple[str, str]]:
        return super()._named() + [("taps", "taps")] * bool(self.whitening)

    def fit(self, examples: Sequence[Example]) -> dict[str, float]:
        """Measure the mean and the range of each axis; return the scales and the share that is clipped."""
        count = sum(len(example.signal) for example in examples)
        total = sum(example.signal.samples.sum(axis=1, dtype=np.float64) for example in examples)
        self.offset = np.asarray(total / count)
        if self.whitening:
            signals = [example.signal for example in examples]
            self.taps = fit_autoregressive(signals, order=self.whitening).coefficients
        largest = np.max([self._deviation(example).max(axis=1) for example in examples], axis=0)
        self.scale = np.where(largest > 0, largest, 1.0)
        if self.within_range < 1:
            self.scale *= [self._range(examples, axis) for axis in range(len(self.scale))]
        over = sum(
            int((self._deviation(example) > self.scale[:, None] * (1 + 1e-6)).sum()) for example in examples
        )
        scales = {f"scale_{axis}": float(s) for axis, s in zip(self.kind.axes, self.scale, strict=True)}
        return {**scales, "clipped_share": over / (count * len(self.scale))}

    def _deviation(self, example: Example) -> Array:
        signal = self.whitened(example.signal)
        deviation: Array = np.abs(signal.samples.astype(np.float64) - self.offset[:, None])
        return deviation

    def _range(self, examples: Sequence[Example], axis: int) -> float:
        """Return the share of the largest deviation that holds ``within_range`` of the samples."""
        counts = np.zeros(BINS, np.int64)
        for example in examples:
            bins = (self._deviation(example)[axis] / self.scale[axis] * BINS).astype(np.int64)
            counts += np.bincount(np.minimum(bins, BINS - 1), minlength=BINS)
        within = np.cumsum(counts) / counts.sum()
        return float((np.searchsorted(within, self.within_range) + 1) / BINS)

    def whitened(self, signal: Signal) -> Signal:
        """Return a recording without the mean spectrum, as `scaled` takes it."""
        order = self.taps.shape[1] - 1
        if not order:
            return signal
        deviation = np.pad(signal.samples - self.offset[:, None], ((0, 0), (order, 0)), mode="symmetric")
        rows = [np.convolve(row, taps, "valid") for row, taps in zip(deviation, self.taps, strict=True)]
        return signal.with_samples(np.array(rows) + self.offset[:, None])

    def scaled(self, x: NDArray[np.float32]) -> NDArray[np.float32]:
        """Return samples, shape (axis, time), within -1 to 1."""
        y = (x - self.offset[:, None]) / self.scale[:, None]
        return np.clip(y, -1, 1).astype(np.float32)

    def unscaled(self, y: NDArray[np.float32]) -> Signal:
        """Return samples within -1 to 1, shape (axis, time), as a signal."""
        rows = zip(y * self.scale[:, None], self.taps, strict=True)
        x = np.array([lfilter([1.0], taps, row) for row, taps in rows]) + self.offset[:, None]
        return self.kind.signal(x.astype(np.float32))


class StrokeGANLearner(WaveGANLearner[Config]):
    """Generator and discriminator of Saga et al., and the scale of the data set."""

    saved = (*WaveGANLearner.saved, "domain=scaling")

    def __init__(
        self, config: Config, kind: SignalKind, *, seed: int, device: str | torch.device = "cpu"
    ) -> None:
        kind.require_materials("stroke_gan")
        rates = (config.learning_rate, config.learning_rate)
        super().__init__(config, kind, rates=rates, seed=seed, device=device)
        self.scaling = Scaling(kind, config.within_range, config.whitening)

    def networks(self) -> tuple[Generator, WaveDiscriminator]:
        size = {"axes": len(self.kind.axes), "labels": len(self.materials)}
        return Generator(self.config, **size), self.config.discriminator(**size)

    def crops(self, examples: Sequence[Example]) -> SignalCrops:
        config = self.config
        repetitions = config.repetitions if config.repetition == "repeat" else None
        overlap, covers = config.overlap_samples, config.epoch_covers
        if config.whitening:
            examples = [
                replace(example, signal=self.scaling.whitened(example.signal)) for example in examples
            ]
        return SignalCrops(examples, config.length, overlap, repetitions, covers=covers)

    def prepared(self, crops: Sequence[tuple[Example, NDArray[np.float32]]]) -> LabelledCrops:
        classes = [self.materials.index(str(example.material)) for example, _ in crops]
        x = np.stack([self.scaling.scaled(crop) for _, crop in crops])
        return x, np.eye(len(self.materials), dtype=np.float32)[classes]

    def stages(self, examples: Sequence[Example]) -> tuple[Stage, ...]:
        self.kind.check_all_present(examples)
        config, crops = self.config, len(self.crops(examples).epoch)
        steps = config.steps or math.ceil(config.epochs * crops / (config.batch_size * config.critic_updates))
        updates = {"critic": config.critic_updates, "generator": config.generator_updates}
        return Stage("fit", 1), Stage("train", steps, updates)

    def batches(
        self, stage: Stage, examples: Sequence[Example], *, seed: int, start: int = 0
    ) -> Iterator[Any]:
        if stage.name == "fit":
            yield examples
            return
        crops = self.crops(examples)
        for step in range(start, stage.steps):
            yield self.batch_of_step(crops, step, seed=seed, updates=self.config.critic_updates)

    def step(self, stage: Stage, batch: Any) -> dict[str, float]:
        if stage.name == "fit":
            for example in batch:
                self.kind.check(example.signal)
            return self.scaling.fit(batch)
        size = self.share.size(self.config.batch_size)
        real, label = (torch.from_numpy(part).to(self.device) for part in batch)
        figures: dict[str, Tensor] = {}
        for update in range(self.config.critic_updates):
            part = slice(update * size, (update + 1) * size)
            figures |= self.update_discriminator(real[part], label[part])
        for update in range(self.config.generator_updates):
            start = update % self.config.critic_updates * size
            figures |= self.update_generator(label[start : start + size])
        return {name: value.item() for name, value in figures.items()}

    def update_generator(self, label: Tensor) -> dict[str, Tensor]:
        """Gulrajani et al. 2017, Algorithm 1, lines 11 and 12."""
        with fixed(self.discriminator):
            loss = -self.discriminator(self.make(label), label).float().mean()
        self.descend(0, loss)
        return {"generator_loss": loss}

    def generate(self, condition: Condition, *, seconds: float | None = None, seed: int) -> Signal:
        """Return a signal; one longer than the networks' is made of pieces of new latents, crossfaded.

        ``material`` weights are not scaled: {a: 1, b: 0.3} and {a: 0.7, b: 0.3} are the paper's two ways of mixing.
        ``latent``, float array of shape (latent,) in -1 to 1, is that of the first piece.
        """
        check_condition(condition, needs=("material",), takes=("latent",))
        label = torch.tensor(material_weights(condition, self.materials), dtype=torch.float32)
        latents = given_latent(condition, self.config.latent)
        length = self.config.length if seconds is None else max(1, round(seconds * self.kind.rate))
        return self.scaling.unscaled(self.crossfaded(label, length, seed=seed, given=latents))


build = StrokeGANLearner
